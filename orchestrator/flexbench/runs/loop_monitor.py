"""Watch the loop around flexsat's plant while it runs: its torque, wheel speeds, attitude and deformation."""

from __future__ import annotations

import io
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from zipfile import ZipFile

import numpy as np
from numpy.typing import NDArray

from flexsat.arrays import Array
from flexsat.description.wheel_set import WheelSet
from flexsat.fmu.python.load_matrices import MODEL_FILE
from flexsat.parameters import DEFAULT_DESIGN, Wheel
from flexsat.runtime.rotations import error_angle
from flexsat.variants import chosen_by
from lockstep.errors import InputError
from lockstep.fmi.safe_zip import open_file
from lockstep.results.monitor import Found
from lockstep.results.read_run_record import read_run_record
from lockstep.results.signal_patterns import matching
from lockstep.system.component import Component
from lockstep.system.system import Connection, System

from ..loop.loop_parts import LoopParts, Parameters, flag_of, loop_parts, number_of, numbers_of
from ..loop.spacecraft import spacecraft_of
from .commands import Command, commanded_attitude
from .loop_events import LoopEvents, Rows

KINDS = {
    "torque-saturation": "torque saturation",
    "speed-band-left": "wheel speed outside its band",
    "limit-cycle": "limit cycle",
    "divergence": "divergence",
}

NEEDED = (
    "plant.attitude.mrp",
    "plant.rate",
    "plant.rms_deformation",
    "controller.wheel.torque",
    "controller.reference.mrp",
    "controller.reference.rate",
    "controller.reference.torque",
)  # recorded signals, for the numbers of a loop and its monitor
_LOST_BY = ("limit-cycle", "divergence")
NO_LIMIT = 1e6  # N.m or rad/s: none that a wheel reaches


def means_lost(found: Mapping[str, Any]) -> bool:
    """Return whether something that was found makes a run a lost one; a saturated torque if it lasts to the end."""
    lasts = found["event"] == "torque-saturation" and bool(found.get("until_the_end"))
    return found["event"] in _LOST_BY or lasts


@dataclass(frozen=True, slots=True, kw_only=True)
class _Columns:
    """Names of the recorded signals to look at; none where some of them are not recorded."""

    torque: tuple[str, ...]
    guidance: tuple[str, ...]
    speed: tuple[str, ...]
    attitude: tuple[str, ...]
    reference: tuple[str, ...]
    rate: tuple[str, ...]
    deformation: tuple[str, ...]


@dataclass(slots=True, kw_only=True)
class LoopMonitor:
    """Looks at the rows of one run; a `lockstep.results.monitor.Monitor`."""

    events: LoopEvents
    columns: _Columns
    nominal: Array | None  # (n,) [rad/s]
    command: Command | None  # refers the pointing error where no reference is recorded

    def rows(self, time: NDArray[np.float64], columns: Mapping[str, NDArray[Any]]) -> Iterator[Found]:
        """Yield what these rows show."""
        torque, guidance, speed, attitude, reference, rate, bent = (
            _stacked(columns, names)
            for names in (
                self.columns.torque,
                self.columns.guidance,
                self.columns.speed,
                self.columns.attitude,
                self.columns.reference,
                self.columns.rate,
                self.columns.deformation,
            )
        )
        if reference is None and attitude is not None and self.command is not None:
            reference = commanded_attitude(time, self.command, np.zeros(3))
        return self.events.rows(
            Rows(
                time=time,
                torque=torque,
                guidance=guidance,
                speed=None if speed is None or self.nominal is None else speed - self.nominal,
                error=None if attitude is None or reference is None else error_angle(attitude, reference),
                rate=rate,
                deformation=None if bent is None else bent[:, 0],
            )
        )

    def end(self) -> Iterable[Found]:
        """Return what is known when no more rows come."""
        return self.events.end()

    def summary(self) -> Sequence[Mapping[str, object]]:
        """Return a table for each kind that was found."""
        return self.events.summary()


def watch_loop(system: System, parameters: Parameters, recorded: Sequence[str]) -> LoopMonitor | None:
    """Return what watches the loop around flexsat's plant; None for a system without it.

    It is a `lockstep.results.monitor.Watch`: the argument `watch` of `lockstep.simulate`.
    """
    parts = loop_parts(system)
    if parts is None:
        return None
    plant, known, wheels = parts.plant, set(recorded), len(parts.torques)
    torque_limit, band = _limits(parts, parameters)

    def columns(component: str, port: str, size: int | None) -> tuple[str, ...]:
        elements = (0,) if size is None else range(1, size + 1)
        names = [f"{component}.{parts.name(port, element)}" for element in elements]
        return tuple(names) if known.issuperset(names) else ()

    constant = _has_substitute(parts, "reference.mrp")
    controller = "" if parts.controller is None else parts.controller.name
    commanded = tuple(f"{one.from_component}.{one.output}" for one in parts.torques if not converts(one))
    complete = wheels > 0 and len(commanded) == wheels and known.issuperset(commanded)
    return LoopMonitor(
        events=LoopEvents(
            torque_limit=torque_limit,
            speed_band=band,
            details={"component": plant.name},
        ),
        columns=_Columns(
            torque=columns(plant.name, "wheel.torque", wheels) or (commanded if complete else ()),
            guidance=columns(controller, "reference.torque", wheels),
            speed=columns(plant.name, "wheel.speed", wheels),
            attitude=columns(plant.name, "attitude.mrp", 3),
            reference=() if constant else columns(controller, "reference.mrp", 3),
            rate=columns(plant.name, "rate", 3),
            deformation=columns(plant.name, "rms_deformation", None),
        ),
        nominal=_nominal_speed(parts, parameters),
        command=_command(parts, parameters),
    )


def _limits(parts: LoopParts, parameters: Parameters) -> tuple[Array, Array]:
    """Return the torque limit [N.m] and the speed band [rad/s] of each wheel, (n,): those of plant and controller."""
    wheels, ports = len(parts.torques), parts.ports
    try:
        nominal = spacecraft_of(parts.configuration, parts.plant.source).configurations[DEFAULT_DESIGN].wheel_set
    except InputError:  # its file is lost; plant and controller have limits of their own
        nominal = WheelSet.of([Wheel(torque_limit=NO_LIMIT, speed_band=NO_LIMIT)] * wheels)

    def factors_of(component: Component, port: str) -> Array:
        names = [parts.name(port, k + 1) for k in range(wheels)]
        # an FMU of an earlier version has none
        return np.array([1.0 if one is None else one for one in numbers_of(component, names, parameters)])

    known = number_of(parts.plant, parts.name("wheel.torque_limit"), parameters)
    limit, band = nominal.torque_limit, nominal.speed_band
    if known is not None:
        limit = known * factors_of(parts.plant, "wheel.torque_limit_factor")
    if ports is None:
        return limit, band
    own = [number_of(ports, parts.name(port), parameters) for port in ("wheel.torque_limit", "wheel.speed_band")]
    factors = [factors_of(ports, port) for port in ("wheel.torque_limit_factor", "wheel.speed_band_factor")]
    if own[0] is not None:
        limit = np.minimum(limit, own[0] * factors[0])
    return limit, band * factors[1] if own[1] is None else own[1] * factors[1]


def _has_substitute(parts: LoopParts, port: str) -> bool:
    """Return whether an adapter puts a constant in the place of a port that its controller lacks."""
    adapter = None if parts.controller is None else parts.controller.adapter
    return adapter is not None and any(matching(text, [parts.name(port, 1)]) for text in adapter.substitutes)


def _command(parts: LoopParts, parameters: Parameters) -> Command | None:
    """Return what is commanded from the start on; None where no controller of the plant's kind is or was there.

    A controller of others keeps what the system commands the one that it replaces, unless its adapter has the command.
    """
    controller, ports = parts.controller, parts.ports
    if controller is None or ports is None:
        return None
    own, rotation = parameters.get(controller.name, {}), parts.name("command.rotation")
    given = any(name.startswith(rotation) for name in own)
    entries = () if controller.adapter is None else controller.adapter.entries
    if not given and (ports is controller or any(p.startswith(rotation) for entry in entries for p in entry.ports)):
        return None  # a file feeds it
    values = {ports.name: own if given else ports.parameters}
    names = [parts.name("command.rotation", axis) for axis in (1, 2, 3)] + [parts.name("command.start_time")]
    x, y, z, start = (one or 0.0 for one in numbers_of(ports, names, values))
    return Command(time=start, rotation=(x, y, z))


def converts(connection: Connection) -> bool:
    """Return whether a connection changes what it transfers, other than in its unit."""
    return any(not hop.converts_units_only for hop in connection.hops)


def _nominal_speed(parts: LoopParts, parameters: Parameters) -> Array | None:
    """Return the nominal wheel speeds of the plant (n,) [rad/s], from its FMU; None if that does not hold them."""
    variant = chosen_by(lambda port: flag_of(parts.plant, parts.name(port), parameters))
    with open_file(parts.plant.source, parts.plant.archive, parts.plant.name) as stream, ZipFile(stream) as archive:
        name = f"resources/{MODEL_FILE}"
        if name not in archive.namelist():
            return None
        with np.load(io.BytesIO(archive.read(name))) as arrays:
            key = f"{variant.name}.nominal_speed"
            return np.asarray(arrays[key]) if key in arrays else None


def _stacked(columns: Mapping[str, NDArray[Any]], names: Sequence[str]) -> Array | None:
    return np.stack([columns[name] for name in names], axis=1) if names else None


def print_found(folder: Path) -> None:
    """Print what a run's monitor found, if it had one."""
    from lockstep.cli.outcome import remark

    record, _ = read_run_record(folder)
    if "found" in record:
        remark(*found_lines(record["found"]))


def found_lines(found: Sequence[Mapping[str, Any]]) -> list[str]:
    """Return the lines of a run's summary: what the monitor found, from run.toml, and what it did not."""
    lines = [_line(one) for one in found]
    absent = [text for event, text in KINDS.items() if all(one["event"] != event for one in found)]
    return [*lines, f"no {', no '.join(absent)}"] if absent else lines


def _line(one: Mapping[str, Any]) -> str:
    text = KINDS[one["event"]] + (f" ({one['quantity']})" if "quantity" in one else "")
    times = "once" if one["count"] == 1 else f"{one['count']} times, first"
    lasts = f"for {one['seconds']:.4g} s" + (" in all" if one["count"] > 1 else "")
    until = f"{lasts}, to the end" if one.get("until_the_end") else lasts
    level = f": up to {one['torque']:.3g} N.m at {one['frequency']:.3g} Hz" if "torque" in one else ""
    return f"{text}: {times} at {one['first']:.6g} s, {until}{level}"
