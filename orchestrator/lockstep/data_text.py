"""Parse the text of data files, TOML and JSON, and check the types of their values, or refuse them in one line."""

import json
import tomllib
from collections.abc import Mapping, Sequence
from typing import Any

from lockstep.errors import InputError

# The shape of a value: a kind; `[shape]` for a list of such; a table with the shape of each key, where `?key` may be
# missing and `*` is for all keys. A kind that ends in `?` may also be null.
Shape = str | Sequence[Any] | Mapping[str, Any]
_KINDS: Mapping[str, type | tuple[type, ...]] = {
    "text": str, "number": (int, float), "time": (int, float, str), "whole number": int, "flag": bool, "list": list,
    "table": dict,
}  # fmt: skip
_NAMES = {"time": "number, or a fraction such as '1/60'"}


def check_shape(value: object, shape: Shape, where: str, remedy: str = "", name: str = "") -> None:
    """Raise InputError if a value has not this shape; `where` is its file, `name` its name there."""
    here = f"{where}: {name} =" if name else f"{where}:"
    if isinstance(shape, str):
        kind = shape.removesuffix("?")
        if value is None and kind != shape:
            return
        if not isinstance(value, _KINDS[kind]) or (kind != "flag" and isinstance(value, bool)):
            raise InputError(f"{here} {_short(value)} must be a {_NAMES.get(kind, kind)}{_then(remedy)}")
    elif isinstance(shape, Mapping):
        if not isinstance(value, dict):
            raise InputError(f"{here} {_short(value)} must be a table{_then(remedy)}")
        prefix = f"{name}." if name else ""
        for key, inner in shape.items():
            chosen = list(value) if key == "*" else [key.removeprefix("?")]
            for each in chosen:
                if each in value:
                    check_shape(value[each], inner, where, remedy, f"{prefix}{each}")
                elif not key.startswith("?"):
                    raise InputError(f"{where}: {prefix}{each} is missing{_then(remedy)}")
    else:
        if not isinstance(value, list):
            raise InputError(f"{here} {_short(value)} must be a list{_then(remedy)}")
        for number, item in enumerate(value, start=1):
            check_shape(item, shape[0], where, remedy, f"{name}[{number}]")


def _short(value: object) -> str:
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:56]} ..."


def parse_toml(content: bytes | str, where: str, remedy: str = "") -> dict[str, Any]:
    """Return the tables of a TOML file, or raise InputError. `where` names it, `remedy` ends the message."""
    try:
        return tomllib.loads(content if isinstance(content, str) else content.decode("utf-8"))
    except ValueError as error:  # no UTF-8, or no TOML
        raise InputError(f"{where}: is no TOML file ({error}){_then(remedy)}") from None
    except RecursionError:
        raise InputError(f"{where}: is nested too deeply to be read{_then(remedy)}") from None


def parse_json(content: bytes | str, where: str, remedy: str = "") -> Any:
    """Return the content of a JSON file, or raise InputError. `where` names it, `remedy` ends the message."""
    try:
        return json.loads(content if isinstance(content, str) else content.decode("utf-8"))
    except ValueError as error:  # no UTF-8, or no JSON
        raise InputError(f"{where}: is no JSON file ({error}){_then(remedy)}") from None
    except RecursionError:
        raise InputError(f"{where}: is nested too deeply to be read{_then(remedy)}") from None


def _then(remedy: str) -> str:
    return f"; {remedy}" if remedy else ""
