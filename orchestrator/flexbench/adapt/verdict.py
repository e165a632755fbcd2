"""Find the wrong convention in an adapter: change one at a time, and see which change gives the right response."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np

from flexbench.adapt.excitation import Excitation, Respond, Response, experiments
from flexbench.adapt.judge import Judgement, axes_named, judge
from lockstep.adapter.bind import Binding, bind
from lockstep.errors import InputError, RunError
from lockstep.fmi.model_description import read_description
from lockstep.system.adapter_file import DIRECTIONS, Adapter, AdapterEntry
from lockstep.system.clock import Time
from lockstep.system.component import Component
from lockstep.system.unit_table import UNITS, gain_between

_FAMILIES = (("rad/s", "deg/s", "rpm"), ("rad", "deg"), ("N.m", "mN.m", "uN.m"))
_MOST_PAIRS = 80
_SPANS = (1.0, 5.0)  # [s] until the response is measured: most need one step, estimators of flexible modes seconds
_FIELDS = {"direction": "rotation"}  # where a key has another name than in the file


@dataclass(frozen=True, slots=True, kw_only=True)
class Correction:
    """Hold one convention of one entry that may be wrong, and what to write instead."""

    number: int  # of the entry
    key: str
    error: str
    remedy: str
    entry: AdapterEntry


@dataclass(frozen=True, slots=True, kw_only=True)
class Verdict:
    """Hold the response, and the changes that correct it, the nearest to the reference first; each of one or two."""

    judgement: Judgement
    cures: tuple[tuple[Correction, ...], ...]
    axes: str  # a permutation of axes, described
    unseen: tuple[str, ...]  # inputs of the FMU that were constant
    constants: Mapping[str, object]  # what the adapter feeds to inputs without a port
    step: Time  # [ns]

    @property
    def right(self) -> bool:
        """Whether nothing is wrong."""
        return not self.judgement.problems


def check_adapter(fmu: Path, adapter: Adapter, excitation: Excitation) -> Verdict:
    """Excite the FMU through its adapter and judge; raise InputError for bad input, RunError if it cannot run."""
    component = Component(name="fmu", source=fmu.absolute(), period=excitation.period)
    binding = bind(adapter, excitation.ports, read_description(component).variables)
    lacking = [name for name in excitation.torque if name not in binding.shown]
    if lacking:
        raise InputError(f"{adapter.path.name}: {lacking[0]} is not served; a controller is judged by its torque")
    with experiments(fmu, adapter, excitation) as respond:
        judgement = _judged(fmu, respond, adapter, excitation)
        wrong = bool(judgement.problems) and not judgement.silent
        cures, axes = _corrections(respond, binding, excitation, axes_named(judgement)) if wrong else ([], "")
    moved = {*excitation.attitude, *excitation.rate}
    unseen = [b.entry for b in binding.inputs if not moved & {v.name for v in b.ports}]
    return Verdict(
        judgement=judgement,
        cures=tuple(cures),
        axes=axes,
        unseen=tuple(entry.variables[0] for entry in unseen),
        constants=dict(adapter.constants),
        step=adapter.step or excitation.period,
    )


def _judged(fmu: Path, respond: Respond, adapter: Adapter, excitation: Excitation) -> Judgement:
    """Judge the response, the early one unless a later one is right."""
    judgements = []
    for span in _SPANS:
        response = respond([adapter], span)[0]
        if isinstance(response, str):
            raise RunError(f"{fmu}: {response}")
        judgements.append(judge(response, excitation))
        if not judgements[-1].problems:
            return judgements[-1]
    return judgements[0]


def _corrections(
    respond: Respond, binding: Binding, excitation: Excitation, permuted: str
) -> tuple[list[tuple[Correction, ...]], str]:
    """Return the changes that correct an adapter, and a permutation of axes that it may have instead, described."""
    changes = _changes(binding, excitation)
    singles = [(change,) for change in changes]
    cures = _cures(respond, binding.adapter, excitation, singles, _SPANS[0])
    axes = "" if cures else permuted
    if not cures and not axes:
        cures = _cures(respond, binding.adapter, excitation, singles, _SPANS[1])
    if not cures and not axes:
        pairs = [p for p in combinations(changes, 2) if (p[0].number, p[0].key) != (p[1].number, p[1].key)]
        cures = _cures(respond, binding.adapter, excitation, pairs[:_MOST_PAIRS], _SPANS[0])
    return cures, axes


def _cures(
    respond: Respond, adapter: Adapter, excitation: Excitation, sets: Sequence[tuple[Correction, ...]], span: float
) -> list[tuple[Correction, ...]]:
    """Return the sets of changes that give the right response, the nearest to the reference first."""
    responses = respond([_changed(adapter, changes) for changes in sets], span) if sets else []
    judged = [
        (judge(response, excitation), changes)
        for response, changes in zip(responses, sets, strict=True)
        if isinstance(response, Response)
    ]
    good = [(judgement.distance, changes) for judgement, changes in judged if not judgement.problems]
    return [changes for _, changes in sorted(good, key=lambda item: item[0])]


def _changed(adapter: Adapter, changes: Sequence[Correction]) -> Adapter:
    entries = list(adapter.entries)
    for change in changes:
        kept = entries[change.number]  # another change may have been made to the same entry
        name = _FIELDS.get(change.key, change.key)
        different: dict[str, Any] = {name: getattr(change.entry, name)}
        entries[change.number] = replace(kept, **different)
    return replace(adapter, entries=tuple(entries))


def _changes(binding: Binding, excitation: Excitation) -> list[Correction]:
    """Return every change that is possible in the entries of attitude, rate and torque."""
    touched = {*excitation.attitude, *excitation.rate, *excitation.torque}
    found = []
    for bound in (*binding.inputs, *binding.outputs):
        if touched & {v.name for v in bound.ports}:
            number = binding.adapter.entries.index(bound.entry)
            declared, unit = (v.unit.name if v.unit else None for v in (bound.variables[0], bound.ports[0]))
            found += _changes_of(number, bound.entry, declared, unit)
            if {v.name for v in bound.ports} == set(excitation.torque):
                found += _wheel_signs(number, bound.entry, excitation)
    return found


def _wheel_signs(number: int, entry: AdapterEntry, excitation: Excitation) -> list[Correction]:
    """Return the changes for a controller that counts all wheels along the body axes, where some point against them."""
    main = np.argmax(np.abs(excitation.wheel_axis), axis=1)
    along = [int(np.sign(axis[k])) for axis, k in zip(excitation.wheel_axis, main, strict=True)]
    if len(set(along)) == 1:
        return []
    location = entry.location.partition(": ")[2]
    found = []
    for signs in (along, [-sign for sign in along]):
        sign = tuple(float(value) for value in np.array(signs) * np.array(entry.sign))
        remedy = f"sign = {[int(value) for value in sign]}"
        error = f"wheel axes that point the other way: {location}"
        found.append(Correction(number=number, key="sign", error=error, remedy=remedy, entry=replace(entry, sign=sign)))
    return found


def _changes_of(number: int, entry: AdapterEntry, declared: str | None, port_unit: str | None) -> list[Correction]:
    location = entry.location.partition(": ")[2]

    def change(key: str, error: str, remedy: str, **values: object) -> Correction:
        return Correction(
            number=number, key=key, error=f"{error}: {location}", remedy=remedy, entry=replace(entry, **values)  # type: ignore[arg-type]
        )  # fmt: skip

    if entry.attitude is not None:
        other = DIRECTIONS[1 - DIRECTIONS.index(entry.rotation)]
        found = [change("direction", "inverse rotation", f'direction = "{other}"', rotation=other)]
        if entry.attitude == "quaternion":
            order = "last" if entry.scalar == "first" else "first"
            found.append(change("scalar", "wrong quaternion order", f'scalar = "{order}"', scalar=order))
        return found
    minus = tuple(-value for value in entry.sign)
    written = f"{minus[0]:g}" if len(minus) == 1 else str([int(value) for value in minus])
    found = [change("sign", "wrong sign", f"sign = {written}", sign=minus)]
    present = entry.unit or declared or port_unit
    error = "wrong unit" if entry.unit or declared else "missing unit"
    for family in _FAMILIES:
        if port_unit in family:
            found += [
                change("unit", f"{error}, {_confused(present, unit)}", f'unit = "{unit}"', unit=unit)
                for unit in family
                if not _same(unit, present)
            ]
    return found


def _same(unit: str, present: str | None) -> bool:
    return present in UNITS and gain_between(UNITS[unit], UNITS[present or ""]) == (1.0, 0.0)


def _confused(present: str | None, unit: str) -> str:
    words = {"deg/s": "degrees", "deg": "degrees", "rad/s": "radians", "rad": "radians"}
    return f"{words.get(unit, unit)} for {words.get(present or '', present)}"
