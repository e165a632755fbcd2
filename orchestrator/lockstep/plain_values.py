"""Convert values of the Python interface, numpy's among them, to the types that TOML and JSON can keep."""

from collections.abc import Mapping, Sequence
from pathlib import PurePath
from typing import Any

from lockstep.errors import InputError


def plain_value(value: object, what: str) -> Any:
    """Return a value as Python's own bool, int, float, str, list or dict; numpy's arrays are lists of lists.

    Raises
    ------
    InputError
        If it is, or contains, anything else. `what` names it.
    """
    if hasattr(value, "__array__"):
        value = value.__array__().tolist()  # of numpy, which is not imported for this
    match value:
        case bool():
            return value
        case int():
            return int(value)
        case float():
            return float(value)  # numpy's float64 is one, and writes itself as np.float64(...)
        case str():
            return str(value)
        case PurePath():
            return str(value)
        case Mapping():
            return {str(key): plain_value(item, f"{what}.{key}") for key, item in value.items()}
        case Sequence() if not isinstance(value, bytes | bytearray | memoryview):
            return [plain_value(item, what) for item in value]
    kind = "None" if value is None else f"{value!r} of type {type(value).__name__}"
    raise InputError(f"{what}: {kind} cannot be kept; give a number, a text, True or False, or a list of these")


def plain_whole(value: object, what: str) -> int:
    """Return a whole number, numpy's too, as an int; raise InputError for anything else."""
    whole = plain_value(value, what)
    if isinstance(whole, bool) or not isinstance(whole, int):
        raise InputError(f"{what}: {whole!r} must be a whole number")
    return whole


def plain_number(value: object, what: str) -> float:
    """Return a number, numpy's too, as a float; raise InputError for anything else."""
    number = plain_value(value, what)
    if isinstance(number, bool) or not isinstance(number, int | float):
        raise InputError(f"{what}: {number!r} must be a number")
    return float(number)
