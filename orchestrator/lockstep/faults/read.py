"""Read a scenario file, or refuse it in one line that names file, fault, key, value and remedy."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, get_args

from lockstep.data_text import parse_toml
from lockstep.errors import InputError, suggestion
from lockstep.faults.scenario import Fault, Kind, Scenario
from lockstep.fmi.safe_zip import open_file
from lockstep.system.clock import Time, nanoseconds, seconds_text
from lockstep.system.component import Value

KINDS: tuple[Kind, ...] = get_args(Kind)
_COMMON = ("name", "connection", "parameter", "kind", "from", "to", "at", "duration")
_AMOUNT = {"stuck": "value", "bias": "value", "scale": "factor", "noise": "deviation", "quantisation": "step",
           "spike": "value"}  # fmt: skip
_MORE = {"stuck": ("unit",), "bias": ("unit",), "noise": ("unit", "seed"), "dropout": ("validity", "invalid"),
         "delay": ("ticks",), "quantisation": ("unit",), "spike": ("unit", "probability", "seed")}  # fmt: skip


def read_scenario(path: Path) -> Scenario:
    """Read a scenario file, or raise InputError."""
    with open_file(path, None, "faults") as stream:
        content = stream.read()
    tables = parse_toml(content, str(path))
    where = path.name
    for key in tables:
        if key != "fault":
            raise InputError(f"{where}: {key}: no such table; a scenario is a list of [[fault]]")
    entries = tables.get("fault", [])
    if not (isinstance(entries, list) and entries and all(isinstance(entry, dict) for entry in entries)):
        raise InputError(f"{where}: holds no fault; write [[fault]] before each")
    return Scenario(
        path=path.absolute(),
        sha256=hashlib.sha256(content).hexdigest(),
        text=content.decode("utf-8"),
        faults=tuple(_fault(entry, where, number) for number, entry in enumerate(entries, start=1)),
    )


def _fault(entry: Mapping[str, Any], where: str, number: int) -> Fault:
    name = entry.get("name", f"fault {number}")
    location = f"{where}: fault {number}"
    if not isinstance(name, str) or not name.strip():
        raise InputError(f"{location}: name = {name!r} must be a text")
    kind = _kind(entry, location)
    location += f" ({entry.get('name', kind)})"
    amount = _AMOUNT.get(kind)
    allowed = (*_COMMON, *((amount,) if amount else ()), *_MORE.get(kind, ()))
    for key in entry:
        if key not in allowed:
            raise InputError(f"{location}: {key}: no such key of {kind}; there are {', '.join(allowed)}"
                             f"{suggestion(key, allowed)}")  # fmt: skip
    if ("connection" in entry) == ("parameter" in entry):
        raise InputError(
            f'{location}: write either connection = "component.input" or parameter = "component.parameter"'
        )
    if "parameter" in entry and kind in ("dropout", "delay"):
        raise InputError(f"{location}: kind = {kind!r} acts on connections; a parameter can be stuck at a value")
    if kind == "spike" and "seed" in entry and "probability" not in entry:
        raise InputError(f"{location}: seed = {entry['seed']!r}: a single spike draws nothing; give probability too, or"
                         " leave it out")  # fmt: skip
    values = _amount(entry, amount, kind, location)
    begin, end = _window(entry, location, lasts=kind != "spike" or "probability" in entry)
    return Fault(
        location=location,
        name=name,
        kind=kind,
        begin=begin,
        end=end,
        connections=_texts(entry, "connection", location),
        parameters=_texts(entry, "parameter", location),
        validity=_texts(entry, "validity", location),
        amount=values,
        unit=_unit(entry, location),
        invalid=_whole(entry, "invalid", 0, -(2**31), location),
        ticks=_whole(entry, "ticks", None, 1, location) if kind == "delay" else 0,
        probability=_probability(entry, location),
        seed=_whole(entry, "seed", 0, 0, location),
    )


def _kind(entry: Mapping[str, Any], location: str) -> Kind:
    given = entry.get("kind")
    kind = str(given).lower()  # the usual way to write it is NaN
    if kind not in KINDS:
        what = "kind is missing" if given is None else f"kind = {given!r}: no such kind"
        raise InputError(f"{location}: {what}; there are {', '.join(KINDS)}{suggestion(kind, KINDS)}")
    return kind


def _amount(entry: Mapping[str, Any], key: str | None, kind: Kind, location: str) -> tuple[Value, ...]:
    if key is None:
        return ()
    if key not in entry:
        needed = kind != "stuck" or "parameter" in entry  # a parameter is stuck anyhow
        if needed:
            raise InputError(f"{location}: {key} is missing; {kind} needs it")
        if "unit" in entry:
            raise InputError(f"{location}: unit = {entry['unit']!r} needs value as well")
        return ()
    given = entry[key]
    values = given if isinstance(given, list) else [given]
    for value in values:
        if kind == "stuck" and isinstance(value, bool | str):
            continue
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise InputError(f"{location}: {key} = {value!r} must be a number, or a list of numbers")
        if not math.isfinite(value):
            raise InputError(f'{location}: {key} = {value!r} must be finite; kind = "nan" makes values that are not')
        if kind in ("noise", "quantisation") and not value > 0:
            raise InputError(f"{location}: {key} = {value!r} must be > 0")
    if not values:
        raise InputError(f"{location}: {key} = [] is empty; give one number, or one for each element")
    return tuple(values)


def _window(entry: Mapping[str, Any], location: str, *, lasts: bool) -> tuple[Time, Time | None]:
    """Return begin and end [ns]; a fault that does not last may give its begin alone."""
    if ("from" in entry) == ("at" in entry):
        raise InputError(f"{location}: write from, and to unless it lasts to the end of the run; or at and duration")
    first, last = ("from", "to") if "from" in entry else ("at", "duration")
    stray = [key for key in ("to", "duration") if key in entry and key != last]
    if stray:
        raise InputError(
            f"{location}: {stray[0]} = {entry[stray[0]]!r} goes with {'from' if stray[0] == 'to' else 'at'}"
        )
    begin = _time(entry, first, location)
    if last not in entry:
        if last == "duration" and lasts:
            raise InputError(f"{location}: at needs duration as well; or write from, which lasts to the end of the run")
        return begin, None
    end = _time(entry, last, location) + (begin if last == "duration" else 0)
    if end <= begin:
        relation = f"to = {entry['to']} must be > from = {entry['from']}" if last == "to" else "duration must be > 0"
        raise InputError(f"{location}: {relation}: the window ends at {seconds_text(end)} s")
    return begin, end


def _time(entry: Mapping[str, Any], key: str, location: str) -> Time:
    value = entry[key]
    fraction = isinstance(value, str) and "/" in value
    if isinstance(value, bool) or not (fraction or isinstance(value, int | float)):
        raise InputError(f"{location}: {key} = {value!r} must be a number of seconds, for example 50.0")
    return nanoseconds(value, f"{location}: {key}")


def _texts(entry: Mapping[str, Any], key: str, location: str) -> tuple[str, ...]:
    given = entry.get(key, [])
    texts: Sequence[Any] = [given] if isinstance(given, str) else given
    if not isinstance(texts, list) or not all(isinstance(text, str) and text.strip() for text in texts):
        raise InputError(f"{location}: {key} = {given!r} must be a text or a list of texts")
    if key in entry and not texts:
        raise InputError(f"{location}: {key} = [] is empty; give a name or a pattern")
    return tuple(text.strip() for text in texts)


def _unit(entry: Mapping[str, Any], location: str) -> str | None:
    unit = entry.get("unit")
    if unit is not None and not isinstance(unit, str):
        raise InputError(f'{location}: unit = {unit!r} must be a text, for example "deg/s"')
    return unit


def _whole(entry: Mapping[str, Any], key: str, default: int | None, lowest: int, location: str) -> int:
    value = entry.get(key, default)
    if value is None:
        raise InputError(f"{location}: {key} is missing; {entry['kind']} needs it")
    if isinstance(value, bool) or not isinstance(value, int) or value < lowest:
        raise InputError(f"{location}: {key} = {value!r} must be a whole number >= {lowest}")
    return value


def _probability(entry: Mapping[str, Any], location: str) -> float | None:
    value = entry.get("probability")
    if value is None:
        return None
    if isinstance(value, bool) or not isinstance(value, int | float) or not 0.0 < value <= 1.0:
        raise InputError(f"{location}: probability = {value!r} must be in (0, 1]")
    return float(value)
