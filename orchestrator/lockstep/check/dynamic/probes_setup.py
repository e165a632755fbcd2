"""Probe of start values: whether what a host sets before fmi2SetupExperiment is there after it."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from lockstep.check.dynamic.experiment import Port
from lockstep.check.dynamic.probe_process import ProbeResult, ProbeTask
from lockstep.errors import RunError, compact

Values = dict[str, float]  # by variable


def start_values(task: ProbeTask) -> ProbeResult:
    """Set parameters and inputs before and after fmi2SetupExperiment, and read them back when initialization begins."""
    experiment = task.experiment
    if experiment.fmi != "2.0":
        message = f"FMI {experiment.fmi} has no call before which a value could be lost"
        return ProbeResult(status="skipped", message=message)
    changed = [(port, value) for port in (*experiment.parameters, *experiment.inputs)
               if port.kind != "String" and (value := _another(port)) != port.start]  # fmt: skip
    if not changed:
        return ProbeResult(status="skipped", message="nothing can be set to another value than its start value")
    reals = [(port, value) for port, value in changed if port.kind == "Real"]
    inputs = [(port, value) for port, value in changed if port in experiment.inputs]
    refused = ""
    for chosen in (changed, reals, inputs):  # an FMU may refuse what it has not designed for
        try:
            found = _read(task, chosen, early=False)
        except RunError as error:
            refused = refused or str(error)
            continue
        if chosen:
            return _compared(task, chosen, found)
    return ProbeResult(status="skipped", message=f"other start values are refused: {refused}")


def _compared(task: ProbeTask, chosen: Sequence[tuple[Port, float]], expected: Values) -> ProbeResult:
    """Set the same before fmi2SetupExperiment, and compare."""
    # an FMU may round values or limit them: what is nearer to the start value than to the other one is lost
    never = [p.name for p, value in chosen if abs(expected[p.name] - p.start) < abs(expected[p.name] - value)]
    if never:
        message = f"loses start values even if they are set after fmi2SetupExperiment: {compact(never)}"
        return ProbeResult(status="warning", message=message)
    try:
        early = _read(task, chosen, early=True)
    except RunError as error:
        message = f"refuses before fmi2SetupExperiment what it takes after it: {error}"
        return ProbeResult(status="warning", message=message)
    lost = [port.name for port, _ in chosen if early[port.name] != expected[port.name]]
    if lost:
        first = f"{lost[0]} is {early[lost[0]]:.9g} instead of {expected[lost[0]]:.9g}"
        message = f"loses what is set before fmi2SetupExperiment: {compact(lost)}; {first}"
        return ProbeResult(status="warning", message=message)
    return ProbeResult(message=f"{len(chosen)} variables are kept, set before fmi2SetupExperiment or after it")


def _read(task: ProbeTask, chosen: Iterable[tuple[Port, float]], *, early: bool) -> Values:
    """Initialise a new instance with these values, and return what they are then."""
    instance = task.open()
    if early:
        instance.set_values(chosen)
    instance.set_up()
    if not early:
        instance.set_values(chosen)
    instance.demand("EnterInitializationMode")
    found = instance.values([port for port, _ in chosen])
    instance.close()
    return found


def _another(port: Port) -> float:
    """Return a value near the start value, within the range; the start value itself if there is none."""
    if port.kind == "Boolean":
        return 1.0 - port.start
    for value in (port.start + port.nudge, port.start - port.nudge):
        if port.minimum <= value <= port.maximum:
            return value
    return port.start
