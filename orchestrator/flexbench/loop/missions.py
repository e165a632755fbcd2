"""Write the system files of missions: the closed loop with an environment, and with thrusters and a manager too."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from flexsat.design.chain import Designs, build_designs
from flexsat.errors import BuildError
from flexsat.fmu.build_missions import FOLDER, build_missions, mission_data
from flexsat.fmu.native.sources import native_folder
from flexsat.parameters import ENVIRONMENT_PERIOD, ConfigurationName
from flexsat.ports import environment, mission, thrusters
from flexsat.ports.table import FmiVersion, Port
from lockstep import Component, Connection, System, write_ssd
from lockstep.errors import InputError
from lockstep.plan.timeline_svg import timeline_svg
from lockstep.system.clock import Time, nanoseconds
from lockstep.whole_file import write_whole

from ..html.document import as_markdown
from ..html.render import as_html
from ..icd.contents import TIMELINE_FILE, TIMELINE_TICKS
from ..icd.mission_contents import mission_icd_blocks
from .build_manifest import add_to_manifest
from .build_options import STANDARD, BuildOptions
from .spacecraft import design_file, read_file
from .systems import build_system, component_periods, ports_of, scalar_names

ORDER = ("sensors", "controller", "mission", "environment", "thrusters", "plant")  # in which a tick steps them
SYSTEMS = ("environment", "mission")  # names of the files, without .ssd
# Slews use a small share of wide limits: the rate of the slews of the paper, and room in the controller's limits for
# wheels that take over what a failed one held.
BAND_FACTOR, AUTHORITY = 40.0, 0.02

# (from, to, ports at the source, ports at the destination, delay in steps of the source)
Wires = tuple[tuple[str, str, tuple[str, ...], tuple[str, ...], int], ...]
_EXTERNAL = ("external.force", "external.torque")
_DISTURBANCE = ("disturbance.force", "disturbance.torque")
_MANAGED = ("estimate.mrp", "reference.mrp", "reference.rate", "reference.torque")
_TO_CONTROLLER = ("encoder.speed", "command.rotation", "command.start_time", "applied.wheel.torque", "applied.valid")
_FROM_MISSION = ("shown.encoder.speed", *_TO_CONTROLLER[1:])
WIRES: dict[str, Wires] = {
    "environment": (
        ("plant", "environment", ("attitude.quaternion",), ("attitude.quaternion",), 1),
        ("environment", "plant", _EXTERNAL, _EXTERNAL, 0),
    ),
    "mission": (
        ("plant", "environment", ("attitude.quaternion",), ("attitude.quaternion",), 1),
        ("environment", "thrusters", _EXTERNAL, _DISTURBANCE, 0),
        ("thrusters", "plant", _EXTERNAL, _EXTERNAL, 0),
        ("mission", "thrusters", ("thrust.command",), ("thrust.command",), 0),
        ("controller", "mission", ("wheel.torque",), ("demanded.wheel.torque",), 0),
        ("controller", "mission", _MANAGED, _MANAGED, 0),
        ("sensors", "mission", ("encoder.speed", "star_tracker.valid"), ("encoder.speed", "star_tracker.valid"), 0),
        ("mission", "plant", ("wheel.torque",), ("wheel.torque",), 0),
        ("mission", "controller", _FROM_MISSION, _TO_CONTROLLER, 1),
    ),
}
RECORD = {
    "environment": ("environment.external.torque",),
    "mission": (
        "environment.external.torque", "thrusters.external.torque", "thrusters.thrust.impulse",
        "thrusters.thrust.angular_impulse", "mission.mode", "mission.timeline.done", "mission.momentum",
        "mission.pointing.error", "mission.wheel.status", "mission.wheel.torque", "mission.star_tracker.outage",
    ),
}  # fmt: skip


def write_missions(
    designs: Designs,
    folder: Path,
    print_line: Callable[[str], None] = print,
    options: BuildOptions = STANDARD,
) -> list[Path]:
    """Build the FMUs of missions of a spacecraft into `folder`/<name>/missions, and write their systems there.

    The FMUs of its plant, sensors and controller are those in `folder`/<name>. The manifest of `folder` gets all files,
    and an interface document stands beside them. Parameters are those of `flexbench.loop.build.build_all`; of the
    options, versions and platforms of FMUs in C count.
    """
    built = build_missions(designs, folder, print_line, versions_in_c=options.in_c, platforms=options.platforms)
    config = designs.corrected.config
    layout = folder / config.name
    paths = []
    for fmi in (None, *(version for version in options.in_c if version == "3.0")):
        for name in SYSTEMS:
            path = _folder(layout / FOLDER, fmi) / f"{name}.ssd"
            write_ssd(mission_system(designs, name, layout, fmi), path)
            paths.append(path)
    identities = [(one.path.relative_to(folder).as_posix(), one.guid, one.sha256) for one in built.values()]
    system = mission_system(designs, "mission", layout)
    blocks = mission_icd_blocks(designs.corrected, mission_ports(designs), system, identities)
    for file, text in (
        ("ICD.md", as_markdown(blocks)),
        (TIMELINE_FILE, timeline_svg(system, TIMELINE_TICKS)),
        ("ICD.html", as_html(blocks)),
    ):
        write_whole(layout / FOLDER / file, text.encode())
        paths.append(layout / FOLDER / file)
    for path in paths:
        print_line(str(path))
    add_to_manifest(config, built, paths, folder)
    return paths


def _folder(folder: Path, fmi: FmiVersion | None) -> Path:
    """Return the folder of the FMUs in C of a version of FMI; None: of those in Python."""
    return folder if fmi is None else native_folder(folder, fmi)


def write_all_missions(
    names: Sequence[ConfigurationName],
    files: Sequence[Path],
    folder: Path,
    print_line: Callable[[str], None] = print,
    options: BuildOptions = STANDARD,
) -> None:
    """Write the missions of spacecraft that have been built: those of files, or the built-in ones of some names.

    Raises
    ------
    InputError
        If a file is refused, or this machine lacks a compiler.
    """
    try:
        designs = [design_file(read_file(path), path) for path in files] or [build_designs(name) for name in names]
        for one in designs:
            write_missions(one, folder, print_line, options)
    except BuildError as error:
        raise InputError(str(error)) from None


def mission_system(designs: Designs, name: str, layout: Path, fmi: FmiVersion | None = None) -> System:
    """Return a system of SYSTEMS, whose FMUs are in the folder of a layout: in Python, or in C of a version of FMI."""
    base = build_system(designs, "fine_pointing", _folder(layout, fmi))
    known = _all_ports(designs)
    periods = _periods(designs)
    loop = [component.name for component in base.components]
    named = dict.fromkeys(component for wire in WIRES[name] for component in wire[:2])
    added = [component for component in named if component not in loop]
    wires = [connection for wire in WIRES[name] for connection in _connect(known, periods, base.tick, wire)]
    fed = {(one.to_component, one.input) for one in wires}
    kept = [one for one in base.connections if (one.to_component, one.input) not in fed]
    components = {one.name: _without(one, fed) for one in base.components}
    if name == "mission":
        controller = components["controller"]
        factors = BAND_FACTOR * designs.corrected.controller.speed_band_factor
        limits = {f"wheel.speed_band_factor[{k}]": factor for k, factor in enumerate(factors.tolist(), start=1)}
        limits["slew.authority"] = AUTHORITY
        components["controller"] = replace(controller, parameters={**controller.parameters, **limits})
    for component in added:
        components[component] = Component(
            name=component,
            source=_folder(layout / FOLDER, fmi) / f"{component}.fmu",
            period=periods[component],
            kind="sampled",
            parameters={},
        )
    return replace(
        base,
        name=f"{designs.corrected.config.name}-{name}",
        components=tuple(components[one] for one in ORDER if one in components),
        connections=(*kept, *wires),
        record=(*base.record, *RECORD[name]),
        ports=tuple(port for port in base.ports if (port.component, port.variable) not in fed),
    )


def _without(component: Component, fed: set[tuple[str, str]]) -> Component:
    """Return a component without values for inputs that are connected."""
    left = {name: value for name, value in component.parameters.items() if (component.name, name) not in fed}
    return replace(component, parameters=left)


def mission_ports(designs: Designs) -> dict[str, tuple[Port, ...]]:
    """Return the ports of the components of missions."""
    data = mission_data(designs.corrected)
    return {"mission": mission.ports(data), "environment": environment.ports(data), "thrusters": thrusters.ports(data)}


def _all_ports(designs: Designs) -> dict[str, Mapping[str, Port]]:
    more = {component: {port.name: port for port in ports} for component, ports in mission_ports(designs).items()}
    return dict(ports_of(designs)) | more


def _periods(designs: Designs) -> dict[str, Time]:
    periods = component_periods(designs)
    return {
        **periods,
        "mission": periods["controller"],
        "thrusters": periods["controller"],
        "environment": nanoseconds(ENVIRONMENT_PERIOD, "period of the environment"),
    }


def _connect(
    known: Mapping[str, Mapping[str, Port]],
    periods: dict[str, Time],
    tick: Time,
    wire: tuple[str, str, tuple[str, ...], tuple[str, ...], int],
) -> Sequence[Connection]:
    source, target, outputs, inputs, steps = wire
    delay = steps * periods[source] // tick
    return [
        Connection(from_component=source, output=output, to_component=target, input=into, delay=delay)
        for one, other in zip(outputs, inputs, strict=True)
        for output, into in zip(scalar_names(known[source][one]), scalar_names(known[target][other]), strict=True)
    ]
