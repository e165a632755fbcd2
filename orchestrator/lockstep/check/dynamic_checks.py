"""The dynamic checks of an FMU, in their order: each in a process of its own, each with a finding.

A check that cannot work (no step can be made, no two runs agree) is skipped with the reason, so that one defect
is reported once.
"""

from __future__ import annotations

import re
import time
from collections.abc import Callable, Collection, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from lockstep.check.dynamic import probes_life, probes_load, probes_refusal, probes_setup, probes_state
from lockstep.check.dynamic.experiment import Experiment, experiment_of
from lockstep.check.dynamic.probe_process import Probe, ProbeResult
from lockstep.check.dynamic.probe_runner import ProbeRunner
from lockstep.check.dynamic.trajectory import Trajectory, difference, relative_difference
from lockstep.check.dynamic.working_directory_checks import resource_location, working_directory
from lockstep.check.latency import latency_check
from lockstep.check.report.finding import Finding
from lockstep.errors import InputError
from lockstep.fmi.safe_zip import TemporaryFolderError
from lockstep.fmi.temporary_folder import temporary_folder

Listener = Callable[[Finding], None]

TITLES = {
    "dynamic.instantiate": "loads and can be instantiated",
    "dynamic.initialise": "initialises with finite outputs",
    "dynamic.step": "makes steps with finite outputs",
    "dynamic.start_values": "keeps start values that are set before the experiment is set up",
    "dynamic.repeat": "a new process gives the same bits",
    "dynamic.reset": "runs again after a reset",
    "dynamic.second_instance": "two instances in one process",
    "dynamic.second_load": "unloaded and loaded again in one process",
    "dynamic.side_by_side": "two FMUs in one process",
    "dynamic.state": "state set back, and restored in another process",
    "dynamic.awkward_times": "times with rounding errors",
    "dynamic.working_directory": "independent of the working directory",
    "dynamic.resource_location": "runs from any path, in every form of its URI",
    "dynamic.refuses_step": "refuses a step that it cannot make",
    "dynamic.logging": "logs an error through the host's logger",
    "dynamic.invalid_reference": "survives a bad value reference",
    "dynamic.latency": "latency of each output, against the declared dependencies",
    "dynamic.cost": "cost of a step",
    "dynamic.memory": "memory over many steps",
}
CHECKS = tuple(TITLES)
COMPARING = {"dynamic.reset", "dynamic.second_instance", "dynamic.second_load", "dynamic.side_by_side",
             "dynamic.state", "dynamic.awkward_times", "dynamic.working_directory", "dynamic.resource_location",
             "dynamic.latency"}  # fmt: skip

REFERENCE_STEPS = 200
REFERENCE_SECONDS = 5.0  # wall time of the reference run; slow FMUs make fewer steps
SEED_AGE = 1.1  # [s] between two runs, so that seeds from a clock of seconds differ
MEMORY_STEPS = 100_000
MEMORY_SECONDS = 60.0
COST_STEPS, COST_SECONDS = 2000, 10.0
LATENCY_SECONDS = 20.0
ROUNDING = 1e-9  # relative: what rounded times may change in outputs that are functions of time


def dynamic_checks(
    path: Path,
    report: Listener,
    *,
    steps: int = MEMORY_STEPS,
    others: Sequence[Path] = (),
    time_limit: float = 60.0,
    only: Collection[str] = CHECKS,
    faults: Sequence[str] = (),
) -> list[Finding]:
    """Run every dynamic check on an FMU.

    Parameters
    ----------
    path : the FMU
    report : called with each finding as it is ready
    steps : of the memory check
    others : FMUs to load in one process with it; none: a copy of itself
    time_limit : wall time that one process may take [s]; the memory check may take its own more
    only : checks to run; those that every other builds on run as well
    faults : static checks with an error: what cannot be read or loaded for them is no error again
    """
    with (
        temporary_folder("check") as folder,
        ProbeRunner(archive=path.resolve(), work=folder, time_limit=time_limit) as runner,
    ):
        return CheckSequence(runner, report, steps, tuple(others), faults).run(only)


# how a process ends, or a call that every check makes: what one defect does in check after check
_ENDS = re.compile(
    r"(?:crashed with |ended the process with |no answer within |all calls returned, |a process that it started )[^:]*"
    r"|fmi[23]?(?:Terminate|Free)\w* returned .*"
)


def _cause(found: ProbeResult | Finding) -> str:
    """Return how a process or a call of every check ended, without its time; else nothing."""
    ended = _ENDS.search(found.message) if found.status == "error" else None
    return re.sub(r"[0-9.]+", "", re.sub(r" (at t = |, after )[^:]*", "", ended[0])) if ended else ""


class CheckSequence:
    """One pass through the checks, with their findings so far."""

    def __init__(
        self, runner: ProbeRunner, report: Listener, steps: int, others: tuple[Path, ...], faults: Sequence[str]
    ) -> None:
        self.runner, self._report, self._memory_steps, self._others = runner, report, steps, others
        self._faults = faults
        self.findings: list[Finding] = []
        self.experiment: Experiment
        self.steps = REFERENCE_STEPS
        self._reference_made = 0.0

    def run(self, only: Collection[str]) -> list[Finding]:
        """Run the checks in their order."""
        try:
            self.experiment = experiment_of(self.runner.archive, self.runner.unpack())
        except TemporaryFolderError:
            raise
        except (InputError, OSError) as error:
            faults = f"as {', '.join(self._faults)}: " if self._faults else ""
            result = ProbeResult(status="skipped" if faults else "error", message=f"{faults}{error}")
            self.add("dynamic.instantiate", result)
            return self._skip("cannot be instantiated")
        for check, probe, missing in (
            ("dynamic.instantiate", self._instantiate, "cannot be instantiated"),
            ("dynamic.initialise", self._simple(probes_life.initialise), "cannot be initialised"),
            ("dynamic.step", self._step, "cannot be stepped"),
        ):
            result = _carried_out(probe)
            self.add(check, result)
            if result.status == "error" and not result.numbers.get("steps"):
                return self._skip(missing)
        if not self.steps:
            return self._skip("it asks for the end in its first step")
        for check in CHECKS[3:]:
            if check not in only:
                continue
            if check in COMPARING and self._failed("dynamic.repeat"):
                reason = "two runs never give the same bits (dynamic.repeat), so there is no reference to compare with"
                self.add(check, ProbeResult(status="skipped", message=reason))
            else:
                self.add(check, _carried_out(getattr(self, f"_{check.partition('.')[2]}")))
        return self.findings

    def add(self, check: str, result: ProbeResult) -> None:
        """Keep a result as a finding, and report it; an error of a cause that was reported is skipped."""
        result = self._once(result)
        finding = Finding(
            check=check,
            group="dynamic",
            title=TITLES[check],
            status=result.status,
            message=result.message,
            details=result.details,
            numbers=result.numbers,
        )
        self.findings.append(finding)
        self._report(finding)

    def _once(self, result: ProbeResult) -> ProbeResult:
        """Return a result that is no error if its cause was reported: the same call ended in the same way."""
        of_library = [check for check in self._faults if check in ("static.functions", "static.dependencies")]
        if of_library and result.status == "error" and "cannot load the FMU" in result.message:
            return replace(result, status="skipped", message=f"as {', '.join(of_library)}: {result.message}")
        cause = _cause(result)
        if not cause:
            return result
        first = next((f for f in self.findings if f.status == "error" and _cause(f) == cause), None)
        if first is None:
            return result
        return replace(result, status="skipped", message=f"not checked: as {first.check}: {result.message}")

    def _skip(self, reason: str) -> list[Finding]:
        for check in CHECKS[len(self.findings) :]:
            self.add(check, ProbeResult(status="skipped", message=f"not checked: {reason}"))
        return self.findings

    def _failed(self, check: str) -> bool:
        return any(finding.check == check and finding.status == "error" for finding in self.findings)

    def _probe(self, probe: Probe, **options: Any) -> ProbeResult:
        return self.runner.run(probe, self.experiment, **options)

    def _simple(self, probe: Probe) -> Callable[[], ProbeResult]:
        return lambda: self._probe(probe)

    # The checks, in their order.

    def _instantiate(self) -> ProbeResult:
        result = self._probe(probes_life.instantiate)
        if result.status == "error":
            # an FMU that needs a certain working directory is reported by the check of that
            unpacked = replace(self.experiment, directory="unpacked")
            second = self.runner.run(probes_life.instantiate, unpacked)
            if second.status != "error":
                self.experiment = unpacked
                return replace(second, message=f"{second.message}, but only in the folder that it is unpacked to")
        return result

    def _step(self) -> ProbeResult:
        options: dict[str, Any] = {"steps": REFERENCE_STEPS, "seconds": REFERENCE_SECONDS}
        result = self._probe(probes_life.step, **options)
        # an FMU that gives no answer would not give one again: whoever waits for the report waits once
        if result.status == "error" and not result.numbers and not result.hangs:
            still = replace(self.experiment, stimulated=False)
            second = self.runner.run(probes_life.step, still, **options)
            if second.status != "error":
                self.experiment = still
                result = replace(second, details=(f"with moving inputs: {result.message}", *second.details))
        self.steps = int(result.numbers.get("steps", 0))
        if "ended after" in result.numbers:
            self.experiment = replace(self.experiment, most_steps=self.steps)
        self._reference_made = time.monotonic()
        return result

    def _start_values(self) -> ProbeResult:
        return self._probe(probes_setup.start_values)

    def _repeat(self) -> ProbeResult:
        time.sleep(max(0.0, SEED_AGE - (time.monotonic() - self._reference_made)))
        return self._compared("again", "in a new process", fresh=True)

    def _compared(self, name: str, words: str, **options: Any) -> ProbeResult:
        """Repeat the run and compare it with the reference."""
        got = self._trajectory(name, **options)
        if isinstance(got, ProbeResult):
            return replace(got, message=f"{words}: {got.message}")
        gap = difference(got, self._base(), self.experiment)
        if gap:
            return ProbeResult(status="error", message=f"{words}: {gap}")
        return ProbeResult(message=f"the same bits {words}")

    def _base(self) -> Trajectory:
        return Trajectory.load(self.runner.results / "base.npz")

    def _trajectory(self, name: str, **options: Any) -> Trajectory | ProbeResult:
        """Return a trajectory made in a new process, or why there is none."""
        result = self._probe(probes_life.trajectory, name=name, steps=self.steps, **options)
        return result if result.status == "error" else Trajectory.load(self.runner.results / f"{name}.npz")

    def _reset(self) -> ProbeResult:
        return self._probe(probes_life.reset)

    def _second_instance(self) -> ProbeResult:
        if self.experiment.once_per_process:
            return ProbeResult(status="skipped", message="declares that a process may hold only one instance")
        alone = self._probe(probes_life.other_phase, steps=self.steps)
        return alone if alone.status == "error" else self._probe(probes_life.second_instance)

    def _second_load(self) -> ProbeResult:
        return self._probe(probes_life.second_load)

    def _side_by_side(self) -> ProbeResult:
        results = [self._beside(other) for other in self._others or (self.runner.archive,)]
        bad = [result for result in results if result.status == "error"]
        return bad[0] if bad else replace(results[0], message="; ".join(result.message for result in results))

    def _beside(self, other: Path) -> ProbeResult:
        copy = other == self.runner.archive
        neighbour = ProbeRunner(archive=other.resolve(), work=self.runner.work / "neighbour",
                               time_limit=self.runner.time_limit)  # fmt: skip
        try:
            experiment = self.experiment if copy else experiment_of(neighbour.archive, neighbour.unpack())
        except InputError as error:
            return ProbeResult(status="skipped", message=f"{other.name}: {error}")
        if copy and self.experiment.once_per_process:
            return ProbeResult(status="skipped", message="declares that a process may hold only one instance")
        base = "base.npz"
        if not copy:
            alone = neighbour.run(probes_life.trajectory, experiment, name="alone", steps=self.steps)
            if alone.status == "error":
                return ProbeResult(status="skipped", message=f"{other.name} does not run alone: {alone.message}")
            base = str(neighbour.results / "alone.npz")
        return self._probe(
            probes_life.side_by_side,
            neighbour=experiment.as_json(),
            neighbour_folder=str(neighbour.unpack()),
            neighbour_archive=str(neighbour.archive),
            neighbour_name="a copy unpacked elsewhere" if copy else other.name,
            neighbour_base=base,
        )

    def _state(self) -> ProbeResult:
        if not self.experiment.saves_state:
            return ProbeResult(status="skipped", message="does not declare that its state can be saved")
        here = self._probe(probes_state.roll_back)
        if here.status == "error" or not self.experiment.serialises_state:
            return here
        there = self._probe(probes_state.restore, initialised=False, fresh=True)
        if there.status != "error":
            return replace(here, message=f"{here.message}; {there.message}")
        later = self._probe(probes_state.restore, initialised=True, fresh=True)
        if later.status == "error":
            return later
        return replace(later, status="warning", message=f"{later.message}, but only into an instance that was "
                       f"initialised: before, {there.message}")  # fmt: skip

    def _awkward_times(self) -> ProbeResult:
        result = self._probe(probes_life.awkward_times, steps=self.steps)
        if result.status == "error":
            return result
        worst, numbers = 0.0, {}
        for how in probes_life.AWKWARD:
            got = Trajectory.load(self.runner.results / f"{how}.npz")
            gap, words = relative_difference(got, self._base()), difference(got, self._base(), self.experiment)
            numbers[f"{how} [relative]"] = gap
            if gap > ROUNDING or (words and not gap):
                return ProbeResult(status="warning", message=f"times {how}, as hosts do: {words}", numbers=numbers)
            worst = max(worst, gap)
        same = "the same bits" if not worst else f"outputs differ by rounding, at most {worst:.1e} of their size"
        return ProbeResult(message=f"times accumulated and subtracted, as hosts do: {same}", numbers=numbers)

    def _working_directory(self) -> ProbeResult:
        if self.experiment.directory == "unpacked":
            message = "can be instantiated only if the working directory is the folder that it is unpacked to"
            return ProbeResult(status="error", message=message)
        return working_directory(self.runner, self.experiment, self._base())

    def _resource_location(self) -> ProbeResult:
        return resource_location(self.runner, self.experiment, self._base())

    def _refuses_step(self) -> ProbeResult:
        return self._probe(probes_refusal.refuses_step)

    def _logging(self) -> ProbeResult:
        return self._probe(probes_refusal.logging)

    def _invalid_reference(self) -> ProbeResult:
        return self._probe(probes_refusal.invalid_reference)

    def _latency(self) -> ProbeResult:
        state = self.experiment.saves_state and not self._failed("dynamic.state")
        limit = self.runner.time_limit + LATENCY_SECONDS
        resets = not self._failed("dynamic.reset")
        # what comes after a change has to be within the steps that it makes before a regular end
        steps = self.steps if self.experiment.most_steps is None else max(1, self.steps // 2)
        options = {"steps": steps, "seconds": LATENCY_SECONDS, "state": state, "resets": resets}
        return self._probe(latency_check.latency, time_limit=limit, **options)

    def _cost(self) -> ProbeResult:
        limit = self.runner.time_limit + COST_SECONDS
        options = {"steps": COST_STEPS, "seconds": COST_SECONDS}
        return self._probe(probes_load.cost, time_limit=limit, fresh=True, **options)

    def _memory(self) -> ProbeResult:
        limit = self.runner.time_limit + MEMORY_SECONDS
        options = {"steps": self._memory_steps, "seconds": MEMORY_SECONDS}
        return self._probe(probes_load.memory, time_limit=limit, fresh=True, **options)


def _carried_out(check: Callable[[], ProbeResult]) -> ProbeResult:
    """Return what a check found; files that the FMU overwrote do not end the report."""
    try:
        return check()
    except TemporaryFolderError:
        raise
    except Exception as error:
        reason = f"{type(error).__name__}: {' '.join(str(error).split())}"
        return ProbeResult(status="error", message=f"the check could not be carried out: {reason}")
