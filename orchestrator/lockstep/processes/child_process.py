"""Run a child process in a session of its own, end it with everything it started, and describe how it ended."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Mapping, Sequence
from contextlib import suppress
from functools import cached_property
from pathlib import Path
from threading import Lock

import psutil

from lockstep.operating_system import has_fork, session_of
from lockstep.processes.fork_server import CopiedProcess, ForkServer
from lockstep.processes.guard import END
from lockstep.processes.running_time import RunningTime

_ONE_THREAD = dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"), "1")
_LISTS = ("PYTHONPATH", "LD_LIBRARY_PATH", "PATH")  # of folders
_TAIL = 4000  # bytes of what a process printed, in which its last lines are looked for
_LONGEST_LINE = 200  # letters
_GUARD = "lockstep.processes.guard"
_PATIENCE = 10.0  # [s] for a guard that is to end
_STOPPED = (psutil.STATUS_STOPPED, psutil.STATUS_TRACING_STOP)


class ChildProcess:
    """A Python process whose output goes to a file, and its guard, which ends what the process started.

    Where the system cannot copy processes there is no guard. The temporary folder marks the processes that it starts.
    """

    def __init__(
        self,
        arguments: Sequence[str],
        *,
        printed: Path,
        temporary: Path,
        directory: Path | None = None,
        descriptors: Sequence[int] = (),
        server: ForkServer | None = None,
    ) -> None:
        """Start Python with arguments; `descriptors` are those that it inherits.

        With a server, which has to have the same temporary folder, the arguments are `module:function` and its own, and
        the process is a copy of the server's.
        """
        temporary.mkdir(parents=True, exist_ok=True)
        self.printed = printed
        self._marks = {"TMPDIR": str(temporary)}
        self._pid = 0
        self._left = -1  # processes that were left running; -1: not known
        self._lock = Lock()
        printed.unlink(missing_ok=True)
        report, reports = os.pipe()
        self._report = os.fdopen(report)
        guard = ["-m", _GUARD, str(reports)] if has_fork() else []
        self._process: subprocess.Popen[bytes] | CopiedProcess
        try:
            with printed.open("ab") as stream:  # for appending: whoever cuts the file off does not leave a hole in it
                if server is not None:
                    function, *own = arguments
                    folder = Path.cwd() if directory is None else directory
                    self._process = server.start(
                        function, own, directory=folder, printed=stream.fileno(), report=reports
                    )
                    return
                self._process = subprocess.Popen(
                    [sys.executable, "-P", *guard, *arguments],
                    cwd=directory,
                    stdin=subprocess.DEVNULL,
                    stdout=stream,
                    stderr=subprocess.STDOUT,
                    pass_fds=(*descriptors, *([reports] if guard else [])),
                    start_new_session=True,
                    env=environment_of(temporary),
                )
        except BaseException:
            self._report.close()
            raise
        finally:
            os.close(reports)

    @property
    def guard(self) -> int:
        """The number of the process that guards this one, or its own."""
        return self._process.pid

    @property
    def pid(self) -> int:
        """The number of the process; waits until it is there."""
        with self._lock:
            if not self._pid:
                line = self._report.readline()
                self._pid = int(line) if line else self._process.pid
            return self._pid

    @cached_property
    def process(self) -> psutil.Process:
        """The process, to ask for its state; raises psutil.Error where it has ended."""
        return psutil.Process(self.pid)

    @property
    def code(self) -> int | None:
        """The exit code, negative for a signal; None while the process runs."""
        code = self._process.poll()
        if code is not None and not self._report.closed:
            pid = self.pid
            with self._lock:
                if not self._report.closed:
                    text = self._report.read()
                    self._report.close()
                    self._left = int(text) if text and pid != self._process.pid else -1
        return code

    @property
    def stopped(self) -> bool:
        """Whether the process was stopped by a signal or a debugger, and may go on."""
        with suppress(psutil.Error):
            return self.process.status() in _STOPPED
        return False

    @property
    def left_running(self) -> bool:
        """Whether it ended before processes that it had started."""
        if self.code is not None and self._left >= 0:
            return self._left > 0
        return bool(self.others())

    def wait(self, limit: float | None = None, *, pauses: bool = False) -> int | None:
        """Wait for the end, so many seconds at most; return the exit code, or None if the process still runs.

        Time does not count in which this process is stopped, nor that of the other one's `pauses`.
        """
        if limit is None:
            self._process.wait()
            return self.code
        time = RunningTime(limit)
        while not time.is_over:
            with suppress(subprocess.TimeoutExpired):
                self._process.wait(time.next_look)
                break
            time.look(counts=not (pauses and self.stopped))
        return self.code

    def others(self) -> list[psutil.Process]:
        """Return the processes that it started, directly or not, and that still run."""
        own = (self.pid, self._process.pid)
        return [process for process in running(self._process.pid, self._marks) if process.pid not in own]

    def kill(self) -> None:
        """End the process and those that it started."""
        if self.code is None:  # until then its number cannot belong to another process
            if self.pid != self._process.pid:
                self._process.send_signal(END)  # the guard ends the others
                with suppress(subprocess.TimeoutExpired):
                    self._process.wait(_PATIENCE)
            if self.code is None:
                self._process.kill()
        if self.code is None or self._left < 0:
            for process in self.others():
                with suppress(psutil.Error):
                    process.kill()


def environment_of(temporary: Path) -> dict[str, str]:
    """Return the environment of a child process with this folder for temporary files."""
    return _ONE_THREAD | dict(os.environ) | absolute_paths() | {"TMPDIR": str(temporary)}


def absolute_paths() -> dict[str, str]:
    """Return the lists of folders in the environment with absolute paths: a child has another working directory."""
    lists = {name: os.environ[name] for name in _LISTS if os.environ.get(name)}
    return {name: os.pathsep.join(map(os.path.abspath, text.split(os.pathsep))) for name, text in lists.items()}


def printed_lines(path: Path, count: int) -> list[str]:
    """Return the last lines that a process printed, empty ones aside, each cut to 200 letters."""
    with suppress(OSError), path.open("rb") as stream:
        stream.seek(max(0, path.stat().st_size - _TAIL))
        lines = stream.read().decode("utf-8", "replace").splitlines()
        return [line.strip()[:_LONGEST_LINE] for line in lines if line.strip()][-count:]
    return []


def running(session: int, environment: Mapping[str, str]) -> list[psutil.Process]:
    """Return the processes of a session, and those that left it but still carry its environment; zombies aside."""
    found = []
    for process in psutil.process_iter():
        with suppress(psutil.Error, OSError):  # it has ended, or belongs to another user
            belongs = session_of(process.pid) == session or environment.items() <= process.environ().items()
            if belongs and process.status() != psutil.STATUS_ZOMBIE:
                found.append(process)
    return found


def signal_name(code: int) -> str:
    """Return the name of the signal that ended a process with this exit code < 0."""
    with suppress(ValueError):
        return signal.Signals(-code).name
    return f"signal {-code}"


def ending(code: int, whose: str = "its") -> str:
    """Describe an exit code: `crashed with SIGSEGV`, `ended its process with exit code 3`."""
    return f"crashed with {signal_name(code)}" if code < 0 else f"ended {whose} process with exit code {code}"
