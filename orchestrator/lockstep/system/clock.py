"""Time as an exact number of nanoseconds, whole or a fraction, and its exact text in seconds."""

import re
from decimal import Decimal, InvalidOperation
from fractions import Fraction
from math import gcd, lcm

from lockstep.errors import InputError
from lockstep.plain_values import plain_whole

Time = int | Fraction  # [ns]; a Fraction only where it is not whole, such as 1/60 s

_SECOND = 10**9  # [ns]
SAME_TIME = 1e-9  # [s]: times of rows that differ by less are the same; sums of periods are rounded
_LONGEST = 9_200_000_000  # [s]: 64 bits of nanoseconds, 292 years
_FRACTION = re.compile(r"\s*([+-]?\d+)\s*/\s*(\d+)\s*", re.ASCII)
_DECIMALS = range(12, 31)  # digits after the point of a number that may be a rounded fraction
_LARGEST_DENOMINATOR = 100_000  # of such a fraction of a second: it has 1e-12 s to itself, as its neighbours do


def nanoseconds(seconds: str | float | int | Decimal | Fraction, what: str) -> Time:
    """Convert seconds to nanoseconds exactly: decimal seconds, or a fraction such as `1/60`.

    A decimal that is no whole number of nanoseconds and has 12 decimals or more is taken for the fraction p/q with
    q <= 100,000 that it is nearest to, if the two differ by at most one unit of its last decimal, or are the same
    double: 0.016666666666666666 is 1/60.

    Raises
    ------
    InputError
        If `seconds` is not a finite number, neither a whole number of nanoseconds nor such a fraction, or longer than
        292 years; `what` names it.
    """
    value = _number(seconds)
    if value is None:
        raise InputError(f"{what}: {seconds!r} is not a number of seconds; write for example 0.001 or 1/60")
    if not -_LONGEST <= value <= _LONGEST:
        given = f"{float(value) if isinstance(value, Fraction) else value:.3g}"
        raise InputError(
            f"{what}: {given} s is more than {float(_LONGEST):g} s, which is 292 years; choose a shorter time"
        )
    time = value * _SECOND
    if isinstance(value, Fraction):
        return plain_time(time, what)
    if time == int(time):
        return int(time)
    fraction = _rounded_fraction(value)
    if fraction is None:
        remedy = f"nor a fraction of a second with a denominator up to {_LARGEST_DENOMINATOR}; write one as 1/60"
        raise InputError(f"{what}: {seconds} s is not a whole number of nanoseconds, {remedy}")
    return plain_time(fraction * _SECOND, what)


def _rounded_fraction(value: Decimal) -> Fraction | None:
    """Return the fraction of which a decimal is the rounded or cut off value, or None."""
    digit = value.as_tuple().exponent
    assert isinstance(digit, int)  # the number is finite
    if -digit not in _DECIMALS:
        return None
    exact = Fraction(value)
    nearest = exact.limit_denominator(_LARGEST_DENOMINATOR)
    near = abs(nearest - exact) <= Fraction(10) ** digit or float(nearest) == float(exact)
    return nearest if near and nearest else None


def _number(seconds: object) -> Decimal | Fraction | None:
    """Return a number of seconds: a Fraction of what is written as one, else a Decimal; None for anything else."""
    if isinstance(seconds, Fraction):
        return seconds
    text = float.__repr__(seconds) if isinstance(seconds, float) else str(seconds).strip()
    match = _FRACTION.fullmatch(text)
    if match is not None:
        return Fraction(int(match[1]), int(match[2])) if int(match[2]) else None
    try:
        value = Decimal(text)
    except (InvalidOperation, ValueError):
        return None
    return value if value.is_finite() else None


def positive_nanoseconds(seconds: str | float | int | Decimal | Fraction, what: str) -> Time:
    """Convert seconds to nanoseconds exactly; raise InputError, also for 0 and less."""
    time = nanoseconds(seconds, what)
    if time <= 0:
        raise InputError(f"{what} {seconds}: must be > 0 s")
    return time


def plain_time(value: object, what: str) -> Time:
    """Return a time as an int, or a Fraction where it is not whole; raise InputError for anything else."""
    if not isinstance(value, Fraction):
        return plain_whole(value, what)
    return value.numerator if value.denominator == 1 else value


def seconds(time: Time) -> float:
    """Return the double nearest to `time` nanoseconds, in seconds."""
    return time / 1e9 if isinstance(time, int) else float(time / _SECOND)  # each rounds once


def seconds_text(time: Time) -> str:
    """Write nanoseconds as exact decimal seconds, without an exponent; or as a fraction, 1/60."""
    if time.denominator != 1:
        return str(time / _SECOND)
    text = f"{Decimal(int(time)) / _SECOND:f}"
    return text.rstrip("0").rstrip(".") if "." in text else text


def stored_seconds(time: Time) -> float | str:
    """Return seconds for a file: the nearest double where `nanoseconds` gives the time back from it, else a text."""
    number = seconds(time)
    try:
        return number if nanoseconds(number, "") == time else seconds_text(time)
    except InputError:
        return seconds_text(time)


def stored_nanoseconds(time: Time) -> int | str:
    """Return nanoseconds for JSON: a whole number, or a fraction as a text."""
    return int(time) if time.denominator == 1 else str(time)


def read_nanoseconds(value: int | str, what: str) -> Time:
    """Return what `stored_nanoseconds` wrote; raise InputError for anything else."""
    match = _FRACTION.fullmatch(value) if isinstance(value, str) else None
    if match is None or not int(match[2]):
        return plain_whole(value, what)
    return plain_time(Fraction(int(match[1]), int(match[2])), what)


def common_divisor(*times: Time) -> Time:
    """Return the greatest time of which all these are multiples."""
    scale = lcm(*(time.denominator for time in times))
    return plain_time(Fraction(gcd(*(int(time * scale) for time in times)), scale), "")


def common_multiple(*times: Time) -> Time:
    """Return the least time that is a multiple of all these."""
    scale = lcm(*(time.denominator for time in times))
    return plain_time(Fraction(lcm(*(int(time * scale) for time in times)), scale), "")
