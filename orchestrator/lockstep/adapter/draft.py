"""Draft an adapter file from names, units, numbers and start values, and say what could not be decided."""

from __future__ import annotations

import json
import re
from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from lockstep.adapter.bind import Ports
from lockstep.array_names import array_of
from lockstep.fmi.model_description import Variable, read_description
from lockstep.system.component import Component
from lockstep.system.unit_table import UNITS, gain_between

# words by which makers call the same quantity
_SYNONYMS = (
    ("rate", "gyro", "omega", "w", "angvel", "angular"),
    ("attitude", "mrp", "quaternion", "quat", "q", "att", "star", "tracker", "str"),
    ("torque", "tau", "trq", "moment"),
    ("wheel", "whl", "rw", "rwa", "mw"),
    ("speed", "n", "rpm", "encoder", "tacho"),
    ("valid", "ok", "flag", "good", "available"),
    ("acceleration", "accelerometer", "acc", "accel"),
    ("angle", "phase", "position"),
    ("command", "cmd", "ref", "reference", "target"),
)
_MEANING = {word: group[0] for group in _SYNONYMS for word in group}


@dataclass(frozen=True, slots=True, kw_only=True)
class _Array:
    """An array or a scalar: `pattern` has a star where the number stands."""

    pattern: str
    base: int
    members: tuple[Variable, ...]

    @property
    def words(self) -> set[str]:
        return _words(self.pattern.replace("*", ""))


def draft_adapter(fmu: Path, ours: Ports, needed: Iterable[str], component: str) -> tuple[str, list[str]]:
    """Return the text of a file, and what has to be looked up before it can be trusted.

    Parameters
    ----------
    fmu : the foreign FMU
    ours : ports of the component that it is to stand for
    needed : outputs of it that the system reads
    component : how it is called
    """
    theirs = read_description(Component(name=component, source=fmu, period=1))
    doubts: list[str] = []
    lines = [f"# Draft: {fmu.name} in the place of {component}. Look up every line marked UNDECIDED."]
    step = _number(theirs.step_size)
    if step > 0.0:
        lines.append(f"step = {step:.9g}")
    else:
        doubts.append("step: the FMU recommends none; ours is kept")
    inputs, outputs = (_arrays([v for v in theirs.variables.values() if v.causality == c]) for c in ("input", "output"))
    wanted = [(name, group) for name, group in _ports(ours, "output") if set(needed) & {v.name for v in group}]
    taken = _match(wanted, outputs)
    ignored = [array.pattern for array in outputs if array not in [a for _, _, a in taken]]
    lines.append(f"ignore = {json.dumps(ignored)}")
    doubts += [f"{name}: needed of it, and no output of the FMU is like it" for name, _ in wanted
               if name not in [n for n, _, _ in taken]]  # fmt: skip
    fed = _match(_ports(ours, "input"), inputs)
    for direction, pairs in (("input", fed), ("output", taken)):
        for name, group, array in pairs:
            lines += ["", *_entry(direction, name, group, array, doubts)]
    loose = [v for array in inputs if array not in [a for _, _, a in fed] for v in array.members]
    if loose:
        lines += ["", "[constants]  # UNDECIDED: nothing of ours is like these; their start values"]
        lines += [f"{json.dumps(v.name)} = {_start(v)}" for v in loose]
        doubts.append(f"{', '.join(v.name for v in loose)}: no port of ours is like it; the start value is kept")
    return "\n".join(lines) + "\n", doubts


def _entry(direction: str, name: str, group: Sequence[Variable], array: _Array, doubts: list[str]) -> list[str]:
    first, count = array.members[0], len(array.members)
    attitude = _is_attitude(name) and count in (3, 4)
    part = name if attitude or len(group) == count else f"{name}[1..{count}]"
    lines = [f"[[{direction}]]", f"ours = {json.dumps(part)}", f"theirs = {json.dumps(array.pattern)}"]

    def doubt(key: str, text: str) -> None:
        lines[-1] += f"  # UNDECIDED: {text}"
        doubts.append(f"{array.pattern}: {key}: {text}")

    if part != name:
        doubt("ours", f"it takes {count} of our {len(group)}; the first")
    if "*" in array.pattern and array.base != 1:
        lines.append(f"index_base = {array.base}")
    if attitude:
        lines.append(f'attitude = "{"quaternion" if count == 4 else "mrp"}"')
        if count == 4:
            starts = [_number(v.start) for v in array.members]
            lines.append(f'scalar = "{"first" if starts[0] == 1.0 else "last"}"')
            if starts not in ([1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]):
                doubt("scalar", "its start values do not tell where the scalar stands")
        lines.append('direction = "body-from-inertial"')
        doubt("direction", "or inertial-from-body; no description can tell, check-adapter can")
        return lines
    if group[0].type == "Boolean":
        lines.append("true = 1")
        doubt("true", "which number means valid?") if first.type != "Boolean" else None
        return lines
    unit, mine = first.unit, group[0].unit
    if mine is not None and mine.name != "1":
        if unit is None:
            lines.append(f"unit = {json.dumps(mine.name)}")
            doubt("unit", "the FMU tells none; this is ours")
        elif unit.name in UNITS:
            lines.append(f"unit = {json.dumps(unit.name)}")
    return lines


def _match(
    ports: Sequence[tuple[str, list[Variable]]], arrays: Sequence[_Array]
) -> list[tuple[str, list[Variable], _Array]]:
    """Pair ports of ours with arrays of theirs, the best pairs first, each once."""
    scored = sorted(
        ((_likeness(name, group, array), -i, -k) for i, (name, group) in enumerate(ports)
         for k, array in enumerate(arrays)),
        reverse=True,
    )  # fmt: skip
    found: dict[int, int] = {}
    for likeness, i, k in scored:
        if likeness > 0.0 and -i not in found and -k not in found.values():
            found[-i] = -k
    return [(*ports[i], arrays[k]) for i, k in sorted(found.items())]


def _likeness(name: str, group: Sequence[Variable], array: _Array) -> float:
    """Return how alike a port and an array are; 0 if one cannot serve the other."""
    first, count = array.members[0], len(array.members)
    attitude = _is_attitude(name)
    if "String" in (first.type, group[0].type):
        return 0.0
    if count != len(group) and not (attitude and count == 4) and not 1 < count < len(group):
        return 0.0
    unit = first.unit
    score = 2.0 * len(_words(name) & array.words) + (1.0 if count == len(group) or (attitude and count == 4) else 0.0)
    if group[0].type == "Real" and first.type == "Real" and unit is not None and not attitude:
        try:
            gain_between(group[0].unit, unit)
        except ValueError:
            return 0.0
        score += 1.0
    elif (group[0].type == "Real") != (first.type == "Real"):
        score -= 1.0
    return score if _words(name) & array.words else 0.0


def _is_attitude(name: str) -> bool:
    return "attitude" in _words(name) and bool(re.search("mrp|quat", name))


def _ports(ours: Ports, causality: str) -> list[tuple[str, list[Variable]]]:
    groups: dict[str, list[Variable]] = defaultdict(list)
    for variable in ours.values():
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
    found = []
    for pattern, members in groups.items():
        base = min(members)
        if "*" in pattern and len(members) > 1 and sorted(members) == list(range(base, base + len(members))):
            found.append(_Array(pattern=pattern, base=base, members=tuple(members[k] for k in sorted(members))))
        else:
            found += [_Array(pattern=v.name, base=1, members=(v,)) for v in members.values()]
    return found


def _words(name: str) -> set[str]:
    """Split a name at separators and capitals, and bring its words to one meaning each."""
    parts = re.findall(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+", name)
    return {_MEANING.get(part.lower(), part.lower()) for part in parts}


def _start(variable: Variable) -> str:
    if variable.type == "Boolean":
        return "true" if variable.start in ("true", "1") else "false"
    if variable.type == "String":
        return json.dumps(variable.start or "")
    value = _number(variable.start)
    return repr(value) if variable.type == "Real" else str(int(value))


def _number(text: str | None) -> float:
    """Read a number; 0 for none, and for what is none."""
    try:
        return float(text or 0.0)
    except ValueError:
        return 0.0
