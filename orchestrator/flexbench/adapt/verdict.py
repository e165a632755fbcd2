"""Tell a convention error by name: change one thing in the adapter at a time, and see which change makes it right."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from pathlib import Path
from typing import Any

from flexbench.adapt.excitation import Excitation, Response, respond
from flexbench.adapt.judge import Judgement, axes_named, judge
from lockstep.adapter.bind import Binding, bind
from lockstep.errors import InputError, RunError
from lockstep.fmi.model_description import read_description
from lockstep.system.adapter_file import DIRECTIONS, Adapter, Entry
from lockstep.system.component import Component
from lockstep.system.unit_table import UNITS, gain_between

_FAMILIES = (("rad/s", "deg/s", "rpm"), ("rad", "deg"), ("N.m", "mN.m", "uN.m"))
_MOST_PAIRS = 80
_SPANS = (1.0, 5.0)  # [s] to answer in: most take one step, estimators of flexible modes some seconds
_FIELDS = {"direction": "rotation"}  # where a key has another name than in the file


@dataclass(frozen=True, slots=True, kw_only=True)
class Change:
    """One thing that may be wrong in one entry, and what to write instead."""

    number: int  # of the entry
    key: str
    error: str
    remedy: str
    entry: Entry


@dataclass(frozen=True, slots=True, kw_only=True)
class Verdict:
    """What was seen, and which changes make it right, the nearest first; each is one or two changes at once."""

    judgement: Judgement
    cures: tuple[tuple[Change, ...], ...]
    axes: str  # a permutation of axes, named
    unseen: tuple[str, ...]  # inputs of theirs that were held still
    step: int  # [ns]

    @property
    def right(self) -> bool:
        """Whether nothing is wrong."""
        return not self.judgement.problems


def check_adapter(fmu: Path, adapter: Adapter, excitation: Excitation) -> Verdict:
    """Excite the FMU through its adapter and judge; raise InputError for bad input, RunError if it cannot run."""
    component = Component(name="fmu", source=fmu.absolute(), period=excitation.period)
    theirs = read_description(component).variables
    binding = bind(adapter, excitation.ours, theirs)
    lacking = [name for name in excitation.torque if name not in binding.variables]
    if lacking:
        raise InputError(f"{adapter.path.name}: {lacking[0]} is not served; a controller is judged by its torque")
    judgement = _judged(fmu, adapter, excitation)
    moved = {*excitation.attitude, *excitation.rate}
    unseen = [e for e in adapter.entries if e.direction == "input"]
    unseen = [b.entry for b in binding.inputs if not moved & {v.name for v in b.ours}]
    cures: list[tuple[Change, ...]] = []
    axes = ""
    if judgement.problems:
        changes = _changes(binding, excitation)
        singles = [(change,) for change in changes]
        cures = _cures(fmu, adapter, excitation, singles, _SPANS[0])
        axes = "" if cures else axes_named(judgement)
        if not cures and not axes:
            cures = _cures(fmu, adapter, excitation, singles, _SPANS[1])
        if not cures and not axes:
            pairs = [p for p in combinations(changes, 2) if (p[0].number, p[0].key) != (p[1].number, p[1].key)]
            cures = _cures(fmu, adapter, excitation, pairs[:_MOST_PAIRS], _SPANS[0])
    return Verdict(
        judgement=judgement,
        cures=tuple(cures),
        axes=axes,
        unseen=tuple(entry.theirs[0] for entry in unseen),
        step=adapter.step or excitation.period,
    )


def _judged(fmu: Path, adapter: Adapter, excitation: Excitation) -> Judgement:
    """Judge the answer, the early one unless a late one is right."""
    judgements = []
    for span in _SPANS:
        response = respond(fmu, [adapter], excitation, span)[0]
        if isinstance(response, str):
            raise RunError(f"{fmu}: {response}")
        judgements.append(judge(response, excitation))
        if not judgements[-1].problems:
            return judgements[-1]
    return judgements[0]


def _cures(
    fmu: Path, adapter: Adapter, excitation: Excitation, sets: Sequence[tuple[Change, ...]], span: float
) -> list[tuple[Change, ...]]:
    """Return the sets of changes that make all right, the nearest to the reference first."""
    responses = respond(fmu, [_changed(adapter, changes) for changes in sets], excitation, span) if sets else []
    judged = [
        (judge(response, excitation), changes)
        for response, changes in zip(responses, sets, strict=True)
        if isinstance(response, Response)
    ]
    good = [(judgement.distance, changes) for judgement, changes in judged if not judgement.problems]
    return [changes for _, changes in sorted(good, key=lambda item: item[0])]


def _changed(adapter: Adapter, changes: Sequence[Change]) -> Adapter:
    entries = list(adapter.entries)
    for change in changes:
        kept = entries[change.number]  # another change may have been made to the same entry
        name = _FIELDS.get(change.key, change.key)
        different: dict[str, Any] = {name: getattr(change.entry, name)}
        entries[change.number] = replace(kept, **different)
    return replace(adapter, entries=tuple(entries))


def _changes(binding: Binding, excitation: Excitation) -> list[Change]:
    """Return everything that may be wrong in the entries that attitude, rate and torque travel through."""
    touched = {*excitation.attitude, *excitation.rate, *excitation.torque}
    found = []
    for bound in (*binding.inputs, *binding.outputs):
        if touched & {v.name for v in bound.ours}:
            number = binding.adapter.entries.index(bound.entry)
            declared, ours = (v.unit.name if v.unit else None for v in (bound.theirs[0], bound.ours[0]))
            found += _of(number, bound.entry, declared, ours)
    return found


def _of(number: int, entry: Entry, declared: str | None, ours: str | None) -> list[Change]:
    place = entry.place.partition(": ")[2]

    def change(key: str, error: str, remedy: str, **values: object) -> Change:
        return Change(
            number=number, key=key, error=f"{error}: {place}", remedy=remedy, entry=replace(entry, **values)  # type: ignore[arg-type]
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
    present = entry.unit or declared or ours
    error = "wrong unit" if entry.unit or declared else "missing unit"
    for family in _FAMILIES:
        if ours in family:
            found += [
                change("unit", f"{error}, {_confused(present, unit)}", f'unit = "{unit}"', unit=unit)
                for unit in family
                if not _same(unit, present)
            ]
    return found


def _same(unit: str, present: str | None) -> bool:
    return present in UNITS and gain_between(UNITS[unit], UNITS[present or ""]) == (1.0, 0.0)


def _confused(present: str | None, unit: str) -> str:
    told = {"deg/s": "degrees", "deg": "degrees", "rad/s": "radians", "rad": "radians"}
    return f"{told.get(unit, unit)} for {told.get(present or '', present)}"
