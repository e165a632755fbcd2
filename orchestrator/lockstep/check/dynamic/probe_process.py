"""Run one dynamic check in this process: `python -m` with the path of a task in JSON; writes its result in JSON.

An FMU may crash here, end the process, hang or take too much memory: the parent (`probe_runner`) makes that a finding.
"""

from __future__ import annotations

import json
import os
import sys
import traceback
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any

from lockstep.check.dynamic.checked_instance import NAME, CheckedInstance
from lockstep.check.dynamic.experiment import Experiment
from lockstep.check.report.finding import Status
from lockstep.errors import EndOfSimulation, RunError
from lockstep.fmi.model_description import Variable, read_description
from lockstep.fmi.slave import FATAL
from lockstep.operating_system import end_with_parent, limit_process, physical_memory
from lockstep.processes.last_call import LastCall, last_call_in
from lockstep.system.component import Component

GIGABYTE = 2**30
MEMORY_LIMIT = 8 * GIGABYTE  # data of a check, and at most half of the machine's memory: above the needs of an FMU
FILE_LIMIT = GIGABYTE


@dataclass(frozen=True, slots=True, kw_only=True)
class ProbeResult:
    """What a check found, without its name."""

    status: Status = "pass"
    message: str = ""
    details: tuple[str, ...] = ()
    numbers: Mapping[str, float] = field(default_factory=dict)
    hangs: bool = False  # there was no answer within the time limit


@dataclass(frozen=True, slots=True, kw_only=True)
class ProbeTask:
    """What a probe works with."""

    experiment: Experiment
    folder: Path  # the unpacked FMU
    work: Path  # for files that the parent reads
    options: Mapping[str, Any]
    last_call: LastCall
    instances: list[CheckedInstance] = field(default_factory=list)

    def open(self, name: str = NAME, folder: Path | None = None, other: Experiment | None = None) -> CheckedInstance:
        """Instantiate the FMU, or another one."""
        form = self.options.get("location", "encoded")
        experiment, archive = (self.experiment, "archive") if other is None else (other, "neighbour_archive")
        variables = _declared(Path(self.options[archive])) if experiment.fmi == "3.0" else ()
        unpacked = folder or self.folder
        made = CheckedInstance(experiment, unpacked, self.last_call, name, form, variables)
        self.instances.append(made)
        return made

    def started(self, name: str = NAME) -> CheckedInstance:
        """Instantiate and initialise the FMU."""
        made = self.open(name)
        made.initialise()
        return made


@cache
def _declared(archive: Path) -> tuple[Variable, ...]:
    """Return the variables of an FMU file."""
    return tuple(read_description(Component(name=NAME, source=archive, period=1)).variables.values())


Probe = Callable[[ProbeTask], ProbeResult]


def main(arguments: list[str]) -> int:
    """Run one check and write what it found."""
    _limit()
    task_file = json.loads(Path(arguments[0]).read_text(encoding="utf-8"))
    work = Path(task_file["work"])
    task = ProbeTask(
        experiment=Experiment.from_json(task_file["experiment"]),
        folder=Path(task_file["folder"]),
        work=work,
        options=task_file["options"],
        last_call=last_call_in(work / "last_call"),
    )
    module, _, name = task_file["probe"].partition(":")
    probe: Probe = getattr(import_module(module), name)
    try:
        result = probe(task)
        for instance in task.instances:
            instance.close()
    except EndOfSimulation as error:  # a regular end, before the check could see what it is about
        result = ProbeResult(status="skipped", message=str(error).removeprefix(f"{NAME}: "))
    except RunError as error:
        result = ProbeResult(status="error", message=str(error).removeprefix(f"{NAME}: "))
    except Exception as error:  # of the check itself: reported as such; the other checks follow
        lines = traceback.format_exc().splitlines()
        reason = f"the check could not be carried out: {type(error).__name__}: {error}"
        result = ProbeResult(status="error", message=reason, details=tuple(lines[-6:]))
    fatal = any(instance.worst >= FATAL for instance in task.instances)
    if result.status == "error" and not fatal:
        try:
            for instance in task.instances:
                instance.close()
        except RunError:
            pass  # the first failure is what is reported
    (work / "result.json").write_text(json.dumps(asdict(result)), encoding="utf-8")
    sys.stdout.flush()
    if fatal:
        os._exit(0)  # nothing of the library may run any more, not even what it does at exit
    return 0


def _limit() -> None:
    """Limit what an FMU can do to the machine, and end with the parent."""
    limit_process(core=0, data=min(MEMORY_LIMIT, physical_memory() // 2), file_size=FILE_LIMIT)
    end_with_parent()


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
