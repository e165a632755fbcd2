"""The dynamic checks of an FMU, in their order: each in a process of its own, each with a finding.

A check whose ground is missing (no step can be made, no two runs are alike) is skipped and says so: one defect
is reported once.
"""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable, Collection, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from lockstep.check.dynamic.experiment import Experiment, read_experiment
from lockstep.check.dynamic.laboratory import Laboratory
from lockstep.check.dynamic.probe_process import Verdict
from lockstep.check.dynamic.probes_life import AWKWARD
from lockstep.check.dynamic.trajectory import Trajectory, difference, relative_difference
from lockstep.check.dynamic.working_directory_checks import resource_location, working_directory
from lockstep.check.report.finding import Finding
from lockstep.errors import InputError
from lockstep.fmi.safe_zip import unpacking_place

Report = Callable[[Finding], None]

TITLES = {
    "dynamic.instantiate": "loads and can be instantiated",
    "dynamic.initialise": "initialises with finite outputs",
    "dynamic.step": "makes steps with finite outputs",
    "dynamic.repeat": "a new process gives the same bits",
    "dynamic.reset": "runs again after a reset",
    "dynamic.second_instance": "two instances in one process",
    "dynamic.second_load": "unloaded and loaded again in one process",
    "dynamic.side_by_side": "two builds in one process",
    "dynamic.state": "state: set back, and restored in another process",
    "dynamic.awkward_times": "times with rounding errors",
    "dynamic.working_directory": "independent of the working directory",
    "dynamic.resource_location": "runs from any path, told as any URI of it",
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
    report: Report,
    *,
    steps: int = MEMORY_STEPS,
    others: Sequence[Path] = (),
    time_limit: float = 60.0,
    only: Collection[str] = CHECKS,
) -> list[Finding]:
    """Run every dynamic check on an FMU.

    Parameters
    ----------
    path : the FMU
    report : called with each finding as it is ready
    steps : of the memory check
    others : FMUs to load beside it; none takes a copy of itself
    time_limit : wall time that one process may take [s]; the memory check may take its own more
    only : checks to run; those that every other builds on run as well
    """
    place = unpacking_place()
    with tempfile.TemporaryDirectory(prefix="lockstep_check_", dir=place, ignore_cleanup_errors=True) as folder:
        laboratory = Laboratory(archive=path.resolve(), work=Path(folder), time_limit=time_limit)
        return _Course(laboratory, report, steps, tuple(others)).run(only)


class _Course:
    """One pass through the checks, and what they have learnt of the FMU so far."""

    def __init__(self, laboratory: Laboratory, report: Report, steps: int, others: tuple[Path, ...]) -> None:
        self.laboratory, self._report, self._memory_steps, self._others = laboratory, report, steps, others
        self.findings: list[Finding] = []
        self.experiment: Experiment
        self.steps = REFERENCE_STEPS
        self._reference_made = 0.0

    def run(self, only: Collection[str]) -> list[Finding]:
        """Run the checks in their order."""
        try:
            self.experiment = read_experiment(self.laboratory.unpack())
        except (InputError, OSError) as error:
            self._tell("dynamic.instantiate", Verdict(status="error", message=str(error)))
            return self._skip("it cannot be instantiated")
        for check, probe, missing in (
            ("dynamic.instantiate", self._instantiate, "it cannot be instantiated"),
            ("dynamic.initialise", self._simple("probes_life:initialise"), "it cannot be initialised"),
            ("dynamic.step", self._step, "it cannot be stepped"),
        ):
            verdict = _carried_out(probe)
            self._tell(check, verdict)
            if verdict.status == "error" and not verdict.numbers.get("steps"):
                return self._skip(missing)
        for check in CHECKS[3:]:
            if check not in only:
                continue
            if check in COMPARING and self._failed("dynamic.repeat"):
                reason = "no two runs of it give the same bits (dynamic.repeat), so there is nothing to compare with"
                self._tell(check, Verdict(status="skipped", message=reason))
            else:
                self._tell(check, _carried_out(getattr(self, f"_{check.partition('.')[2]}")))
        return self.findings

    def _tell(self, check: str, verdict: Verdict) -> None:
        finding = Finding(
            check=check,
            group="dynamic",
            title=TITLES[check],
            status=verdict.status,
            message=verdict.message,
            details=verdict.details,
            numbers=verdict.numbers,
        )
        self.findings.append(finding)
        self._report(finding)

    def _skip(self, reason: str) -> list[Finding]:
        for check in CHECKS[len(self.findings) :]:
            self._tell(check, Verdict(status="skipped", message=f"not checked: {reason}"))
        return self.findings

    def _failed(self, check: str) -> bool:
        return any(finding.check == check and finding.status == "error" for finding in self.findings)

    def _probe(self, probe: str, **options: Any) -> Verdict:
        return self.laboratory.run(probe, self.experiment, **options)

    def _simple(self, probe: str) -> Callable[[], Verdict]:
        return lambda: self._probe(probe)

    # The checks, in their order.

    def _instantiate(self) -> Verdict:
        verdict = self._probe("probes_life:instantiate")
        if verdict.status == "error":
            # one that finds its files through the working directory is told by the check of that
            unpacked = replace(self.experiment, directory="unpacked")
            second = self.laboratory.run("probes_life:instantiate", unpacked)
            if second.status != "error":
                self.experiment = unpacked
                return replace(second, message=f"{second.message}, but only in the folder that it is unpacked to")
        return verdict

    def _step(self) -> Verdict:
        options: dict[str, Any] = {"steps": REFERENCE_STEPS, "seconds": REFERENCE_SECONDS}
        verdict = self._probe("probes_life:step", **options)
        if verdict.status == "error" and not verdict.numbers:
            still = replace(self.experiment, stimulated=False)
            second = self.laboratory.run("probes_life:step", still, **options)
            if second.status != "error":
                self.experiment = still
                verdict = replace(second, details=(f"with moving inputs: {verdict.message}", *second.details))
        self.steps = int(verdict.numbers.get("steps", 0))
        self._reference_made = time.monotonic()
        return verdict

    def _repeat(self) -> Verdict:
        time.sleep(max(0.0, SEED_AGE - (time.monotonic() - self._reference_made)))
        return self._compared("again", "in a new process")

    def _compared(self, name: str, words: str, **options: Any) -> Verdict:
        """Run once more and compare with the reference."""
        got = self._trajectory(name, **options)
        if isinstance(got, Verdict):
            return replace(got, message=f"{words}: {got.message}")
        gap = difference(got, self._base(), self.experiment)
        return Verdict(status="error", message=f"{words}: {gap}") if gap else Verdict(message=f"the same bits {words}")

    def _base(self) -> Trajectory:
        return Trajectory.load(self.laboratory.results / "base.npz")

    def _trajectory(self, name: str, **options: Any) -> Trajectory | Verdict:
        """Return a trajectory made in a new process, or why there is none."""
        verdict = self._probe("probes_life:trajectory", name=name, steps=self.steps, **options)
        return verdict if verdict.status == "error" else Trajectory.load(self.laboratory.results / f"{name}.npz")

    def _reset(self) -> Verdict:
        return self._probe("probes_life:reset")

    def _second_instance(self) -> Verdict:
        if self.experiment.once_per_process:
            return Verdict(status="skipped", message="it declares that a process may hold one instance of it only")
        alone = self._probe("probes_life:other_phase", steps=self.steps)
        return alone if alone.status == "error" else self._probe("probes_life:second_instance")

    def _second_load(self) -> Verdict:
        return self._probe("probes_life:second_load")

    def _side_by_side(self) -> Verdict:
        verdicts = [self._beside(other) for other in self._others or (self.laboratory.archive,)]
        bad = [verdict for verdict in verdicts if verdict.status == "error"]
        return bad[0] if bad else replace(verdicts[0], message="; ".join(verdict.message for verdict in verdicts))

    def _beside(self, other: Path) -> Verdict:
        copy = other == self.laboratory.archive
        neighbour = Laboratory(archive=other.resolve(), work=self.laboratory.work / "neighbour",
                               time_limit=self.laboratory.time_limit)  # fmt: skip
        try:
            experiment = self.experiment if copy else read_experiment(neighbour.unpack())
        except InputError as error:
            return Verdict(status="skipped", message=f"{other.name}: {error}")
        if copy and self.experiment.once_per_process:
            return Verdict(status="skipped", message="it declares that a process may hold one instance of it only")
        base = "base.npz"
        if not copy:
            alone = neighbour.run("probes_life:trajectory", experiment, name="alone", steps=self.steps)
            if alone.status == "error":
                return Verdict(status="skipped", message=f"{other.name} does not run by itself: {alone.message}")
            base = str(neighbour.results / "alone.npz")
        return self._probe(
            "probes_life:side_by_side",
            neighbour=experiment.as_json(),
            neighbour_folder=str(neighbour.unpack()),
            neighbour_name="a copy unpacked elsewhere" if copy else other.name,
            neighbour_base=base,
        )

    def _state(self) -> Verdict:
        if not self.experiment.saves_state:
            return Verdict(status="skipped", message="it does not declare that its state can be saved")
        here = self._probe("probes_state:roll_back")
        if here.status == "error" or not self.experiment.serialises_state:
            return here
        there = self._probe("probes_state:restore", initialised=False)
        if there.status != "error":
            return replace(here, message=f"{here.message}; {there.message}")
        later = self._probe("probes_state:restore", initialised=True)
        if later.status == "error":
            return later
        return replace(later, status="warning", message=f"{later.message}, but only into an instance that was "
                       f"initialised: before, {there.message}")  # fmt: skip

    def _awkward_times(self) -> Verdict:
        verdict = self._probe("probes_life:awkward_times", steps=self.steps)
        if verdict.status == "error":
            return verdict
        worst, numbers = 0.0, {}
        for how in AWKWARD:
            got = Trajectory.load(self.laboratory.results / f"{how}.npz")
            gap, words = relative_difference(got, self._base()), difference(got, self._base(), self.experiment)
            numbers[f"{how} [relative]"] = gap
            if gap > ROUNDING or (words and not gap):
                return Verdict(status="warning", message=f"times {how}, as hosts do: {words}", numbers=numbers)
            worst = max(worst, gap)
        same = "the same bits" if not worst else f"outputs differ by rounding, at most {worst:.1e} of their size"
        return Verdict(message=f"times accumulated and subtracted, as hosts do: {same}", numbers=numbers)

    def _working_directory(self) -> Verdict:
        if self.experiment.directory == "unpacked":
            told = "can be instantiated only if the working directory is the folder that it is unpacked to"
            return Verdict(status="error", message=told)
        return working_directory(self.laboratory, self.experiment, self._base())

    def _resource_location(self) -> Verdict:
        return resource_location(self.laboratory, self.experiment, self._base())

    def _refuses_step(self) -> Verdict:
        return self._probe("probes_refusal:refuses_step")

    def _logging(self) -> Verdict:
        return self._probe("probes_refusal:logging")

    def _invalid_reference(self) -> Verdict:
        return self._probe("probes_refusal:invalid_reference")

    def _latency(self) -> Verdict:
        state = self.experiment.saves_state and not self._failed("dynamic.state")
        limit = self.laboratory.time_limit + LATENCY_SECONDS
        resets = not self._failed("dynamic.reset")
        options = {"steps": self.steps, "seconds": LATENCY_SECONDS, "state": state, "resets": resets}
        return self._probe("latency:latency", time_limit=limit, **options)

    def _cost(self) -> Verdict:
        limit = self.laboratory.time_limit + COST_SECONDS
        return self._probe("probes_load:cost", steps=COST_STEPS, seconds=COST_SECONDS, time_limit=limit)

    def _memory(self) -> Verdict:
        limit = self.laboratory.time_limit + MEMORY_SECONDS
        options = {"steps": self._memory_steps, "seconds": MEMORY_SECONDS}
        return self._probe("probes_load:memory", time_limit=limit, **options)


def _carried_out(check: Callable[[], Verdict]) -> Verdict:
    """Return what a check found; a full disk, or files that the FMU spoiled, are no end of the report either."""
    try:
        return check()
    except Exception as error:
        reason = " ".join(str(error).split())
        return Verdict(status="error", message=f"the check could not be carried out: {type(error).__name__}: {reason}")
