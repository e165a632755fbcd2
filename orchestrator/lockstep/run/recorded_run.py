"""Keep the record of a run, and leave it readable whatever ends the run."""

from __future__ import annotations

import os
from collections.abc import Sequence
from contextlib import ExitStack, suppress
from dataclasses import dataclass, field
from pathlib import Path
from time import perf_counter

from lockstep.errors import EndOfSimulation, RunError
from lockstep.interrupt import Stopped
from lockstep.plan.schedule import Task
from lockstep.results.monitor import Observed
from lockstep.results.recorder import Recorder
from lockstep.results.run_record import Events, end_run_record
from lockstep.run.loop import Loop
from lockstep.run.loop_time import LoopTime, loop_time
from lockstep.run.not_finite import NotFinite
from lockstep.run.real_time_pacing import Pacer


@dataclass(slots=True, kw_only=True)
class RecordedRun:
    """A run whose components are initialised, and whose folder has been made if it has one."""

    folder: Path | None
    record: dict[str, object]  # the content of run.toml
    events: Events
    loop: Loop
    pacer: Pacer | None
    close_slaves: ExitStack
    not_finite: NotFinite
    wall_time_before: float = 0.0  # [s] of an earlier part of the same run
    observed: Observed | None = None
    recorder: Recorder | None = None  # once its files are open
    terminated: EndOfSimulation | None = None  # before the stop time, as a component asked for it
    warnings: list[str] = field(default_factory=list)  # of the run itself, not of its system
    tasks: Sequence[Task] = ()  # of the loop
    size: int = 0  # bytes of the recorded signals on disk, at the end
    _started: float = 0.0

    @property
    def wall_time(self) -> float:
        """Wall time since the start [s], with that of an earlier part."""
        return perf_counter() - self._started + self.wall_time_before

    @property
    def loop_time(self) -> LoopTime:
        """Where the wall time of the loop goes."""
        return loop_time(self.loop, self.tasks)

    def start_clock(self) -> None:
        """Start the wall clock of the run."""
        self._started = perf_counter()

    def complete(self) -> None:
        """Close the components and the files, and record the regular end.

        Raises
        ------
        RunError
            If the disk ends the run.
        """
        try:
            self.close_slaves.close()
            self._close_recorder()
        except BaseException as error:
            raise self._ended_by(error) from None
        if self.terminated is None:
            self._end("completed", None)
        else:
            self._end("terminated", str(self.terminated))

    def abandon(self, error: BaseException) -> BaseException:
        """Close everything after a failure, record it, and return what to raise: a RunError for one of the disk."""
        self.close_slaves.close()
        with suppress(OSError):  # the first failure is the one to report
            self._close_recorder()
        return self._ended_by(error)

    def _ended_by(self, error: BaseException) -> BaseException:
        if isinstance(error, KeyboardInterrupt):
            self._end("interrupted", error.name if isinstance(error, Stopped) else None)
            return error
        if not isinstance(error, OSError):
            self._end("failed", str(error))
            return error
        done = f"after {self.loop.time:.9g} s simulated"
        if not error.errno:  # of what was written before, not of the disk
            self._end("failed", f"{error}, {done}")
            return RunError(f"{error}, {done}")
        reason = f"cannot write to {self.folder}: {os.strerror(error.errno)}, {done}"
        self._end("failed", reason)
        return RunError(f"{reason}; what was written before stays readable")

    def _close_recorder(self) -> None:
        """Close the recorder, and note in the record what is on disk."""
        recorder = self.recorder
        if recorder is None:
            return
        try:
            recorder.close()
        finally:
            self.size = recorder.size_on_disk()
            recorded = {"signals": len(recorder.schema) - 1, "rows": recorder.written, "size": self.size}
            self.record["recorded"] = recorded

    def _end(self, status: str, reason: str | None) -> None:
        """Write how the run ended; on a full disk as far as possible."""
        ended = {"status": status, "simulated_time": self.loop.time, "wall_time": round(self.wall_time, 3)}
        ended["threads"] = self.loop.threads  # that stepped components; 1: all in turn
        self.record |= ended | ({} if reason is None else {"reason": reason})
        self.record["time"] = self.loop_time.record()
        if warnings := [*self.warnings, *self.not_finite.warnings]:
            before = self.record.get("warnings")
            self.record["warnings"] = [*(before if isinstance(before, list) else []), *warnings]
        if self.observed is not None:
            with suppress(OSError):
                self.record["found"] = self.observed.end()
        if self.pacer is not None:
            self.record["pace"] = self.pacer.summary()
            with suppress(OSError):
                self.events.add("pace", **self.pacer.summary())
        with suppress(OSError):
            self.events.add("end", status=status, **({"reason": reason} if reason else {}))
        if self.folder is not None:
            with suppress(OSError):
                end_run_record(self.folder, self.record)
