"""Check FMUs of FMI 1.0 and 3.0: FMPy's validation, and a few steps in a process of their own.

The detailed checks of the rules of FMI 2.0 are for that version only, which the report states.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from pathlib import Path

from lockstep.check.report.finding import Finding, Group, Status
from lockstep.check.static.archive_checks import archive, documentation, hygiene, licence
from lockstep.check.static.fmu_archive import FmuArchive
from lockstep.errors import InputError, RunError
from lockstep.fmi.model_description import PLATFORMS, Description, read_description, validation_problems
from lockstep.fmi.parameter_values import parse_value
from lockstep.fmi.safe_zip import TemporaryFolderError
from lockstep.simulation import simulate
from lockstep.system.clock import positive_nanoseconds, seconds_text
from lockstep.system.component import Component
from lockstep.system.system import System

_STEPS, _STEP = 20, 10_000_000  # [ns], for an FMU that recommends none
_ONLY_2 = "units, structure, names, capabilities, state, repetition and the ports of a contract"

Report = Callable[[Finding], None]


def version_of(fmu: FmuArchive) -> str:
    """Return the version of FMI, if it is one of those that are checked here; else nothing."""
    version = "" if fmu.model is None else fmu.model.attributes.get("fmiVersion", "")[:3]
    return version if version in PLATFORMS and version != "2.0" else ""


def other_version_checks(fmu: FmuArchive, dynamic: bool, report: Report) -> list[Finding]:
    """Check an FMU of FMI 1.0 or 3.0; `report` is called with each finding as it comes."""
    version, found = version_of(fmu), []

    def note(name: str, title: str, status: Status, message: str, details: tuple[str, ...] = ()) -> None:
        group: Group = "dynamic" if name.startswith("dynamic") else "static"
        add(Finding(check=name, group=group, title=title, status=status, message=message, details=details))

    def add(finding: Finding) -> None:
        found.append(finding)
        report(finding)

    for check in (archive, hygiene):
        add(check(fmu))
    component = Component(name="checked", source=fmu.path.absolute(), period=1, isolated=True)
    kind = f"an FMI {version} co-simulation FMU that the master supports"
    description: Description | None = None
    try:
        description = read_description(component)
    except InputError as error:
        note("static.kind", kind, "error", str(error).removeprefix("checked: "))
    if description is not None:
        note("static.kind", kind, "pass", f"{description.model}, {len(description.variables)} scalars")
        problems = [" ".join(problem.split()) for problem in validation_problems(fmu.path)]
        message = problems[0] if problems else "no objection"
        fmpy = "FMPy's validate_fmu, schema included, has no objection"
        note("static.fmpy", fmpy, "error" if problems else "pass", message, tuple(problems[1:]))
        if dynamic:
            note("dynamic.run", "it instantiates, initialises, steps and terminates", *_run(component, description))
    for check in (documentation, licence):
        add(check(fmu))
    message = f"{_ONLY_2} are checked for FMI 2.0 only; this is FMI {version}. For delays use probe-latency"
    note("static.scope", "scope of the checks", "info", message)
    return found


def _run(component: Component, description: Description) -> tuple[Status, str]:
    """Step an FMU at its start values; return status and message."""
    try:
        step = positive_nanoseconds(description.step_size, "step size") if description.step_size else _STEP
        given = {
            v.name: parse_value(v.start, v, v.name)
            for v in description.variables.values()
            if v.causality == "input" and v.scalar is not None and v.start is not None
        }
        part = Component(name="checked", source=component.source, period=step, isolated=True, parameters=given)
        system = System(name="check", tick=step, components=(part,), stop_time=_STEPS * step)
        with tempfile.TemporaryDirectory() as folder:
            simulate(system, Path(folder, "run"))
    except TemporaryFolderError:
        raise
    except (InputError, RunError) as error:
        return "error", str(error).removeprefix("checked: ")
    return "pass", f"{_STEPS} steps of {seconds_text(step)} s in a process of its own, every output finite"
