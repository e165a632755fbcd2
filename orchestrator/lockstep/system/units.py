"""Describe units by their base-unit exponents, and convert linearly between two of them."""

from dataclasses import dataclass, replace

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


def known_unit(fmu: Unit | None, declared: Unit | None) -> Unit | None:
    """Return the unit that an FMU defines; where it gives none, or a name alone, that of the system file."""
    if fmu is None or (fmu.exponents is None and declared is not None):
        return declared
    return fmu


def conversion(source: Unit | None, target: Unit | None, relative: bool = False) -> tuple[float, float]:
    """Return (gain, bias) with which target value = gain * source value + bias.

    A value without a unit is taken to be in that of the other end. A difference (`relative`) has no bias.

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
    """Return whether two units of one name differ in the exponent of rad alone: some tools write rad as 1.

    Between units of different names it counts, or Hz would become rad/s without a factor.
    """
    return one.name == other.name and without_radian(one) == without_radian(other)


def without_radian(unit: Unit) -> Unit:
    """Return a unit with the exponent of rad set to 0: files that write rad as 1 leave it out."""
    if unit.exponents is None:
        return unit
    return replace(
        unit, exponents=tuple(0 if base == "rad" else e for base, e in zip(BASES, unit.exponents, strict=True))
    )


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
