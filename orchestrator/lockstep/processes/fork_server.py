"""Start children as copies of a process that has imported what they need: imports take .2 s, a copy milliseconds.

Copies share the layout of their memory and the seed of Python's hashes. What is to differ between two processes, or
measures its own process, needs a new one.
"""

from __future__ import annotations

import json
import os
import select
import socket
import subprocess
import sys
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path

from lockstep.operating_system import KILLED, kill
from lockstep.processes.fork_server_process import LARGEST


class CopiedProcess:
    """A copy of the server's process; a part of what `subprocess.Popen` is."""

    def __init__(self, channel: socket.socket) -> None:
        self._channel = channel
        self.pid = int(channel.recv(LARGEST) or b"-1")
        self._code: int | None = None
        if self.pid < 0:
            raise ConnectionError("the process that is to be copied has ended")

    def poll(self) -> int | None:
        """Return the exit code, negative for a signal; None while the process runs."""
        if self._code is None and select.select([self._channel], [], [], 0.0)[0]:
            self._end()
        return self._code

    def wait(self, timeout: float | None = None) -> int:
        """Return the exit code; raise subprocess.TimeoutExpired after so many seconds."""
        if self._code is None:
            if not select.select([self._channel], [], [], timeout)[0]:
                raise subprocess.TimeoutExpired("copy", timeout or 0.0)
            self._end()
        assert self._code is not None
        return self._code

    def _end(self) -> None:
        answer = self._channel.recv(LARGEST)
        self._code = int(answer) if answer else KILLED  # the server was killed, and its copy with it
        with suppress(OSError):
            self._channel.send(b".")  # from here on another process may get its number

    def send_signal(self, number: int) -> None:
        """Send a signal if the process still runs."""
        if self.poll() is None:
            os.kill(self.pid, number)

    def kill(self) -> None:
        """Kill the process if it still runs."""
        if self.poll() is None:
            kill(self.pid)


class ForkServer:
    """A process that has imported some modules. It runs one copy at a time."""

    def __init__(self, modules: Sequence[str], environment: Mapping[str, str], directory: Path) -> None:
        self._channel, there = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        with there:
            self._process = subprocess.Popen(
                [sys.executable, "-P", "-m", "lockstep.processes.fork_server_process", str(there.fileno()), *modules],
                cwd=directory,
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
                pass_fds=[there.fileno()],
                start_new_session=True,
                env=dict(environment),
            )

    def start(
        self, function: str, arguments: Sequence[str], *, directory: Path, printed: int, report: int
    ) -> CopiedProcess:
        """Run `module:function` in a copy with a guard; raise OSError where the server has ended.

        printed, report : descriptors for what it prints, and for the reports of the guard
        """
        request = {"function": function, "arguments": list(arguments), "directory": str(directory)}
        socket.send_fds(self._channel, [json.dumps(request).encode()], [printed, report])
        return CopiedProcess(self._channel)

    def close(self) -> None:
        """End the process."""
        self._channel.close()
        self._process.kill()
        self._process.wait()
