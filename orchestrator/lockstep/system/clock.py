"""Time as an integer number of nanoseconds, and its exact text in seconds."""

from decimal import Decimal, InvalidOperation

from lockstep.errors import InputError

_NANOSECONDS = Decimal(10**9)


def nanoseconds(seconds: str | float | int | Decimal, what: str) -> int:
    """Convert decimal seconds to nanoseconds exactly.

    Raises
    ------
    InputError
        If `seconds` is not a finite number or not a whole number of nanoseconds; `what` names it.
    """
    try:
        exact = Decimal(float.__repr__(seconds) if isinstance(seconds, float) else str(seconds).strip()) * _NANOSECONDS
        whole = int(exact)
    except (InvalidOperation, ValueError, OverflowError):
        raise InputError(f"{what}: {seconds!r} is not a number of seconds; write for example 0.001") from None
    if whole != exact:
        raise InputError(f"{what}: {seconds} s is not a whole number of nanoseconds")
    return whole


def seconds(time: int) -> float:
    """Return the double nearest to `time` nanoseconds, in seconds."""
    return time / 1e9  # true division of exactly represented operands rounds once


def seconds_text(time: int) -> str:
    """Write nanoseconds as exact decimal seconds, without an exponent."""
    text = f"{Decimal(time) / _NANOSECONDS:f}"
    return text.rstrip("0").rstrip(".") if "." in text else text
