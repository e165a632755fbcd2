"""Read the signals of any loop that holds a plant of flexsat, named as in its own systems."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from lockstep import Signals, read_signals
from lockstep.array_names import array_of, elements_of
from lockstep.results.read import open_batches
from lockstep.results.read_run_record import read_run_record

from . import histories
from .commands import command_of, commanded_attitude
from .loop_names import LoopNames, loop_names

# what the numbers of a loop are computed from, and the component that outputs it
_WANTED = (histories.ATTITUDE, histories.RATE, histories.DEFORMATION, histories.TORQUE,
           histories.ATTITUDE_REFERENCE, histories.RATE_REFERENCE, histories.TORQUE_REFERENCE)  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True)
class LoopSignals:
    """The recorded signals of a loop, under the names of flexsat's own systems."""

    names: LoopNames
    signals: Signals
    reference: str  # what the pointing error refers to


def read_loop(folder: Path) -> LoopSignals | None:
    """Return the signals of a run's loop as far as they were recorded, None if it has no plant of flexsat.

    Where the controller outputs no reference, or an adapter puts a constant in its place, the commanded attitude is
    the reference, and zero is that of the rate.
    """
    record, _ = read_run_record(folder)
    names = loop_names(record)
    if names is None:
        return None
    signals = _without_last_row(_renamed(_read_wanted(folder, names), names), record)
    if _has_reference(signals, record, names):
        return LoopSignals(names=names, signals=signals, reference="the reference")
    command = command_of(record, names.controller) if names.controller is not None else None
    known = len(signals.time) > 0 and len(elements_of(histories.ATTITUDE, signals.columns)) == len("xyz")
    attitude = commanded_attitude(signals.time, command, signals[histories.ATTITUDE][0] if known else np.zeros(3))
    columns = {k: v for k, v in signals.columns.items() if not k.startswith("controller.reference.")}
    columns |= {f"{histories.ATTITUDE_REFERENCE}[{i + 1}]": attitude[:, i] for i in range(3)}
    columns |= {f"{histories.RATE_REFERENCE}[{i + 1}]": np.zeros(len(attitude)) for i in range(3)}
    what = "the commanded attitude" if command is not None or np.any(attitude) else "attitude zero"
    return LoopSignals(names=names, signals=replace(signals, columns=columns), reference=what)


def _has_reference(signals: Signals, record: Mapping[str, Any], names: LoopNames) -> bool:
    if len(elements_of(histories.ATTITUDE_REFERENCE, signals.columns)) != len("xyz"):
        return False
    controller = next(c for c in record["component"] if c["name"] == names.controller)
    return "adapter" not in controller or bool(np.any(np.ptp(signals[histories.ATTITUDE_REFERENCE], axis=0)))


def _read_wanted(folder: Path, names: LoopNames) -> Signals:
    """Read the wanted signals alone: a run has hundreds."""
    with open_batches(folder) as (schema, _):
        recorded = [name for name in schema.names if array_of(_usual(name, names)) in _WANTED]
    return read_signals(folder, recorded)


def _renamed(signals: Signals, names: LoopNames) -> Signals:
    """Return the signals with those of plant and controller under their usual names."""
    columns = {}
    for name, values in signals.columns.items():
        columns[_usual(name, names)] = values
    return replace(signals, columns=columns)


def _usual(name: str, names: LoopNames) -> str:
    for component, usual in ((names.plant, "plant"), (names.controller, "controller")):
        if component is not None and name.startswith(f"{component}."):
            return _structured(f"{usual}.{name.removeprefix(f'{component}.')}", names.flat)
    return name


def _structured(name: str, flat: bool) -> str:
    """Return the structured name of a wanted variable: plant.attitude_mrp_1 is plant.attitude.mrp[1]."""
    if not flat:
        return name
    component, _, variable = name.partition(".")
    for wanted in _WANTED:
        owner, _, port = wanted.partition(".")
        match = re.fullmatch(rf"{re.escape(port.replace('.', '_'))}(?:_(\d+))?", variable)
        if owner == component and match is not None:
            return f"{wanted}[{match[1]}]" if match[1] else wanted
    return name


def _without_last_row(signals: Signals, record: Mapping[str, Any]) -> Signals:
    """Leave out the row at the stop time, where no interval begins: for sums and means."""
    end = float(record.get("simulated_time", 0.0))
    if len(signals.time) < 2 or not signals.time[-1] >= end > 0.0:
        return signals
    columns = {name: values[:-1] for name, values in signals.columns.items()}
    return replace(signals, time=signals.time[:-1], columns=columns)
