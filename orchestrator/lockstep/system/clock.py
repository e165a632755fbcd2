"""Time as an integer number of nanoseconds, and its exact text in seconds."""

from decimal import Decimal, InvalidOperation

from lockstep.errors import InputError

_NANOSECONDS = Decimal(10**9)
_LONGEST = Decimal(9_200_000_000)  # [s]: 64 bits of nanoseconds, 292 years


def nanoseconds(seconds: str | float | int | Decimal, what: str) -> int:
    """Convert decimal seconds to nanoseconds exactly.

    Raises
    ------
    InputError
        If `seconds` is not a finite number, not a whole number of nanoseconds, or longer than 292 years; `what`
        names it.
    """
    try:
        value = Decimal(float.__repr__(seconds) if isinstance(seconds, float) else str(seconds).strip())
    except (InvalidOperation, ValueError):
        value = Decimal("nan")
    if not value.is_finite():
        raise InputError(f"{what}: {seconds!r} is not a number of seconds; write for example 0.001")
    if value.copy_abs() > _LONGEST:
        raise InputError(
            f"{what}: {value:.3g} s is more than {_LONGEST:g} s, which is 292 years; choose a shorter time"
        )
    whole = int(value * _NANOSECONDS)
    if whole / _NANOSECONDS != value:
        raise InputError(f"{what}: {seconds} s is not a whole number of nanoseconds")
    return whole


def positive_nanoseconds(seconds: str | float | int | Decimal, what: str) -> int:
    """Convert decimal seconds to nanoseconds exactly; raise InputError, also for 0 and less."""
    time = nanoseconds(seconds, what)
    if time <= 0:
        raise InputError(f"{what} {seconds}: must be > 0 s")
    return time


def seconds(time: int) -> float:
    """Return the double nearest to `time` nanoseconds, in seconds."""
    return time / 1e9  # true division of exactly represented operands rounds once


def seconds_text(time: int) -> str:
    """Write nanoseconds as exact decimal seconds, without an exponent."""
    text = f"{Decimal(time) / _NANOSECONDS:f}"
    return text.rstrip("0").rstrip(".") if "." in text else text
