"""Put a test signal between two components of a system, and run it."""

from __future__ import annotations

import io
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from flexsat.arrays import Array
from flexsat.fmu.export import build_fmu
from flexsat.ports.units import UNITS
from lockstep import Component, Connection, InputError, System, read_signals, simulate
from lockstep.fmi.model_description import read_description
from lockstep.system.component import Value

from .multisine import Multisine

NAME = "injector"  # of the component that is put in
SHELL = "flexsat.fmu.python.test_signal_injector:Injector"
Progress = Callable[[float, float], None]


@dataclass(frozen=True, slots=True, kw_only=True)
class Opened:
    """A system with a test signal between controller and plant, and how to excite it."""

    system: System
    multisine: Multisine
    channels: tuple[str, ...]  # inputs of the plant, in the order of the test signal's elements


def loop_channels(system: System, controller: str, plant: str) -> list[Connection]:
    """Return the Real connections from controller to plant; raise InputError if there are none."""
    producer = read_description(system.component(controller))
    found = [c for c in system.connections if (c.from_component, c.to_component) == (controller, plant)]
    found = [c for c in found if c.output not in producer.variables or producer.variables[c.output].type == "Real"]
    if not found:
        raise InputError(
            f"{controller} -> {plant}: no such connection, so there is no loop to open; name both ends by "
            "--controller and --plant"
        )
    return found


def open_loop_at(system: System, controller: str, plant: str, multisine: Multisine, folder: Path) -> Opened:
    """Return the system with an injector between controller and plant; its FMU is built into `folder`.

    The injector runs with the controller, right after it: a delay on the way to the plant stays between the injector
    and the plant. The loop is the same wherever a delay common to all channels stands.
    """
    wires = loop_channels(system, controller, plant)
    producer = system.component(controller)
    if any(component.name == NAME for component in system.components):
        raise InputError(f"system {system.name}: already has a component {NAME}; rename it")
    units = read_description(system.component(plant)).variables
    unit = next((v.unit.name for c in wires if (v := units.get(c.input)) and v.unit and v.unit.name in UNITS), "1")
    held = io.BytesIO()
    np.savez(held, waveform=multisine.values, channels=len(wires), period=multisine.sample, unit=unit)
    folder.mkdir(parents=True, exist_ok=True)
    fmu = build_fmu(SHELL, folder / f"{NAME}.fmu", {"waveform.npz": held.getvalue()}, NAME).path
    injector = Component(
        name=NAME, source=fmu.absolute(), period=producer.period, offset=producer.offset, kind="sampled"
    )
    first = 1 if producer.kind == "continuous" else 0  # the value that is true at the start of the injector's step
    kept = [connection for connection in system.connections if connection not in wires]
    for number, wire in enumerate(wires, start=1):
        kept.append(
            replace(
                wire, to_component=NAME, input=f"signal[{number}]", delay=first, convert_units=_converts(wire, unit)
            )
        )
        kept.append(
            Connection(
                from_component=NAME,
                output=f"after[{number}]",
                to_component=plant,
                input=wire.input,
                delay=max(0, wire.delay - first),
                convert_units=False,
            )
        )
    position = [component.name for component in system.components].index(controller) + 1
    components = (*system.components[:position], injector, *system.components[position:])
    return Opened(
        system=replace(system, components=components, connections=tuple(kept)),
        multisine=multisine,
        channels=tuple(wire.input for wire in wires),
    )


def run_experiment(
    opened: Opened,
    folder: Path,
    direction: Sequence[float] | Array,
    amplitude: float,
    settle: int,
    periods: int,
    overrides: Mapping[str, Value] | None = None,
    progress: Progress | None = None,
) -> tuple[Array, Array]:
    """Excite the loop along a direction; return the signals before and after the injection.

    Parameters
    ----------
    opened : what `open_loop_at` returns
    folder : results folder of the run
    direction : (m,) share of each channel
    amplitude : peak of the test signal, in the unit of the plant's inputs
    settle : periods that are left out at the start
    periods : that are kept
    overrides : values by `component.parameter`

    Returns
    -------
    before, after : (periods, samples, m)
        The controller's output and the plant's input, without their slow drift.

    Raises
    ------
    InputError
        If settle is less than one period: the drift is estimated from it.
    """
    if settle < 1 or periods < 2:
        raise InputError(f"settle {settle} and periods {periods}: must be at least 1 and 2")
    before, after = record_injection(opened, folder, direction, amplitude, settle + periods, overrides, progress)
    drift = _drift(before)[settle:]  # the test signal has none: it is the same in both
    return before[settle:] - drift, after[settle:] - drift


def record_injection(
    opened: Opened,
    folder: Path,
    direction: Sequence[float] | Array,
    amplitude: float,
    periods: int,
    overrides: Mapping[str, Value] | None = None,
    progress: Progress | None = None,
) -> tuple[Array, Array]:
    """Run from rest and return the signals before and after the injection, (periods, samples, m) each, as they are."""
    sample, samples = opened.multisine.sample, len(opened.multisine.values)
    given: dict[str, Value] = {f"{NAME}.amplitude": amplitude}
    given |= {f"{NAME}.direction[{k}]": float(share) for k, share in enumerate(direction, start=1)}
    simulate(
        opened.system,
        folder,
        stop_time=round(periods * samples * sample, 9),
        overrides={**(overrides or {}), **given},
        record=[f"{NAME}.before", f"{NAME}.after"],
        record_period=sample,
        progress=progress,
        overwrite=True,
    )
    signals = read_signals(folder)
    shape = (periods, samples, len(opened.channels))
    rows = slice(periods * samples)  # without the one at the stop time
    return signals[f"{NAME}.before"][rows].reshape(shape), signals[f"{NAME}.after"][rows].reshape(shape)


def _drift(signal: Array) -> Array:
    """Return a straight line for each period and channel, with the slope of the means of the periods around it.

    What has not settled yet, attitude and bias after minutes, would jump from the end of a period to its start and
    leak into every line.
    """
    slope = np.gradient(signal.mean(axis=1), axis=0)
    share = np.arange(signal.shape[1]) / signal.shape[1] - 0.5
    return np.asarray(slope[:, None, :] * share[None, :, None])


def _converts(wire: Connection, unit: str) -> bool:
    """Without a unit that the injector can carry, the two ends are taken as they are."""
    return wire.convert_units and unit != "1"
