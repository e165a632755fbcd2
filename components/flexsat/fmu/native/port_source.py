"""Write the port table of a component as C."""

from __future__ import annotations

from ...ports.table import KINDS, PortTable


def port_places(table: PortTable) -> str:
    """Return the header ports.h: where a component finds its ports.

    For a port `wheel.torque` it has `PORT_WHEEL_TORQUE`, the place of its first scalar among those of its kind, and
    `PORT_WHEEL_TORQUE_SIZE`, their number.
    """
    lines = [
        "/* Generated: places of the ports among the scalars of their kind, and how many each has. */",
        "#ifndef FLEXSAT_PORTS_H",
        "#define FLEXSAT_PORTS_H",
        "",
        *(f"#define {kind.upper()}_COUNT {len(table.of_kind(kind))}" for kind in KINDS),
        "",
    ]
    for port in table:
        name = f"PORT_{port.name.upper().replace('.', '_')}"
        lines += [f"#define {name} {table.span(port.name).start}", f"#define {name}_SIZE {port.length}"]
    return "\n".join([*lines, "", "#endif"]) + "\n"
