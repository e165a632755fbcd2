"""Run the loop with its results folder open, and leave that readable whatever ends the run."""

from __future__ import annotations

import os
from collections.abc import Callable
from contextlib import ExitStack, suppress
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter

from lockstep.errors import EndOfSimulation, RunError
from lockstep.interrupt import Stopped
from lockstep.results.monitor import Observed
from lockstep.results.recorder import Recorder
from lockstep.results.run_record import Events, end_run_record
from lockstep.run.loop import Loop
from lockstep.run.not_finite import NotFinite
from lockstep.run.real_time_pacing import Pacer


@dataclass(slots=True, kw_only=True)
class RecordedRun:
    """A run whose components are initialised and whose folder has been made."""

    folder: Path
    record: dict[str, object]  # the content of run.toml
    events: Events
    loop: Loop
    pacer: Pacer | None
    close_slaves: ExitStack
    not_finite: NotFinite
    wall_time_before: float = 0.0  # [s] of an earlier part of the same run
    observed: Observed | None = None
    terminated: EndOfSimulation | None = None  # before the stop time, as a component asked for it
    _started: float = 0.0

    @property
    def wall_time(self) -> float:
        """Wall time since the start [s], with that of an earlier part."""
        return perf_counter() - self._started + self.wall_time_before

    def execute(self, open_files: Callable[[], Recorder], run_loop: Callable[[Recorder], None]) -> float:
        """Run to the end and return the wall time of the loop [s]; on a failure close everything, then raise it.

        Raises
        ------
        RunError
            If a component, a value or the disk ends the run.
        """
        self._started = perf_counter()
        recorder: Recorder | None = None
        try:
            try:
                recorder = open_files()
                run_loop(recorder)
                wall_time = perf_counter() - self._started
            except BaseException:
                self.close_slaves.close()
                with suppress(OSError):  # the first failure is the one to report
                    if recorder is not None:
                        recorder.close()
                raise
            self.close_slaves.close()
            recorder.close()
        except KeyboardInterrupt as error:
            self._end("interrupted", error.name if isinstance(error, Stopped) else None)
            raise
        except OSError as error:
            done = f"after {self.loop.time:.9g} s simulated"
            if not error.errno:  # of what was written before, not of the disk
                self._end("failed", f"{error}, {done}")
                raise RunError(f"{error}, {done}") from None
            reason = f"cannot write to {self.folder}: {os.strerror(error.errno)}, {done}"
            self._end("failed", reason)
            raise RunError(f"{reason}; what was written before stays readable") from None
        except BaseException as error:
            self._end("failed", str(error))
            raise
        if self.terminated is None:
            self._end("completed", None)
        else:
            self._end("terminated", str(self.terminated))
        return wall_time

    def _end(self, status: str, reason: str | None) -> None:
        """Write how the run ended; on a full disk as far as possible."""
        ended = {"status": status, "simulated_time": self.loop.time, "wall_time": round(self.wall_time, 3)}
        self.record |= ended | ({} if reason is None else {"reason": reason})
        if self.not_finite.warnings:
            before = self.record.get("warnings")
            self.record["warnings"] = [*(before if isinstance(before, list) else []), *self.not_finite.warnings]
        if self.observed is not None:
            with suppress(OSError):
                self.record["found"] = self.observed.end()
        if self.pacer is not None:
            self.record["pace"] = self.pacer.summary()
            with suppress(OSError):
                self.events.add("pace", **self.pacer.summary())
        with suppress(OSError):
            self.events.add("end", status=status, **({"reason": reason} if reason else {}))
        with suppress(OSError):
            end_run_record(self.folder, self.record)
