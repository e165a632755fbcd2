"""Run programs in copies of a process that has imported what they need: imports take seconds, a copy milliseconds.

What a program does to its process, its files, its environment and its folder stays in its copy. A program whose subject
is its start, its memory or its limits is started anew instead.
"""

from __future__ import annotations

import contextlib
import importlib
import json
import os
import runpy
import select
import signal
import subprocess
import sys
import tempfile
import threading
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any


class Copies:
    """A process that waits to be copied.

    Programs are `-m MODULE ...`, `-c TEXT ...`, `SCRIPT.py ...`, or `MODULE:FUNCTION NAME ...`.
    """

    def __init__(self, modules: Sequence[str], environment: Mapping[str, str], *options: str) -> None:
        self._original = subprocess.Popen(
            [sys.executable, *options, __file__, *modules],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            env=dict(environment),
        )

    def run(
        self, program: Sequence[str], *, timeout: float, cwd: Path | None = None
    ) -> subprocess.CompletedProcess[str]:
        """Run a program as `subprocess.run` does, and return its exit code and what it printed."""
        assert self._original.stdin is not None
        assert self._original.stdout is not None
        with tempfile.TemporaryDirectory(prefix="copied_") as folder:
            out, error = Path(folder, "out"), Path(folder, "error")
            request = {"program": list(program), "cwd": str(cwd or Path.cwd()), "out": str(out), "error": str(error)}
            self._original.stdin.write(json.dumps(request) + "\n")
            self._original.stdin.flush()
            copy = int(self._original.stdout.readline())
            late = False
            if not select.select([self._original.stdout], [], [], timeout)[0]:
                late = True
                os.kill(copy, signal.SIGKILL)
            code = int(self._original.stdout.readline())
            printed, errors = out.read_text(encoding="utf-8"), error.read_text(encoding="utf-8")
        if late:
            raise subprocess.TimeoutExpired(list(program), timeout, printed, errors)
        return subprocess.CompletedProcess(list(program), code, printed, errors)

    def close(self) -> None:
        """End the process."""
        self._original.communicate()


def _serve() -> None:
    """Copy this process for each request; answer with the number of the copy, and then with its exit code."""
    requests = sys.stdin
    while line := requests.readline():
        request = json.loads(line)
        copy = os.fork()
        if not copy:
            _become(request)
            return
        print(copy, flush=True)
        _, status = os.waitpid(copy, 0)
        print(os.waitstatus_to_exitcode(status), flush=True)


def _become(request: Mapping[str, Any]) -> None:
    """Run the program of a request in this process, which ends as that does."""
    os.chdir(request["cwd"])
    for number, name in ((1, "out"), (2, "error")):
        descriptor = os.open(request[name], os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o666)
        os.dup2(descriptor, number)
        os.close(descriptor)
    nothing = os.open(os.devnull, os.O_RDONLY)
    os.dup2(nothing, 0)
    os.close(nothing)
    kind, *rest = request["program"]
    if kind == "-c":
        sys.argv, sys.path[0] = ["-c", *rest[1:]], ""
        own = sys.modules["__main__"].__dict__
        exec(compile(rest[0], "<string>", "exec"), own)
    elif kind == "-m":
        sys.argv, sys.path[0] = rest, str(request["cwd"])
        runpy.run_module(rest[0], run_name="__main__", alter_sys=True)
    elif kind.endswith(".py"):
        sys.argv, sys.path[0] = request["program"], str(Path(kind).parent)
        runpy.run_path(kind, run_name="__main__")
    else:
        module, _, function = kind.partition(":")
        sys.argv, sys.path[0] = rest, str(Path(rest[0]).parent)
        sys.exit(getattr(importlib.import_module(module), function)())


if __name__ == "__main__":
    for name in sys.argv[1:]:
        importlib.import_module(name)
    assert threading.active_count() == 1, "a process with threads cannot be copied"
    with contextlib.suppress(KeyboardInterrupt):
        _serve()
