"""When the components of a system file of others are stepped, which SSP does not say, and how old their values are.

Asked in this order, until one answers:

- period: the command line for this component, the command line for all, the file's annotation, the StepSizeHint of
  the Open Simulation Platform, the step of its master or of OMSimulator's in the file, the FMU's default step size;
- kind: the command line, the file's annotation, the FMU: with discrete outputs alone it is sampled, so that its
  outputs hold from the start of the step on; otherwise continuous: FMI has outputs true at the end of a step;
- delay of a connection: the command line, the file's annotation, the newest value there is: that of the same tick from
  a sampled component, that of one tick ago, which is true now, from a continuous one;
- tick: the file's annotation, the command line, the greatest time of which all periods and offsets are multiples.

With no annotations and continuous components alone this is the scheme of other masters: all take what is true at the
start of their steps, then step (Jacobi).
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from math import gcd
from typing import Any

from lockstep.errors import InputError
from lockstep.fmi.model_description import Description
from lockstep.ssp.annotations import Told
from lockstep.system.clock import nanoseconds, seconds_text
from lockstep.system.component import Kind


def timing_of_run(run: Mapping[str, Any]) -> "Timing":
    """Return the times of a run from its run.toml, with which its system file can be read again."""
    return Timing(
        tick=nanoseconds(run["tick"], "tick"),
        periods={c["name"]: nanoseconds(c["period"], c["name"]) for c in run["component"]},
        kinds={c["name"]: c["kind"] for c in run["component"]},
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class Timing:
    """What the command line says. Times in ns, delays in ticks; None: nothing."""

    tick: int | None = None
    period: int | None = None  # of all components
    periods: Mapping[str, int] = field(default_factory=dict)
    kinds: Mapping[str, Kind] = field(default_factory=dict)
    delay: int | None = None  # of all connections

    def names(self) -> list[str]:
        """Return the components that are named."""
        return [*self.periods, *self.kinds]

    def needs_description(self, name: str, told: Told) -> bool:
        """Tell whether the FMU has to be asked."""
        known = told.period or told.hint or self.period or self.periods.get(name)
        return known is None or (told.kind is None and name not in self.kinds)

    def period_of(self, name: str, told: Told, description: Description | None) -> int:
        """Return the period of a component [ns], or raise InputError."""
        for answer in (self.periods.get(name), self.period, told.period, told.hint):
            if answer is not None:
                return answer
        remedy = f"give --step-size {name}=S in seconds, or --step-size S for all"
        if description is None or description.step_size is None:
            raise InputError(f"{name}: neither the file nor the FMU gives its step size; {remedy}")
        try:
            return nanoseconds(description.step_size, f"{name}: the FMU's step size")
        except InputError as error:
            raise InputError(f"{error}; {remedy}") from None

    def kind_of(self, name: str, told: Told, description: Description | None) -> Kind:
        """Return whether the outputs of a component hold from the start of a step, or are true at its end."""
        kind = self.kinds.get(name) or told.kind
        if kind is not None:
            return kind
        outputs = [] if description is None else [v for v in description.variables.values() if v.causality == "output"]
        return "sampled" if outputs and all(v.variability == "discrete" for v in outputs) else "continuous"

    def delay_of(self, told: int | None, producer: Kind) -> int:
        """Return the delay of a connection [ticks]."""
        if self.delay is not None:
            return self.delay
        return told if told is not None else int(producer == "continuous")

    def tick_of(self, told: int | None, times: Iterable[int]) -> int:
        """Return the base tick [ns] for periods and offsets, or raise InputError."""
        if told is not None and self.tick not in (None, told):
            raise InputError(
                f"--tick {seconds_text(self.tick or 0)}: the file has a tick of {seconds_text(told)} s, in which its "
                "delays count; change it there"
            )
        if told is not None or self.tick is not None:
            return told or self.tick or 0
        return gcd(*times)
