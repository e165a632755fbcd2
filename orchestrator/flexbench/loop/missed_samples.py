"""Refuse a loop in which a component would miss samples of the star tracker.

The sensors flag a sample by `star_tracker.valid` until their next fast one. A component that reads less often than
that, at other times than those of the samples, finds the flag false again and never uses the sample.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from fractions import Fraction
from typing import cast

from lockstep import InputError, System
from lockstep.fmi.model_description import read_description
from lockstep.fmi.parameter_values import parse_value, with_unit
from lockstep.system.clock import Time, common_divisor, nanoseconds, seconds_text
from lockstep.system.component import Component, Value

FLAG = "star_tracker.valid"
SAMPLING = "star_tracker.period"  # parameter of the component that has the flag: time between two samples
DURATION = "fast_period"  # parameter: how long the flag stays true
Spell = Callable[[str], str]
SPELLINGS: tuple[Spell, ...] = (str, lambda name: name.replace(".", "_"))  # as in FMUs with structured and flat names


def refuse_missed_samples(system: System, overrides: Mapping[str, object]) -> None:
    """Check every component that reads the flag of a star tracker.

    Parameters
    ----------
    system : that is simulated, with its delays and step sizes
    overrides : parameters of the run by `component.parameter`

    Raises
    ------
    InputError
        If one would miss samples. A sensor FMU of others, without the parameters of flexsat's, is not judged.
    """
    for connection in system.connections:
        for spell in SPELLINGS:
            if connection.output == spell(FLAG):
                source, reader = (system.component(c) for c in (connection.from_component, connection.to_component))
                sampling, duration = (_period(source, spell(name), overrides) for name in (SAMPLING, DURATION))
                if sampling is None or duration is None:
                    continue
                shift = reader.offset - source.offset - connection.delay * system.tick
                for name, period in _readers(reader):
                    missed = missed_share(sampling, duration, period, shift)
                    if missed:
                        every, remedy = seconds_text(period), ""
                        if sampling % period:
                            remedy = f"{source.name}.{spell(SAMPLING)} to a whole multiple of {every} s, or "
                        raise InputError(
                            f"{name}: would miss {missed.numerator} of {missed.denominator} star tracker samples:"
                            f" {source.name}.{connection.output} stays true for {seconds_text(duration)} s after each,"
                            f" every {seconds_text(sampling)} s, and {name} reads every {every} s;"
                            f" set {remedy}{source.name}.{spell(DURATION)} to at least {every} s"
                        )


def missed_share(sampling: Time, duration: Time, period: Time, shift: Time) -> Fraction:
    """Return the share of samples that a reader misses; all times in nanoseconds.

    Parameters
    ----------
    sampling, duration : samples are taken every `sampling`, and flagged for `duration` each
    period, shift : the reader reads every `period`, `shift` after the time of a sample when it reads first

    The time from a sample to the next read takes the values (shift mod g) + i g, with g the common divisor of both
    periods, each equally often.
    """
    divisor = common_divisor(sampling, period)
    count, least = period // divisor, shift % divisor
    seen = -(-(duration - least) // divisor) if duration > least else 0
    return Fraction(max(0, count - seen), count)


def _readers(component: Component) -> Iterator[tuple[str, Time]]:
    """Yield the names and periods [ns] of what reads: the component, and the one in its shadow."""
    if component.shadow is None:
        yield component.name, component.period
    else:
        yield component.name, component.shadow.period
        yield component.shadow.component.name, component.shadow.component.period


def _period(component: Component, name: str, overrides: Mapping[str, object]) -> Time | None:
    """Return a parameter of a component [ns]: of the run, of the system, or the FMU's own; None if it has none."""
    variable = read_description(component).variables.get(name)
    given = overrides.get(f"{component.name}.{name}", component.parameters.get(name, variable and variable.start))
    if variable is None or variable.causality != "parameter" or given is None:
        return None
    try:
        time = nanoseconds(str(parse_value(cast(Value, given), variable, name) if with_unit(given) else given), name)
    except InputError:
        return None  # no such time: the run refuses it in its own words
    return time if time > 0 else None
