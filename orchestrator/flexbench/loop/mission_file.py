"""Read a mission file: commands at times, and parameters; the values that a system with a mission manager gets."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from flexsat.description.lines import Key, line_of
from flexsat.ports.mission import COMMANDS, LATEST
from flexsat.quantities import FULL_TURN
from flexsat.runtime.missions.mode_logic import ACTIONS
from lockstep.data_text import parse_toml
from lockstep.errors import InputError, suggestion
from lockstep.fmi.safe_zip import open_file
from lockstep.system.component import Value
from lockstep.system.system import System
from lockstep.system.unit_table import UNITS

MANAGER = "mission"  # name of the component
ANGLES = ("rad", "deg", "arcsec")  # units
_TABLES = ("command", "set")
_KEYS = {"slew": ("at", "do", "rotation", "unit")}
_FEW_KEYS = ("at", "do")
FILE_KEYS = {  # for the reference
    "[[command]]": _FEW_KEYS,
    **{f'[[command]] with do = "{action}"': keys for action, keys in _KEYS.items()},
    "[set]": ("component.parameter",),
    "values of do": tuple(ACTIONS),
}


@dataclass(frozen=True, slots=True, kw_only=True)
class _File:
    """A mission file, to refuse what is in it by its line."""

    name: str
    text: str

    def refuse(self, keys: Sequence[Key], message: str) -> InputError:
        line = line_of(self.text, keys)
        return InputError(f"{self.name}{'' if line is None else f':{line}'}: {message}")


def mission_values(system: System, path: Path) -> dict[str, Value]:
    """Return the parameters that a mission file sets in a system, by `component.parameter`, one scalar each.

    The file has a list of tables `[[command]]` with `at` [s] and `do`, for a slew with `rotation` and its `unit` too;
    and a table `[set]` of parameters in SI, such as `"environment.constant.torque" = [0.01, 0.0, 0.0]`.

    Raises
    ------
    InputError
        In one line, with the number of the line in the file; or for a system without a mission manager.
    """
    if all(component.name != MANAGER for component in system.components):
        raise InputError(
            f"--mission: {system.name} has no component {MANAGER}; `flexsat build --missions` writes"
            " fmus/<configuration>/missions/mission.ssd"
        )
    with open_file(path, None, "mission") as stream:
        content = stream.read()
    tables = parse_toml(content, str(path))
    file = _File(name=path.name, text=content.decode("utf-8"))
    for key in tables:
        if key not in _TABLES:
            raise file.refuse((key,), f"{key}: no such table; a mission has [[command]] and [set]")
    commands = _timeline(file, tables.get("command", []))
    settings = _settings(file, tables.get("set", {}))
    if twice := commands.keys() & settings:
        raise file.refuse(("set",), f"{min(twice)} is of the commands above too; give commands by [[command]] alone")
    return {**commands, **settings}


def _timeline(file: _File, commands: Any) -> dict[str, Value]:
    if not (isinstance(commands, list) and all(isinstance(one, dict) for one in commands)):
        raise file.refuse(("command",), "command: write [[command]] before each")
    if len(commands) > COMMANDS:
        raise file.refuse(("command", COMMANDS), f"{len(commands)} commands; a timeline holds {COMMANDS}")
    values: dict[str, Value] = {}
    last = 0.0
    for number, command in enumerate(commands):
        time, action, rotation = _command(file, number, command, last)
        values[f"{MANAGER}.timeline.time[{number + 1}]"] = last = time
        values[f"{MANAGER}.timeline.action[{number + 1}]"] = ACTIONS.index(action)
        for axis, angle in enumerate(rotation):
            values[f"{MANAGER}.timeline.rotation[{3 * number + axis + 1}]"] = angle
    return values


def _command(file: _File, number: int, command: Mapping[str, Any], last: float) -> tuple[float, str, tuple[float, ...]]:
    """Return time, action and rotation of a command, which may not come before the last one [s]."""
    place: tuple[Key, ...] = ("command", number)
    action = command.get("do")
    if action not in ACTIONS[1:]:
        known = ", ".join(ACTIONS[1:])
        raise file.refuse((*place, "do") if "do" in command else place, f"do = {action!r} must be one of {known}")
    allowed = _KEYS.get(action, _FEW_KEYS)
    for key in command:
        if key not in allowed:
            raise file.refuse((*place, key), f"{key}: no such key of {action}; there are {', '.join(allowed)}"
                                             f"{suggestion(key, allowed)}")  # fmt: skip
    time: Any = command.get("at")
    if not _is_number(time) or not 0.0 <= time <= LATEST:
        raise file.refuse((*place, "at") if "at" in command else place, f"at = {time!r} must be a time in s, from 0 on")
    if time < last:
        raise file.refuse((*place, "at"), f"at = {time!r} s must not be before the command above, at {last!r} s")
    return float(time), action, _rotation(file, place, command) if action == "slew" else ()


def _rotation(file: _File, place: tuple[Key, ...], command: Mapping[str, Any]) -> tuple[float, ...]:
    unit = command.get("unit", "rad")
    if unit not in ANGLES:
        raise file.refuse((*place, "unit"), f"unit = {unit!r} must be one of {', '.join(ANGLES)}")
    given = command.get("rotation")
    where = (*place, "rotation") if "rotation" in command else place
    if not (isinstance(given, list) and len(given) == len("xyz") and all(map(_is_number, given))):
        raise file.refuse(where, f"rotation = {given!r} must be three numbers: the rotation vector of the slew")
    rotation = tuple(UNITS[unit].factor * angle for angle in given)
    if not any(rotation) or max(map(abs, rotation)) > FULL_TURN:
        raise file.refuse(where, f"rotation = {given!r} {unit} must turn somewhere, by at most a turn about each axis")
    return rotation


def _settings(file: _File, settings: Any) -> dict[str, Value]:
    if not isinstance(settings, dict):
        raise file.refuse(("set",), "set must be a table of parameters, such as [set]")
    return dict(_scalars(file, settings))


def _scalars(file: _File, settings: Mapping[str, Any]) -> Iterator[tuple[str, Value]]:
    for name, value in settings.items():
        elements = value if isinstance(value, list) else [value]
        if "." not in name or not elements or not all(isinstance(one, (bool, int, float, str)) for one in elements):
            raise file.refuse(
                ("set", name),
                f"{name} = {value!r} must be a parameter and its value, or a list of one for each element, such as"
                ' "environment.constant.torque" = [0.01, 0.0, 0.0]',
            )
        for number, element in enumerate(elements, start=1):
            yield (f"{name}[{number}]" if isinstance(value, list) else name), element


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)
