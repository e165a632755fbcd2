"""One worker's process: started, watched for time and memory, and ended with all that it started."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from threading import Event, Thread
from time import monotonic

from lockstep.interrupt import Interrupt
from lockstep.processes.cpu_affinity import same_layout
from lockstep.processes.process_tree import running, signal_name

GIGABYTE = 2**30
_LOOK = 0.05  # [s] between two looks at time and memory
_PAGE = os.sysconf("SC_PAGE_SIZE")
_MOST_PRINTED = 2**20  # bytes of what the FMU prints; then it is thrown away
_GRACE = 5.0  # [s] for a process that is ending
_PATIENCE = 1.0  # [s] from Ctrl-C on for a call under way


@dataclass(frozen=True, slots=True, kw_only=True)
class Limits:
    """What one isolated FMU may take."""

    step: float = 60.0  # [s] of wall time for one call
    memory: int = min(8 * GIGABYTE, _PAGE * os.sysconf("SC_PHYS_PAGES") // 2)  # bytes: above the needs of an FMU
    reserved: int = 4  # times as much may be asked for without being used
    interrupt: Interrupt = field(default_factory=Interrupt)  # Ctrl-C, which ends a call that lasts


class Process:
    """A process in a session of its own. `busy_since` is when the call under way began, 0 if none is."""

    def __init__(self, descriptors: tuple[int, ...], folder: Path, limits: Limits) -> None:
        self.busy_since = 0.0
        self.limit = limits.step  # [s] for one call
        self.cause = ""  # why it was ended, if it was
        self.interrupt = limits.interrupt
        self.interrupted = False  # whether it was ended for that
        self._limits = limits
        (folder / "tmp").mkdir(parents=True)
        self._marks = {"TMPDIR": str(folder / "tmp")}
        self._printed = folder / "printed"
        threads = dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"), "1")
        with self._printed.open("ab") as printed, same_layout():
            self._process = subprocess.Popen(
                [sys.executable, "-P", "-m", "lockstep.processes.worker", *map(str, descriptors)],
                stdin=subprocess.DEVNULL,
                stdout=printed,
                stderr=subprocess.STDOUT,
                pass_fds=descriptors,
                start_new_session=True,
                env=threads | dict(os.environ) | self._marks,
            )
        self.pid = self._process.pid
        self._ended = Event()
        self._watch = Thread(target=self._look, name=f"watch {self.pid}", daemon=True)
        self._watch.start()

    def _look(self) -> None:
        limits, memory = self._limits, f"/proc/{self.pid}/statm"
        asked = 0.0  # when Ctrl-C was seen
        while not self._ended.wait(_LOOK):
            since = self.busy_since
            if self._process.poll() is not None:
                self._kill()  # whatever it started and that keeps the pipes open
                return
            if since and monotonic() - since > self.limit:
                self._end_for(f"no answer within {self.limit:g} s")
            if self.interrupt.requested:
                asked = asked or monotonic()
                if since and monotonic() - max(since, asked) > _PATIENCE:
                    self.interrupted = True
                    self._end_for("interrupted")
            with suppress(OSError, ValueError):
                sizes = Path(memory).read_text().split()
                used, reserved = int(sizes[1]) * _PAGE, int(sizes[5]) * _PAGE
                if used > limits.memory or reserved > limits.reserved * limits.memory:
                    self._end_for(f"took more than {limits.memory / GIGABYTE:.3g} GB of memory")
                if self._printed.stat().st_size > _MOST_PRINTED:
                    os.truncate(self._printed, 0)

    def _end_for(self, cause: str) -> None:
        self.cause = self.cause or cause
        self._kill()

    def _kill(self) -> None:
        for pid in (*running(self.pid, self._marks), *([] if self._gone() else [self.pid])):
            with suppress(ProcessLookupError, PermissionError):
                os.kill(pid, signal.SIGKILL)

    def _gone(self) -> bool:
        return self._process.poll() is not None

    def end(self, grace: float = _GRACE) -> None:
        """Wait for its end, or make one, and end what it started."""
        with suppress(subprocess.TimeoutExpired):
            self._process.wait(grace)
        self._ended.set()
        self._kill()
        self._process.wait()
        self._watch.join()

    def how_it_ended(self) -> str:
        """Return in words why a process that answers no more does so, and the last line that it printed."""
        with suppress(subprocess.TimeoutExpired):
            self._process.wait(_GRACE)
        code = self._process.poll()
        if self.cause:
            return self.cause
        if code is None:
            return "closed its connection to the master"
        how = f"crashed with {signal_name(code)}" if code < 0 else f"ended its process with exit code {code}"
        line = self._last_line()
        return f"{how} ({line})" if line else how

    def _last_line(self) -> str:
        with suppress(OSError), self._printed.open("rb") as stream:
            stream.seek(max(0, self._printed.stat().st_size - 2000))
            lines = stream.read().decode("utf-8", "replace").splitlines()
            return next((line.strip()[:200] for line in reversed(lines) if line.strip()), "")
        return ""
