"""The life cycle of an instance as a part of its saved state."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from math import inf, isfinite
from typing import Any

import numpy as np

from .call_order import Phase

AnyArray = np.ndarray[Any, Any]
_TYPES = {
    "phase": np.int64, "experiment": np.bool_, "time": np.float64, "step": np.float64, "started": np.bool_,
    "stale": np.bool_, "inputs_set": np.bool_,
}  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True)
class SavedLifeCycle:
    """What an instance was doing when its state was saved."""

    phase: Phase
    experiment: bool  # whether it was set up
    time: float  # s, the communication point that it had reached
    step: float  # s, of all steps, where the first one sets it; else 0
    started: bool  # whether the model was
    stale: bool  # whether the outputs on demand were older than the state
    inputs_set: bool  # whether inputs were set since outputs that follow them were computed

    def values(self) -> dict[str, AnyArray]:
        """Return the values by name."""
        return {item.name: np.array(getattr(self, item.name), _TYPES[item.name]) for item in fields(self)}

    @classmethod
    def read(cls, values: Mapping[str, AnyArray]) -> SavedLifeCycle:
        """Return saved values, or raise ValueError if no instance can have them."""
        for name, kind in _TYPES.items():
            if name not in values or values[name].shape != () or values[name].dtype != kind:
                raise ValueError(f"the saved state lacks life_cycle.{name}")
        found = {name: values[name].item() for name in _TYPES}
        made = cls(**found | {"phase": Phase(found["phase"])})  # the constructor of a phase refuses other numbers
        running = made.phase in (Phase.STEPPING, Phase.TERMINATED)
        if (
            not isfinite(made.time)
            or not 0.0 <= made.step < inf
            or (running and not (made.started and made.experiment))
        ):
            raise ValueError("the saved state has a life cycle that no instance can have")
        return made
