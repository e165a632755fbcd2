"""Hold the contents of a scenario file as frozen values. `lockstep.faults` describes the kinds."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from lockstep.system.clock import Time
from lockstep.system.component import Value

Kind = Literal["stuck", "bias", "scale", "noise", "dropout", "delay", "quantisation", "spike", "nan"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Fault:
    """One entry of a file. `amount` is value, factor, deviation or step: one number, or one for each element."""

    location: str  # for messages: `faults.toml: fault 2 (gyro drifts)`
    name: str  # for events
    kind: Kind
    begin: Time  # [ns]
    end: Time | None  # [ns]; None: the end of the run, or for a single spike its transfer
    connections: tuple[str, ...] = ()  # patterns
    parameters: tuple[str, ...] = ()  # patterns
    validity: tuple[str, ...] = ()  # patterns; of a dropout
    amount: tuple[Value, ...] = ()
    unit: str | None = None  # of `amount`; None: that of each variable
    invalid: int = 0  # value of an Integer flag in a dropout
    ticks: int = 0  # of a delay
    probability: float | None = None  # of a spike; None: the first transfer
    seed: int = 0


@dataclass(frozen=True, slots=True, kw_only=True)
class Scenario:
    """A whole file, with its text and hash, from which a run can be repeated."""

    path: Path
    sha256: str
    text: str
    faults: tuple[Fault, ...]
