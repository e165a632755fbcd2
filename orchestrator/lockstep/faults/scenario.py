"""What a scenario file says, as frozen values. `lockstep.faults` tells what the kinds mean."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from lockstep.system.component import Value

Kind = Literal["stuck", "bias", "scale", "noise", "dropout", "delay", "quantisation", "spike", "nan"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Fault:
    """One entry of a file. `amount` is value, factor, deviation or step: one number, or one an element."""

    place: str  # for messages: `faults.toml: fault 2 (gyro drifts)`
    name: str  # for events
    kind: Kind
    begin: int  # [ns]
    end: int | None  # [ns]; None: the end of the run, or for a single spike its transfer
    connections: tuple[str, ...] = ()  # patterns
    parameters: tuple[str, ...] = ()  # patterns
    validity: tuple[str, ...] = ()  # patterns; of a dropout
    amount: tuple[Value, ...] = ()
    unit: str | None = None  # of `amount`; None: what each variable has
    invalid: int = 0  # what a dropout makes of an Integer flag
    ticks: int = 0  # of a delay
    probability: float | None = None  # of a spike; None: the first transfer
    seed: int = 0


@dataclass(frozen=True, slots=True, kw_only=True)
class Scenario:
    """A whole file, and what it takes to repeat it."""

    path: Path
    sha256: str
    text: str
    faults: tuple[Fault, ...]
