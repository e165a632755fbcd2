"""Values that are not finite: they end the run where something uses them, and are reported once where nothing does."""

from collections.abc import Callable, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from lockstep.errors import RunError, compact
from lockstep.fmi.slave import Scalar
from lockstep.plan.bus_layout import Reference

Names = Mapping[tuple[str, Scalar, int], str]  # of the variables that are set or fetched
AddEvent = Callable[..., None]  # called with the name of an event and its details


class NotFinite:
    """What was not finite and is used by nothing: an event when it is found first, and a warning for all."""

    def __init__(self, used: Mapping[str, frozenset[Reference]], names: Names, add_event: AddEvent) -> None:
        self._used, self._names, self._add_event = used, names, add_event
        self._known: dict[str, dict[int, tuple[float, float]]] = {}  # by component: value and time [s] by reference

    def check(self, component: str, references: Sequence[int], values: NDArray[np.float64], time: float) -> None:
        """Note the Reals that are not finite at a time [s]; raise RunError, without the FMU's log, if one is used."""
        bad = [k for k in np.flatnonzero(~np.isfinite(values)).tolist() if references[k] not in self._of(component)]
        used = [k for k in bad if ("Real", references[k]) in self._used[component]]
        if used:
            names = compact(self._names[component, "Real", references[k]] for k in used)
            value = f"{values[used[0]]} at {time:.9g} s"
            raise RunError(f"{component}.{names}: is {value}; every exchanged value must be finite")
        if bad:
            self._of(component).update((references[k], (float(values[k]), time)) for k in bad)
            names = compact(self._names[component, "Real", references[k]] for k in bad)
            self._add_event("not-finite", component=component, variables=names, value=str(values[bad[0]]), at=time)

    def _of(self, component: str) -> dict[int, tuple[float, float]]:
        return self._known.setdefault(component, {})

    @property
    def warnings(self) -> tuple[str, ...]:
        """One line with all that was found, or nothing."""
        groups: dict[tuple[str, str, float], list[str]] = {}
        for component, found in self._known.items():
            for reference, (value, time) in found.items():
                name = self._names[component, "Real", reference]
                groups.setdefault((component, str(value), time), []).append(name)
        texts = [f"{c}.{compact(names)} ({value} at {time:.9g} s)" for (c, value, time), names in groups.items()]
        if not texts:
            return ()
        more = f"; and {len(texts) - 12} more" if len(texts) > 12 else ""
        return (f"recorded though not finite, as no connection uses it: {'; '.join(texts[:12])}{more}",)
