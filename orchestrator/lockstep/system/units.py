"""Units by their base-unit exponents, and the linear conversion between two of them."""

from dataclasses import dataclass

from lockstep.errors import InputError

BASES = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")


@dataclass(frozen=True, slots=True, kw_only=True)
class Unit:
    """A named unit. Without exponents only its name is known, and it can be compared by name alone.

    A value v in this unit is factor * v + offset in the base units.
    """

    name: str
    exponents: tuple[int, ...] | None = None  # of BASES, in that order
    factor: float = 1.0
    offset: float = 0.0


def known_unit(told: Unit | None, declared: Unit | None) -> Unit | None:
    """Return the unit that an FMU tells; of one that it only names, what the system file declares."""
    if told is None or (told.exponents is None and declared is not None):
        return declared
    return told


def conversion(source: Unit | None, target: Unit | None, relative: bool = False) -> tuple[float, float]:
    """Return (gain, bias) with which target value = gain * source value + bias.

    An undeclared unit is taken to be the other end's. A difference of values (`relative`) has no bias.

    Raises
    ------
    ValueError
        If the units measure different things or cannot be compared.
    """
    if source is None or target is None or source == target:
        return 1.0, 0.0
    if source.exponents is None or target.exponents is None:
        if source.name == target.name:
            return 1.0, 0.0
        raise ValueError(f"units '{source.name}' and '{target.name}' cannot be compared without base units")
    if source.exponents != target.exponents:
        if _same_but_rad(source, target):
            return 1.0, 0.0
        raise ValueError(f"unit {describe(source)} does not convert to {describe(target)}")
    gain = source.factor / target.factor
    bias = 0.0 if relative else (source.offset - target.offset) / target.factor
    return gain, bias


def _same_but_rad(one: Unit, other: Unit) -> bool:
    """Tell whether two units of one name differ in the exponent of rad alone: some tools write rad as 1.

    Between units of different names it counts, or Hz would become rad/s without a factor.
    """
    mine, its = one.exponents or (), other.exponents or ()
    equal = (one.name, one.factor, one.offset) == (other.name, other.factor, other.offset)
    return equal and mine[: len(BASES) - 1] == its[: len(BASES) - 1]


def describe(unit: Unit) -> str:
    """Write a unit with its base units: `N.m [kg.m2.s-2]`."""
    powers = [f"{b}{e if e != 1 else ''}" for b, e in zip(BASES, unit.exponents or (), strict=False) if e]
    return f"'{unit.name}' [{'.'.join(powers) or '1'}]"


def checked_conversion(source: Unit | None, target: Unit | None, relative: bool, what: str) -> tuple[float, float]:
    """Return `conversion`, or raise InputError naming what would be converted."""
    try:
        return conversion(source, target, relative)
    except ValueError as error:
        raise InputError(f"{what}: {error}; correct a unit, or set suppressUnitConversion") from None
