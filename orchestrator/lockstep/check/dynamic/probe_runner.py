"""Run a probe in a process of its own, and describe how that process ended."""

from __future__ import annotations

import json
import shutil
import time
from dataclasses import dataclass, field
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from lockstep.check.dynamic.experiment import Experiment
from lockstep.check.dynamic.probe_process import Probe, ProbeResult
from lockstep.fmi.safe_zip import copy_extracted, extract, open_zip
from lockstep.operating_system import can_serve_copies
from lockstep.processes.child_process import ChildProcess, ending, environment_of, printed_lines, signal_name
from lockstep.processes.fork_server import ForkServer
from lockstep.processes.last_call import read_last_call

_PROBE = "lockstep.check.dynamic.probe_process"


@dataclass(slots=True, kw_only=True)
class ProbeRunner:
    """Runs probes of one FMU, each on a new copy of the unpacked files, in the same folder.

    As a context manager it runs them in copies of a process that has imported what they need, where the system can.
    """

    archive: Path
    work: Path
    time_limit: float  # [s] for one process
    _server: ForkServer | None = field(default=None, init=False)
    _extracted: bool = field(default=False, init=False)

    def __post_init__(self) -> None:
        for folder in (self.results, self.elsewhere, self.work / "tmp"):
            folder.mkdir(parents=True, exist_ok=True)

    def __enter__(self) -> Self:
        if can_serve_copies():
            self._server = ForkServer([_PROBE], environment_of(self.work / "tmp"), self.work)
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        if self._server is not None:
            self._server.close()
            self._server = None

    @property
    def unpacked(self) -> Path:
        """The folder of the unpacked FMU."""
        return self.work / "fmu"

    @property
    def results(self) -> Path:
        """The folder in which probes write trajectories and states."""
        return self.work / "results"

    @property
    def elsewhere(self) -> Path:
        """A working directory outside the FMU."""
        return self.work / "elsewhere"

    def unpack(self, folder: Path | None = None) -> Path:
        """Make a folder hold the FMU's files as in the archive, whatever a probe left there, or raise InputError."""
        target, untouched, name = folder or self.unpacked, self.work / "untouched", str(self.archive)
        if not self._extracted:
            shutil.rmtree(untouched, ignore_errors=True)
            with open_zip(self.archive, name) as archive:
                extract(archive, untouched, name)
            self._extracted = True
        shutil.rmtree(target, ignore_errors=True)
        copy_extracted(untouched, target, name)
        return target

    def run(
        self,
        probe: Probe,
        experiment: Experiment,
        *,
        folder: Path | None = None,
        directory: Path | None = None,
        time_limit: float | None = None,
        fresh: bool = False,
        **options: Any,
    ) -> ProbeResult:
        """Run a probe on the FMU in a process of its own.

        `directory` is the working directory; None is the one in which the FMU runs. A `fresh` process is no copy: its
        layout of memory and seed of hashes are its own.
        """
        unpacked = self.unpack(folder)
        usual = unpacked if experiment.directory == "unpacked" else self.elsewhere
        task = {
            "probe": f"{probe.__module__}:{probe.__name__}",
            "folder": str(unpacked),
            "work": str(self.results),
            "options": {"archive": str(self.archive), **options},
            "experiment": experiment.as_json(),
        }
        (self.results / "task.json").write_text(json.dumps(task))
        (self.results / "result.json").unlink(missing_ok=True)
        (self.results / "last_call").unlink(missing_ok=True)
        limit = time_limit or self.time_limit
        began = time.monotonic()
        child = self._start(directory or usual, fresh)
        try:
            code = child.wait(limit, pauses=True)
            left = code is not None and child.left_running
        finally:
            child.kill()
            child.wait()
        result = self._result(code, limit, time.monotonic() - began)
        if left and result.status != "error":
            return ProbeResult(status="error", message="a process that it started continued after the end of its own")
        return result

    def _start(self, directory: Path, fresh: bool) -> ChildProcess:
        """Start the process that carries out the task."""
        task, folders = str(self.results / "task.json"), (self.results / "printed", self.work / "tmp", directory)
        if self._server is not None and not fresh:
            try:
                return self._child([f"{_PROBE}:main", task], *folders, self._server)
            except OSError:  # an FMU has ended the server
                self._server.close()
                self._server = None
        return self._child(["-m", _PROBE, task], *folders)

    def _child(
        self, arguments: list[str], printed: Path, temporary: Path, directory: Path, server: ForkServer | None = None
    ) -> ChildProcess:
        return ChildProcess(arguments, printed=printed, temporary=temporary, directory=directory, server=server)

    def _result(self, code: int | None, limit: float, lasted: float) -> ProbeResult:
        call = read_last_call(self.results / "last_call")
        where = f"in {call}" if call else "between calls"
        try:
            found = json.loads((self.results / "result.json").read_text(encoding="utf-8"))
            result = ProbeResult(**{**found, "details": tuple(found["details"])})
        except (OSError, ValueError, TypeError, KeyError, RecursionError):  # not written, or not by the check
            if code is None:
                return ProbeResult(status="error", hangs=True, message=f"no answer within {limit:g} s {where}")
            if code == 1 and not call:
                return ProbeResult(
                    status="error", message="the check could not be carried out", details=self._printed()
                )
            message = f"{ending(code, 'the')} {where}, after {lasted:.1f} s"
            return ProbeResult(status="error", message=message, details=self._printed())
        if result.status == "error" or code == 0:
            return result
        how = f"did not end within {limit:g} s" if code is None else f"ended with {_code_name(code)}"
        return ProbeResult(
            status="error",
            message=f"all calls returned, but then the process {how}",
            details=self._printed(),
            numbers=result.numbers,
        )

    def _printed(self) -> tuple[str, ...]:
        """Return the last lines that the process printed."""
        return tuple(f"printed: {line}" for line in printed_lines(self.results / "printed", 3))


def _code_name(code: int) -> str:
    return signal_name(code) if code < 0 else f"exit code {code}"
