"""Draft an adapter file from names, units, array sizes and start values, and list what could not be decided."""

from __future__ import annotations

import json
import re
from collections import defaultdict
from collections.abc import Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from lockstep.adapter.bind import Variables
from lockstep.array_names import array_of
from lockstep.fmi.model_description import Variable, read_description
from lockstep.system.adapter_file import ATTITUDES, DIRECTIONS
from lockstep.system.component import Component
from lockstep.system.unit_table import UNITS, gain_between
from lockstep.system.units import Unit

Synonyms = Sequence[Sequence[str]]  # words for the same quantity, group by group


@dataclass(frozen=True, slots=True, kw_only=True)
class _Array:
    """An array, a scalar, or scalars named by their axes: `pattern` has a star where the number or the axis stands."""

    pattern: str
    base: int
    members: tuple[Variable, ...]
    by_axis: bool = False  # q_s, q_x, q_y, q_z: members in this order; an adapter lists their names

    @property
    def variable(self) -> str:
        """Return it as TOML writes it in an entry."""
        return json.dumps([v.name for v in self.members] if self.by_axis else self.pattern)


def draft_adapter(
    fmu: Path, ports: Variables, needed: Iterable[str], component: str, synonyms: Synonyms = ()
) -> tuple[str, list[str]]:
    """Return the text of an adapter file, and what has to be looked up before it can be trusted.

    Parameters
    ----------
    fmu : the foreign FMU
    ports : interface ports of the component that the FMU replaces
    needed : outputs of the component that the system reads
    component : name of the component
    synonyms : groups of words that name the same quantity; names are compared by the words that they share
    """
    return _Draft(synonyms).text(fmu, ports, set(needed), component)


class _Draft:
    def __init__(self, synonyms: Synonyms) -> None:
        self._meaning = {word: group[0] for group in synonyms for word in group}
        self.doubts: list[str] = []

    def text(self, fmu: Path, ports: Variables, needed: set[str], component: str) -> tuple[str, list[str]]:
        """Draft the whole file."""
        description = read_description(Component(name="fmu", source=fmu, period=1))
        doubts = self.doubts
        lines = [f"# Draft: {fmu.name} in place of {component}. Look up every line marked UNDECIDED."]
        step = _number(description.step_size)
        if step > 0.0:
            lines.append(f"step = {step:.9g}")
        else:
            doubts.append("step: the FMU recommends none; the period of the component is kept")
        variables = description.variables.values()
        inputs, outputs = (_arrays([v for v in variables if v.causality == c]) for c in ("input", "output"))
        wanted = [(name, group) for name, group in _ports(ports, "output") if needed & {v.name for v in group}]
        taken = self._match(wanted, outputs)
        unused = [array for array in outputs if array not in [a for _, _, a in taken]]
        ignored = [name for array in unused for name in _ignored(array)]
        lines.append(f"ignore = {json.dumps(ignored)}")
        doubts += [f"{name}: the system reads it, and no output of the FMU is like it" for name, _ in wanted
                   if name not in [n for n, _, _ in taken]]  # fmt: skip
        fed = self._match(_ports(ports, "input"), inputs)
        for direction, pairs in (("input", fed), ("output", taken)):
            for name, group, array in pairs:
                lines += ["", *self._entry(direction, name, group, array)]
        loose = [v for array in inputs if array not in [a for _, _, a in fed] for v in array.members]
        if loose:
            lines += ["", "[constants]  # UNDECIDED: no port is like these; their start values"]
            lines += [f"{json.dumps(v.name)} = {_start(v)}" for v in loose]
            doubts.append(f"{', '.join(v.name for v in loose)}: no port is like it; the start value is kept")
        return "\n".join(lines) + "\n", doubts

    def _entry(self, direction: str, name: str, group: Sequence[Variable], array: _Array) -> list[str]:
        first, count = array.members[0], len(array.members)
        attitude = self._is_attitude(name) and count in (3, 4)
        part = name if attitude or len(group) == count else f"{name}[1..{count}]"
        lines = [f"[[{direction}]]", f"port = {json.dumps(part)}", f"variable = {array.variable}"]

        def doubt(key: str, text: str) -> None:
            lines[-1] += f"  # UNDECIDED: {text}"
            self.doubts.append(f"{array.pattern}: {key}: {text}")

        if part != name:
            doubt("port", f"it has {count} elements, and the port {len(group)}; the first are taken")
        if "*" in array.pattern and array.base != 1 and not array.by_axis:
            lines.append(f"index_base = {array.base}")
        if attitude:
            lines.append(f'attitude = "{"quaternion" if count == 4 else "mrp"}"')
            if count == 4:
                starts = [1.0, 0.0, 0.0, 0.0] if array.by_axis else [_number(v.start) for v in array.members]
                lines.append(f'scalar = "{"first" if starts[0] == 1.0 else "last"}"')
                if starts not in ([1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]):
                    doubt("scalar", "its start values do not show where the scalar is")
            described = _described_direction(first)
            lines.append(f'direction = "{described or DIRECTIONS[0]}"')
            doubt(
                "direction",
                "the FMU declares none; this is in its description"
                if described
                else f"or {DIRECTIONS[1]}; the model description does not say",
            )
            return lines
        if group[0].type == "Boolean":
            lines.append("true = 1")
            doubt("true", "which number means valid?") if first.type != "Boolean" else None
            return lines
        unit, port_unit = first.unit, group[0].unit
        if port_unit is not None and port_unit.name != "1":
            if unit is None:
                described = _described_unit(first, group[0].unit)
                lines.append(f"unit = {json.dumps(described or port_unit.name)}")
                doubt(
                    "unit",
                    "the FMU declares none; this is " + ("in its description" if described else "that of the port"),
                )
            elif unit.name in UNITS:
                lines.append(f"unit = {json.dumps(unit.name)}")
        return lines

    def _match(
        self, ports: Sequence[tuple[str, list[Variable]]], arrays: Sequence[_Array]
    ) -> list[tuple[str, list[Variable], _Array]]:
        """Pair ports with arrays of the FMU, the best pairs first, each once."""
        scored = sorted(
            ((self._likeness(name, group, array), -i, -k) for i, (name, group) in enumerate(ports)
             for k, array in enumerate(arrays)),
            reverse=True,
        )  # fmt: skip
        found: dict[int, int] = {}
        for likeness, i, k in scored:
            if likeness > 0.0 and -i not in found and -k not in found.values():
                found[-i] = -k
        return [(*ports[i], arrays[k]) for i, k in sorted(found.items())]

    def _likeness(self, name: str, group: Sequence[Variable], array: _Array) -> float:
        """Return how alike a port and an array are; 0 if one cannot serve the other."""
        first, count = array.members[0], len(array.members)
        attitude = self._is_attitude(name)
        if "String" in (first.type, group[0].type):
            return 0.0
        if count != len(group) and not (attitude and count == 4) and not 1 < count < len(group):
            return 0.0
        unit = first.unit
        common = self._words(name) & self._words(array.pattern.replace("*", ""))
        score = 2.0 * len(common) + (1.0 if count == len(group) or (attitude and count == 4) else 0.0)
        if group[0].type == "Real" and first.type == "Real" and unit is not None and not attitude:
            try:
                gain_between(group[0].unit, unit)
            except ValueError:
                return 0.0
            score += 1.0
        elif (group[0].type == "Real") != (first.type == "Real"):
            score -= 1.0
        return score if common else 0.0

    def _words(self, name: str) -> set[str]:
        """Return the words of a name, those with synonyms as the first of their group."""
        return {self._meaning.get(word, word) for word in _split(name)}

    def _is_attitude(self, name: str) -> bool:
        """Return whether a port holds an attitude, so that arrays of 3 and of 4 elements may represent it."""
        return bool(_split(name) & set(ATTITUDES))


def _ports(ports: Variables, causality: str) -> list[tuple[str, list[Variable]]]:
    groups: dict[str, list[Variable]] = defaultdict(list)
    for variable in ports.values():
        if variable.causality == causality:
            groups[array_of(variable.name)].append(variable)
    return list(groups.items())


def _arrays(variables: Iterable[Variable]) -> list[_Array]:
    """Group variables whose names differ in their last number only, and count on by one."""
    groups: dict[str, dict[int, Variable]] = defaultdict(dict)
    for variable in variables:
        parts = re.fullmatch(r"(.*?)(\d+)(\D*)", variable.name)
        if parts is None:
            groups[variable.name][0] = variable
        else:
            groups[f"{parts[1]}*{parts[3]}"][int(parts[2])] = variable
    found = _by_axis([variable for members in groups.values() for variable in members.values()])
    grouped = {v.name for array in found for v in array.members}
    for pattern, members in groups.items():
        if grouped & {v.name for v in members.values()}:
            continue
        base = min(members)
        if "*" in pattern and len(members) > 1 and sorted(members) == list(range(base, base + len(members))):
            found.append(_Array(pattern=pattern, base=base, members=tuple(members[k] for k in sorted(members))))
        else:
            found += [_Array(pattern=v.name, base=1, members=(v,)) for v in members.values()]
    return found


def _by_axis(variables: Iterable[Variable]) -> list[_Array]:
    """Group scalars whose names end in x, y, z, and in s or w for the scalar part of a quaternion."""
    groups: dict[str, dict[str, Variable]] = defaultdict(dict)
    for variable in variables:
        parts = re.fullmatch(r"(.*(?:[_.]|[a-z0-9](?=[XYZSW])|[a-z](?=[xyzsw])))([xyzswXYZSW])", variable.name)
        if parts is not None:
            groups[parts[1]].setdefault(parts[2].lower(), variable)
    found = []
    for prefix, members in groups.items():
        scalar = [axis for axis in "sw" if axis in members]
        if {"x", "y", "z"} <= set(members) and len(members) == 3 + len(scalar) and len(scalar) <= 1:
            ordered = tuple(members[axis] for axis in (*scalar, "x", "y", "z"))
            found.append(_Array(pattern=f"{prefix}*", base=1, members=ordered, by_axis=True))
    return found


def _ignored(array: _Array) -> list[str]:
    return [v.name for v in array.members] if array.by_axis else [array.pattern]


def _described_unit(variable: Variable, wanted: Unit | None) -> str | None:
    """Return the unit that a description has, if it measures the same quantity: `[deg/s]`, `in mN.m`, `rate, deg/s`."""
    for word in re.split(r"[\s,;:()\[\]]+", variable.description or ""):
        name = word.removesuffix(".")
        with suppress(ValueError):
            if name in UNITS and gain_between(wanted, UNITS[name]):
                return name
    return None


def _described_direction(variable: Variable) -> str | None:
    """Return the direction of a rotation that a description has in words, if there is one alone."""
    words = " ".join(re.findall("[a-z]+", (variable.description or "").lower()))
    found = {
        direction
        for direction, (to, start) in zip(DIRECTIONS, (("body", "inertial"), ("inertial", "body")), strict=True)
        if f"{to} from {start}" in words or f"{start} to {to}" in words
    }
    return found.pop() if len(found) == 1 else None


def _split(name: str) -> set[str]:
    """Split a name into words in small letters, at separators and capitals."""
    return {part.lower() for part in re.findall(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+", name)}


def _start(variable: Variable) -> str:
    if variable.type == "Boolean":
        return "true" if variable.start in ("true", "1") else "false"
    if variable.type == "String":
        return json.dumps(variable.start or "")
    value = _number(variable.start)
    return repr(value) if variable.type == "Real" else str(int(value))


def _number(text: str | None) -> float:
    """Read a number; return 0 for None and for other text."""
    try:
        return float(text or 0.0)
    except ValueError:
        return 0.0
