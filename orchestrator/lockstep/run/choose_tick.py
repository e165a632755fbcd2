"""Choose what executes the ticks of a run: the library in C where it can be had, else Python, with equal results."""

from __future__ import annotations

from dataclasses import dataclass

from lockstep.errors import InputError
from lockstep.system.clock import Time
from lockstep.tick import IMPLEMENTATIONS
from lockstep.tick.c_tick import CTick
from lockstep.tick.compiled import NoLibrary, load
from lockstep.tick.operations import Clock, Program, Rows, Ticking, Times
from lockstep.tick.python_tick import PythonTick
from lockstep.tick.step_threads import ThreadLimit, threads_given


@dataclass(frozen=True, slots=True, kw_only=True)
class TickChoice:
    """One of the two implementations, and why it is not that in C."""

    in_c: bool
    reason: str  # empty, or why `auto` is Python
    times: Times
    threads: ThreadLimit

    def start(
        self, program: Program, first: int, clock: Clock, rows: Rows | None, *, measured: bool = False
    ) -> Ticking:
        """Return what executes a program from a tick on; `rows` is the recorder that its captures fill in.

        Where the wall time goes is always measured in C, and in Python if asked for: it makes short ticks slower.
        """
        if self.in_c:
            return CTick(program, self.times, first, clock, rows, self.threads)
        return PythonTick(program, self.times, first, clock, measured=measured)

    @property
    def several(self) -> bool:
        """Whether threads may step components beside each other."""
        return self.in_c and self.threads.several

    @property
    def record(self) -> dict[str, object]:
        """The entries for run.toml."""
        reason = {"tick_in_reason": self.reason} if self.reason else {}
        return {"tick_in": "c" if self.in_c else "python", **reason}


def choose_tick(wanted: str, tick: Time, start: Time, last: int, threads: int | str | None = None) -> TickChoice:
    """Return what executes ticks of a length from a start [ns] to the last one.

    `wanted` is `auto`, `python` or `c`. Raises InputError for another word, and if C is wanted and cannot be had, also
    for a number of threads above 1.
    """
    if wanted not in IMPLEMENTATIONS:
        raise InputError(f"tick {wanted!r}: no such implementation; choose {', '.join(IMPLEMENTATIONS)}")
    times, limit = Times.of(tick, start), threads_given(threads)
    reason = "" if wanted == "python" else _obstacle(times, last)
    if limit.always and limit.several and (wanted == "python" or reason):
        raise InputError(f"threads {threads!r}: need the tick in C" + (f": {reason}" if reason else "; choose tick c"))
    if reason and wanted == "c":
        raise InputError(f"tick in C: {reason}; or choose auto or python, which give the same results")
    return TickChoice(in_c=wanted != "python" and not reason, reason=reason, times=times, threads=limit)


def _obstacle(times: Times, last: int) -> str:
    """Return why the tick in C cannot be had, with the remedy, or nothing."""
    if not times.exact_until(last + 1):
        return "the times of ticks have more than 53 bits; choose a step size with fewer digits"
    try:
        load()
    except NoLibrary as error:
        return str(error)
    return ""
