"""The order of calls that FMI 2.0 allows in co-simulation (2.0.4, section 4.2.4), for a slave that steps at once.

Of the standard's states this slave has no step in progress, failed or cancelled: a step is done, or an error.
"""

from __future__ import annotations

from collections.abc import Mapping
from enum import IntEnum
from types import MappingProxyType

from .port_values import Refused


class Phase(IntEnum):
    """State of an instance in the FMI life cycle; the shim (`shim/shim.h`) has the same numbers."""

    INSTANTIATED = 1
    INITIALIZING = 2
    STEPPING = 3
    TERMINATED = 4
    FAILED = 5


_GET = frozenset({Phase.INITIALIZING, Phase.STEPPING, Phase.TERMINATED, Phase.FAILED})
_SET = frozenset({Phase.INSTANTIATED, Phase.INITIALIZING, Phase.STEPPING})

# Calls that touch states, free or reset the instance are allowed in every phase, and do not stand here.
ALLOWED: Mapping[str, frozenset[Phase]] = MappingProxyType(
    {
        "setupExperiment": frozenset({Phase.INSTANTIATED}),
        "enterInitializationMode": frozenset({Phase.INSTANTIATED}),
        "exitInitializationMode": frozenset({Phase.INITIALIZING}),
        "doStep": frozenset({Phase.STEPPING}),
        "terminate": frozenset({Phase.STEPPING}),
        "get": _GET,  # of every kind; after an error for debugging only
        "set": _SET,
    }
)
_MOMENTS = {
    Phase.INSTANTIATED: "before fmi2EnterInitializationMode",
    Phase.INITIALIZING: "before fmi2ExitInitializationMode",
    Phase.STEPPING: "after fmi2ExitInitializationMode",
    Phase.TERMINATED: "after fmi2Terminate",
}


def check_order(call: str, phase: Phase, failure: str | None) -> None:
    """Refuse a call that the phase does not allow; `failure` is why the phase is FAILED."""
    if phase in ALLOWED[call]:
        return
    if phase is Phase.FAILED:
        raise Refused(f"refused since: {failure}")
    raise Refused(f"not allowed {_MOMENTS[phase]}")
