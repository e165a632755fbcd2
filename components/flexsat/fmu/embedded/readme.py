"""Write what accompanies the exported controller: a page and a Makefile."""

from __future__ import annotations

import textwrap
from collections.abc import Iterable, Sequence

from ...ports.table import PortTable
from ...runtime.controller_parameters import ControllerMatrices
from .header import EXACT, Precision, field, parameter_ports

OPTIONS = "-std=c99 -O2 -ffp-contract=off -Wall -Wextra -Wconversion"

_PAGE = """# Flight controller as C99

{about} No FMI, no heap, no files, no standard output; libm, and
memcpy, memmove and memset of libc. No variable outlives a call but those in the memory that is given, so there may be
any number of controllers.

    make && ./example          # a slew by half a degree with a rigid spacecraft, on a host

Or without make: `cc {options} *.c -lm -o example`. The target needs all C files but `example.c` and
`rigid_spacecraft.c`; the interface is `flexsat_controller.h`. All names that the linker sees begin with `flexsat_`.

## Use
1. `static double memory[FLEXSAT_MEMORY_SIZE / sizeof(double)];` {memory} bytes are enough for any parameters;
   `flexsat_prepare` refuses less than it needs. It samples the design for the parameters, which takes a while: call it
   when the software starts.
2. `flexsat_init` once, then `flexsat_step` every {milliseconds:g} ms ({rate:g} Hz). The controller counts its steps:
   there is no time to give, and none that loses digits.
3. Fill in all inputs before each step. `star_tracker_valid` is 1 in the step for which there is a new sample, every
   {phases} steps nominally; fewer are no fault. The torque is for the wheels' motors until the next step.
4. `flexsat_save` and `flexsat_restore` continue bit for bit, on another computer of the same kind too. A saved state
   has {saved} bytes, in the order of this machine: the same build alone reads it.
5. A command is a change of `command_rotation` or `command_start_time`. One that is refused is tried again at each step
   until it is accepted or changed back; the wheels are commanded all the same.

A step takes the same time at almost every call. Exceptions are steps that plan a slew: when a command arrives, when
one turn of several begins, and with `slew_guidance = FLEXSAT_QP` (an interior-point method of 200 unknowns, tens of
milliseconds on a workstation) or keep-out cones above all. Plan these before the loop by `flexsat_init`, or give the
step the time.

## Inputs
{inputs}

`{exact}` are doubles in any case.

## Outputs
{outputs}

## Parameters
Start from `flexsat_default_parameters`.

{parameters}
{floats}"""

_FLOATS = """
## What is in floats
The products of a step: Kalman filter, regulator, known delays, jitter, and the torques. Doubles are: attitudes and the
star tracker's measurement (a float holds an attitude to 0.01 arcsec), sines and cosines of wheel angles, times, the
reference, which is summed up over a slew, the planning of slews and what `flexsat_prepare` computes. A processor
without doubles in hardware emulates them there: some 10^3 operations a step, and the reference's {reference} products
while `reference_smoothed` is 0.
"""


def readme(
    table: PortTable, matrices: ControllerMatrices, about: str, precision: Precision, memory: int, saved: int
) -> str:
    """Return the page README.md; arguments as of `controller_header`."""
    inputs = [port for port in table if port.causality == "input"]
    outputs = [table["wheel.torque"], table["reference.torque"]]
    rows = [(field(p), p.length, p.unit if p.kind == "real" else "0 or 1", p.description) for p in outputs]
    states = len(matrices.reference_a)
    for kind in ("reference", "estimate"):
        rows.append((kind, states, "", f"{kind} in the order of the linear state; see the header"))
    return _PAGE.format(
        about=about,
        options=OPTIONS,
        memory=f"{memory:,}",
        saved=f"{saved:,}",
        milliseconds=1e3 * matrices.period,
        rate=1.0 / matrices.period,
        phases=len(matrices.gain_fine),
        inputs=_table((field(p), p.length, p.unit if p.kind == "real" else "0 or 1", p.description) for p in inputs),
        exact="`, `".join(name.replace(".", "_") for name in EXACT),
        outputs=_table(rows),
        parameters=_table(
            (field(p), p.length, p.unit if p.kind == "real" else "", p.description) for p in parameter_ports(table)
        ),
        floats=_FLOATS.format(reference=states * states) if precision == "float" else "",
    )


def makefile(sources: Sequence[str], example: Sequence[str]) -> str:
    """Return the Makefile of the example."""
    listed = " \\\n    ".join(textwrap.wrap(" ".join(sources), 100))
    own = " ".join(name for name in example if name.endswith(".c"))
    return "\n".join(
        [
            "# The example on a host. A target compiles TARGET with its own compiler.",
            "CC ?= cc",
            f"CFLAGS = {OPTIONS}",
            f"TARGET = {listed}",
            "",
            f"example: $(TARGET) {own}",
            "\t$(CC) $(CFLAGS) -o $@ $^ -lm",
            "",
        ]
    )


def _table(rows: Iterable[tuple[str, int, str, str]]) -> str:
    lines = ["| field | numbers | unit | |", "|---|---|---|---|"]
    lines += [f"| `{name}` | {length} | {unit} | {text} |" for name, length, unit, text in rows]
    return "\n".join(lines)
