"""A run that is stepped from Python: values are read and set between two ticks, and its state is kept and restored."""

from __future__ import annotations

import json
import operator
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from fractions import Fraction
from itertools import count
from pathlib import Path
from types import TracebackType
from typing import Any, NoReturn, Self

from lockstep.errors import InputError, RunError
from lockstep.interrupt import Interrupt, attend, dismiss
from lockstep.plan.overrides import Override
from lockstep.results.read import Signals, open_signals
from lockstep.simulation.open_run import OpenRun
from lockstep.simulation.snapshot import Branch, Snapshot, check_snapshot, restore_snapshot, take_snapshot
from lockstep.simulation.summary import RunSummary
from lockstep.simulation.values import Values
from lockstep.system.clock import nanoseconds, seconds, seconds_text
from lockstep.system.system import System
from lockstep.tick.structures import Reason

_MOST_SETS = 1000  # of one name that are events: a value that is set at each step must not fill the disk
_NEAR = Fraction(1, 10**6)  # [ticks] by which a time of the user may miss a tick: a sum of floats does
_NOT_QUICK = -1  # there is something to do between the ticks, or nothing more to step
_branches = count()


class Run:
    """A run between two ticks, as `lockstep.open` returns it.

    `run["plant.rate"]` is the present value of any variable that an FMU has: that at the end of its component's newest
    step. Leave it by `with` or by `close`, which record the last row and close the FMUs. Several may be open at once.
    """

    def __init__(self, opened: OpenRun, interrupt: Interrupt, stack: ExitStack) -> None:
        self._opened, self._interrupt, self._stack = opened, interrupt, stack
        self._loop = loop = opened.run.loop
        self._values = Values(opened.plan, opened.saver.slaves, opened.exchange, lambda: loop.time)
        self._why = ""  # it cannot be stepped
        self._quick: Callable[[], int]  # makes a step
        self._set_quick()
        self._summary: RunSummary | None = None
        self._branch: Branch = ((next(_branches), opened.first),)
        self._sets: dict[str, int] = {}  # events of each name

    @property
    def time(self) -> float:
        """Simulated time [s]: all ticks before it are complete."""
        return self._loop.time

    @property
    def stop_time(self) -> float:
        """The time [s] up to which the run can be stepped."""
        return seconds(self._opened.plan.stop_time)

    @property
    def tick(self) -> float:
        """The length [s] of a tick, which is one step."""
        return seconds(self._opened.plan.system.tick)

    @property
    def ended(self) -> str | None:
        """Why a component ended the run before its stop time; None if none did."""
        return None if self._opened.run.terminated is None else str(self._opened.run.terminated)

    @property
    def folder(self) -> Path | None:
        """The results folder; None: the run is in memory."""
        return self._opened.run.folder

    @property
    def system(self) -> System:
        """The system that is simulated."""
        return self._opened.plan.system

    @property
    def warnings(self) -> tuple[str, ...]:
        """What was amended in the system, and inputs that keep their start values."""
        return (*self._opened.plan.warnings, *self._opened.exchange.not_finite.warnings)

    @property
    def signals(self) -> Signals:
        """The rows recorded so far; that of the stop time is recorded when this is read there, or at the end.

        Those of a run with a folder are there once it is closed. Raises InputError before.
        """
        self._settle()
        if self.folder is not None:
            if self._summary is None and not self._why:
                raise InputError(f"signals: are in {self.folder} when the run is closed; or open it without a folder")
            return open_signals(self.folder)
        if not self._why and self._at_end:
            self._guarded(self._opened.record_last)
        return self._opened.signals()

    @property
    def events(self) -> list[dict[str, Any]]:
        """The events of the run so far: faults, messages of FMUs, values that were set."""
        self._settle()
        return [json.loads(line) for line in self._opened.run.events.kept().lines]

    @property
    def summary(self) -> RunSummary:
        """The summary of a run that is closed. Raises InputError before."""
        if self._summary is None:
            raise InputError("summary: is there when the run is closed")
        return self._summary

    @property
    def _at_end(self) -> bool:
        return self._loop.done >= self._opened.plan.ticks or self._opened.ended

    def step(self, n: int = 1) -> None:
        """Simulate n ticks, of the length of the system's tick.

        Raises
        ------
        InputError
            If the run is closed or failed, or would pass its stop time.
        RunError
            If a component, a value or the disk ends the run, which is closed then.
        KeyboardInterrupt
            After Ctrl-C. The run stays open, between two ticks.
        """
        if n != 1:
            attend(self._interrupt)
            self._to(self._loop.done + _whole(n))
            return
        interrupt = self._interrupt
        interrupt.stepping = True
        reason = self._quick()
        interrupt.stepping = False
        if reason or interrupt.requested:
            self._complete_step(reason)

    def _complete_step(self, reason: int) -> None:
        """Complete a step that the quick function has only begun, or refused."""
        if reason == _NOT_QUICK or self._why:
            self._to(self._loop.done + 1)
        elif reason == Reason.AT_LAST:
            self._refuse(self._loop.done + 1)
        elif reason:
            self._to(self._loop.done + 1, reason)
        self._raise_interrupt()

    def _to(self, tick: int, reason: int | None = None) -> None:
        if self._why or self._opened.ended or tick > self._opened.plan.ticks:
            self._refuse(tick)
        self._settle()
        interrupt = self._interrupt
        interrupt.stepping = True
        try:
            self._opened.advance(tick, reason)
        except BaseException as error:
            self._fail(error)
        finally:
            interrupt.stepping = False
        if self._opened.ended or (self._pausing and not self._loop.pauses):
            self._set_quick()
        self._raise_interrupt()

    def _raise_interrupt(self) -> None:
        if self._interrupt.requested:
            self._interrupt.requested = False
            raise KeyboardInterrupt

    def _set_quick(self) -> None:
        """Set what makes a step: a quick function if there is nothing to do between the ticks."""
        self._pausing = bool(self._loop.pauses)
        if self._pausing or self._why or self._opened.ended:
            self._quick = lambda: _NOT_QUICK
        else:
            self._quick = self._loop.stepper(self._opened.plan.ticks)

    def _settle(self) -> None:
        """Bring the recorder and the clock to where the quick steps have led."""
        if not self._why:
            self._loop.settle()

    def run_until(self, time: float | str) -> None:
        """Simulate up to a time [s], which is a whole number of ticks; raise as `step` does."""
        plan, loop = self._opened.plan, self._loop
        try:
            wanted = Fraction(nanoseconds(time, "run_until"))
        except InputError:
            if not isinstance(time, float) or not abs(time) < float("inf"):
                raise
            wanted = Fraction(time) * 10**9
        ticks = (wanted - plan.system.start_time) / Fraction(plan.system.tick)
        tick = round(ticks)
        if abs(ticks - tick) > _NEAR:
            lower = plan.schedule.time(int(ticks // 1))
            near = f"{seconds_text(lower)} s or {seconds_text(lower + plan.system.tick)} s"
            raise InputError(f"run_until: {time} s lies between two ticks; choose {near}")
        if tick < loop.done:
            remedy = "restore a snapshot to go back"
            raise InputError(f"run_until: {time} s is before the present time, {self.time:.9g} s; {remedy}")
        if tick > loop.done or self._why:
            attend(self._interrupt)
            self._to(tick)

    def __iter__(self) -> Iterator[float]:
        """Step to the end, and yield the time [s] after each tick."""
        while not self._at_end:
            self.step()
            yield self.time

    def __getitem__(self, name: str) -> Any:
        """Return the present value of a variable, or of an array of them, recorded or not.

        Raises
        ------
        InputError
            If there is no such variable, or the run is closed.
        RunError
            If the FMU fails to return it, which ends the run.
        """
        if self._why:
            self._refuse_use(f"{name}: cannot be read")
        return self._guarded(self._values.read, name)

    def set(self, name: str, value: Override) -> None:
        """Set free inputs or tunable parameters from the next step on, in the FMU's unit or with one: `"3 deg"`.

        `name` is `component.variable`, an array of them with one value for all or one for each element, or an input of
        the whole system. An input keeps its value until it is set again. Connected inputs, fixed parameters and what
        else has no effect are refused by InputError.
        """
        if self._why:
            self._refuse_use(f"{name}: cannot be set")
        self._guarded(self._values.set, name, value)
        if (count := self._sets.get(name, 0)) < _MOST_SETS:
            self._sets[name] = count + 1
            self._settle()
            self._guarded(_add_set, self._opened.run.events, name, value)

    def __setitem__(self, name: str, value: Override) -> None:
        """Set as `set` does."""
        self.set(name, value)

    def snapshot(self) -> Snapshot:
        """Return the state of the whole run, to go back to or to branch from. Raises InputError if an FMU has none."""
        if self._why:
            self._refuse_use("snapshot: cannot be taken")
        self._settle()
        if self._opened.ended:
            raise InputError(f"snapshot: cannot be taken, as the run has ended: {self.ended}")
        snapshot: Snapshot = self._guarded(take_snapshot, self._opened, self._branch)
        return snapshot

    def restore(self, snapshot: Snapshot) -> None:
        """Go back, or on, to a snapshot of this run or of another run of the same system; rows after it are dropped.

        Raises
        ------
        InputError
            If the snapshot is of another system, or the run is closed.
        RunError
            If an FMU refuses its state, which ends the run.
        """
        if self._why:
            self._refuse_use("restore: is not possible")
        if not isinstance(snapshot, Snapshot):
            raise InputError(f"restore: {snapshot!r} is no snapshot; give what snapshot() returned")
        self._settle()
        check_snapshot(self._opened, snapshot, self._branch)
        self._guarded(restore_snapshot, self._opened, snapshot, self._branch)
        same_run = snapshot.branch[0] == self._branch[0]
        before = snapshot.branch if same_run else ()
        self._branch = (*before, (next(_branches), snapshot.tick))
        self._set_quick()

    def close(self) -> None:
        """Record the last row, close the FMUs and the folder. It may be called twice."""
        if self._why:
            return
        self._settle()
        opened = self._opened
        if not self._at_end:
            opened.run.record["stop_time"] = self.time  # as for a run that was to end here
        try:
            self._summary = opened.complete()
        except BaseException as error:
            self._over(f"failed: {error}")
            raise
        self._over("is closed")

    def __enter__(self) -> Self:
        """Close the run at the end of the block."""
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, _: TracebackType | None) -> None:
        """Close the run; after an exception of the block its folder says so."""
        if error is None or isinstance(error, GeneratorExit):
            self.close()
        elif not self._why:
            self._settle()
            text = f"{type(error).__name__}: {error}" if str(error) else type(error).__name__
            self._opened.run.abandon(error if isinstance(error, KeyboardInterrupt) else RunError(text))
            self._over(f"was ended by {text}")

    def __del__(self) -> None:
        """Free the FMUs of a run that nothing refers to any more."""
        if getattr(self, "_why", "-") == "":
            self._opened.run.abandon(RunError("was not closed"))
            self._over("is closed")

    def __repr__(self) -> str:
        """Describe the run in one line."""
        where = "in memory" if self.folder is None else f"in {self.folder}"
        state = self._why or (f"ended: {self.ended}" if self.ended else "open")
        return f"<Run of {self.system.name}: {self.time:.9g} of {self.stop_time:.9g} s, {where}, {state}>"

    def __reduce__(self) -> NoReturn:
        """Refuse to be copied or pickled."""
        raise TypeError("a run cannot be pickled, as its FMUs are running; pickle its snapshots or signals")

    def _ipython_key_completions_(self) -> list[str]:
        """Return what Tab offers between the brackets: arrays and variables of all components."""
        return self._values.names()

    def _guarded(self, call: Any, *arguments: Any) -> Any:
        """Make a call between two ticks; a failure of a component or the disk ends the run."""
        try:
            return call(*arguments)
        except InputError:
            raise
        except (RunError, OSError) as error:
            self._fail(error)

    def _fail(self, error: BaseException) -> NoReturn:
        """Close the run and raise what ended it."""
        raised = self._opened.run.abandon(error)
        self._over("was interrupted" if isinstance(error, KeyboardInterrupt) else f"failed: {raised}")
        if raised is error:
            raise error
        raise raised from None

    def _over(self, why: str) -> None:
        """Note why nothing can be done any more, and release everything."""
        self._why = why
        self._set_quick()
        dismiss(self._interrupt)
        self._stack.close()

    def _refuse(self, tick: int) -> NoReturn:
        if self._why:
            self._refuse_use("cannot be stepped")
        if self._opened.ended:
            raise InputError(f"a step is not possible, as the run has ended: {self.ended}")
        plan = self._opened.plan
        wanted, stop = (seconds_text(time) for time in (plan.schedule.time(tick), plan.stop_time))
        raise InputError(
            f"a step to {wanted} s would pass the stop time, {stop} s; open the run with a later stop_time"
        )

    def _refuse_use(self, what: str) -> NoReturn:
        raise InputError(f"{what}: the run {self._why}; open another one with lockstep.open")


def _whole(n: object) -> int:
    try:
        ticks = operator.index(n)  # type: ignore[arg-type]
    except TypeError:
        ticks = 0
    if ticks < 1:
        raise InputError(f"step: {n!r} must be a whole number of ticks, 1 or more; run_until goes to a time")
    return ticks


def _add_set(events: Any, name: str, value: Any) -> None:
    events.add("set", name=name, value=value)
