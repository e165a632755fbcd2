"""Run a child process in a session of its own, end it with everything it started, and describe how it ended."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path

import psutil

from lockstep.operating_system import session_of

_ONE_THREAD = dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"), "1")
_LISTS = ("PYTHONPATH", "LD_LIBRARY_PATH", "PATH")  # of folders
_TAIL = 4000  # bytes of what a process printed, in which its last lines are looked for
_LONGEST_LINE = 200  # letters


class ChildProcess:
    """A Python process whose output goes to a file. Its temporary folder marks the processes that it starts."""

    def __init__(
        self,
        arguments: Sequence[str],
        *,
        printed: Path,
        temporary: Path,
        directory: Path | None = None,
        descriptors: Sequence[int] = (),
    ) -> None:
        temporary.mkdir(parents=True, exist_ok=True)
        self.printed = printed
        self._marks = {"TMPDIR": str(temporary)}
        printed.unlink(missing_ok=True)
        with printed.open("ab") as stream:  # for appending: whoever cuts the file off does not leave a hole in it
            self._process = subprocess.Popen(
                [sys.executable, "-P", *arguments],
                cwd=directory,
                stdin=subprocess.DEVNULL,
                stdout=stream,
                stderr=subprocess.STDOUT,
                pass_fds=descriptors,
                start_new_session=True,
                env=_ONE_THREAD | dict(os.environ) | absolute_paths() | self._marks,
            )
        self.pid = self._process.pid

    @property
    def code(self) -> int | None:
        """The exit code, negative for a signal; None while the process runs."""
        return self._process.poll()

    def wait(self, limit: float | None = None) -> int | None:
        """Wait for the end, so many seconds at most; return the exit code, or None if the process still runs."""
        with suppress(subprocess.TimeoutExpired):
            self._process.wait(limit)
        return self.code

    def others(self) -> list[psutil.Process]:
        """Return the processes that it started, directly or not, and that still run."""
        return [process for process in running(self.pid, self._marks) if process.pid != self.pid]

    def kill(self) -> None:
        """Kill the process and those that it started."""
        if self.code is None:  # until then its number cannot belong to another process
            self._process.kill()
        for process in self.others():
            with suppress(psutil.Error):
                process.kill()


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
