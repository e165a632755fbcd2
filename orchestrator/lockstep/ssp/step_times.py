"""Resolve step size, kind and latency for SSP files without `lockstep` annotations.

SSP defines none of them. The first of these sources that has a value is used:

- period: the command line for this component, the command line for all, the file's annotation, the StepSizeHint of
  the Open Simulation Platform, the step of its master or of OMSimulator's in the file, the FMU's default step size, the
  smallest step of the other components, 1 ms; the last two with a warning;
- kind: the command line, the file's annotation; otherwise continuous, whatever the variability of the outputs: in FMI,
  they are true at the end of a step. Those of a sampled component hold from the start of its step on;
- delay of a connection: the command line, the file's annotation, the newest value available: that of the same tick from
  a sampled component, that of one tick ago, which is true now, from a continuous one;
- tick: the file's annotation, the command line, the greatest time of which all periods and offsets are multiples.

Without annotations and with continuous components alone this is the scheme of other masters: all read the values at
the start of their steps, then step (Jacobi).
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

from lockstep.errors import InputError, compact
from lockstep.fmi.model_description import Description
from lockstep.ssp.annotations import DeclaredSteps
from lockstep.system.clock import Time, common_divisor, nanoseconds, positive_nanoseconds, seconds_text
from lockstep.system.component import Kind
from lockstep.system.name_patterns import given_for, named
from lockstep.system.system import System

DEFAULT_STEP = 1_000_000  # [ns], where nothing gives one


def timing_of_run(run: Mapping[str, Any]) -> "Timing":
    """Return the times of a run from its run.toml, with which its system file can be read again."""
    return Timing(
        tick=nanoseconds(run["tick"], "tick"),
        periods={c["name"]: nanoseconds(c["period"], c["name"]) for c in run["component"]},
        kinds={c["name"]: c["kind"] for c in run["component"]},
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class Timing:
    """Times given on the command line, in ns, and delays in ticks; None: not given."""

    tick: Time | None = None
    period: Time | None = None  # of all components
    periods: Mapping[str, Time] = field(default_factory=dict)  # by name, or by pattern with `*` and `?`
    kinds: Mapping[str, Kind] = field(default_factory=dict)
    delay: int | None = None  # of all connections

    def check_names(self, system: System) -> None:
        """Raise InputError where a period or kind is given for no component."""
        names = [component.name for component in system.components]
        for pattern in self.periods:
            named(pattern, names)
        for name, kind in self.kinds.items():
            try:
                system.component(name)
            except InputError as error:
                raise InputError(f"--{kind} {error}") from None

    def given_period(self, name: str) -> Time | None:
        """Return the period that is given for a component or for all [ns], None if none is."""
        own = given_for(name, self.periods, "--step-size")
        return self.period if own is None else own

    def needs_description(self, name: str, steps: DeclaredSteps) -> bool:
        """Return whether the description of the FMU is needed."""
        return (steps.period or steps.hint or self.given_period(name)) is None

    def period_of(self, name: str, steps: DeclaredSteps, description: Description | None) -> Time | None:
        """Return the period of a component [ns], None if nothing gives it, or raise InputError."""
        for answer in (self.given_period(name), steps.period, steps.hint):
            if answer is not None:
                return answer
        if description is None or description.step_size is None:
            return None
        remedy = f"give --step-size {name}=S in seconds, or --step-size S for all"
        try:
            return positive_nanoseconds(description.step_size, f"{name}: the FMU's step size")
        except InputError as error:
            raise InputError(f"{error}; {remedy}") from None

    def periods_of(
        self, given: Mapping[str, tuple[DeclaredSteps, Description | None]], warnings: list[str]
    ) -> dict[str, Time]:
        """Return the periods of all components [ns], with a warning for those that nothing gives."""
        found = {name: self.period_of(name, *sources) for name, sources in given.items()}
        known = [period for period in found.values() if period is not None]
        default = min(known, default=DEFAULT_STEP)
        unknown = [name for name, period in found.items() if period is None]
        if unknown:
            warnings.append(
                f"{compact(unknown)}: neither the file nor the FMU gives a step size: stepped every"
                f" {seconds_text(default)} s; --step-size changes it"
            )
        return {name: default if period is None else period for name, period in found.items()}

    def kind_of(self, name: str, steps: DeclaredSteps) -> Kind:
        """Return the kind: whether outputs hold from the start of a step on, or are true at its end."""
        return self.kinds.get(name) or steps.kind or "continuous"

    def delay_of(self, declared: int | None, producer: Kind) -> int:
        """Return the delay of a connection [ticks]."""
        if self.delay is not None:
            return self.delay
        return declared if declared is not None else int(producer == "continuous")

    def tick_of(self, declared: Time | None, times: Iterable[Time]) -> Time:
        """Return the base tick [ns] for periods and offsets, or raise InputError."""
        if declared is not None and self.tick not in (None, declared):
            raise InputError(
                f"--tick {seconds_text(self.tick or 0)}: the file has a tick of {seconds_text(declared)} s, in which "
                "its delays count; change it there"
            )
        if declared is not None or self.tick is not None:
            return declared or self.tick or 0
        return common_divisor(*times)
