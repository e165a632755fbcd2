"""Probes of the life cycle: instantiate, initialise, step, reset, and more than one instance."""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np

from lockstep.check.dynamic.checked_instance import CheckedInstance
from lockstep.check.dynamic.experiment import Experiment
from lockstep.check.dynamic.probe_process import ProbeResult, ProbeTask
from lockstep.check.dynamic.trajectory import Trajectory, difference, output_names
from lockstep.errors import EndOfSimulation, RunError

LOADS = 4
AWKWARD = ("accumulated", "subtracted")
_ANSWERS = {
    "1.0": {"GetVersion": b"1.0", "GetTypesPlatform": b"standard32"},
    "2.0": {"GetVersion": b"2.0", "GetTypesPlatform": b"default"},
    "3.0": {"GetVersion": b"3.0"},
}
OTHER_PHASE = 11  # steps that a second instance's stimulus is ahead


def instantiate(task: ProbeTask) -> ProbeResult:
    """Load the library, get the version that it implements, make one instance and free it."""
    began = time.perf_counter()
    instance = task.open()
    lasted = 1e3 * (time.perf_counter() - began)
    for name, expected in _ANSWERS[task.experiment.fmi].items():
        answer = instance.library_text(name)
        if answer != expected and not (name == "GetVersion" and answer.startswith(expected + b".")):
            words = f"{task.experiment.prefix}{name} returns {answer!r} instead of {expected!r}"
            return ProbeResult(status="error", message=words)
    return ProbeResult(message=f"in {lasted:.0f} ms", numbers={"instantiate [ms]": lasted})


def initialise(task: ProbeTask) -> ProbeResult:
    """Initialise; every output must be finite."""
    instance = task.started()
    reals = instance.row()[0]
    bad = [name for name, value in zip(output_names(task.experiment), reals, strict=False) if not np.isfinite(value)]
    if bad:
        return ProbeResult(status="error", message=f"{len(bad)} outputs are not finite, first {bad[0]}")
    return ProbeResult(message=f"{len(task.experiment.outputs)} outputs, all finite")


def step(task: ProbeTask) -> ProbeResult:
    """Make steps under the stimulus until their number or the time is up; keep the trajectory as the reference.

    The FMU may ask for the end before that: the reference ends before the step in which it does.
    """
    limit, deadline = task.options["steps"], time.monotonic() + task.options["seconds"]
    instance = task.started()
    parts: list[Trajectory] = []
    ended = ""
    while not ended and len(parts) < limit and (time.monotonic() < deadline or not parts):
        try:
            parts.append(instance.run(len(parts), len(parts) + 1))
        except EndOfSimulation as end:
            ended = f"; {str(end).removeprefix(f'{instance.name}: ')}"
    if not parts:
        return ProbeResult(status="info", message=f"no step before a regular end{ended}", numbers={"steps": 0})
    run, done = Trajectory.joined(parts), len(parts)
    run.save(task.work / "base.npz")
    experiment = task.experiment
    still = "" if experiment.stimulated else "; inputs keep their start values, as it refuses others"
    message = f"{done} steps of {experiment.step:g} s ({experiment.step_source}){still}{ended}"
    numbers = {"steps": done, "step [s]": experiment.step} | ({"ended after": done} if ended else {})
    bad = np.argwhere(~np.isfinite(run.reals))
    if len(bad):
        k, column = bad[0]
        name = output_names(experiment)[column]
        first = f"output {name} is {run.reals[k, column]} after the step at t = {experiment.time(k):.9g} s"
        return ProbeResult(status="error", message=first, details=(message,), numbers=numbers)
    return ProbeResult(message=message, numbers=numbers)


def trajectory(task: ProbeTask) -> ProbeResult:
    """Run and keep the trajectory under a name."""
    task.started().run(0, task.options["steps"]).save(task.work / f"{task.options['name']}.npz")
    return ProbeResult()


def awkward_times(task: ProbeTask) -> ProbeResult:
    """Run with times that carry rounding errors, and keep the trajectories."""
    for how in AWKWARD:
        instance = task.started()
        steps = task.options["steps"]
        try:
            run = instance.run(0, steps, times=task.experiment.times(how, steps))
        except RunError as error:
            raise RunError(f"times {how}, as hosts do: {error}") from None
        run.save(task.work / f"{how}.npz")
        instance.close()
    return ProbeResult()


def reset(task: ProbeTask) -> ProbeResult:
    """Run, reset in the middle, initialise and run again."""
    base = Trajectory.load(task.work / "base.npz")
    instance = task.started()
    called = f"{task.experiment.prefix}Reset{'Slave' if task.experiment.fmi == '1.0' else ''}"
    for part in (len(base) // 2, len(base)):
        instance.run(0, part, phase=OTHER_PHASE)
        instance.reset()
        instance.initialise()
        _same(instance.run(0, len(base)), base, task.experiment, f"after {part} steps and {called}")
        instance.reset()
        instance.initialise()
    return ProbeResult(message="the same bits after each reset")


def second_instance(task: ProbeTask) -> ProbeResult:
    """Step two instances in turn, free one, step the other on."""
    base = Trajectory.load(task.work / "base.npz")
    other = Trajectory.load(task.work / "other.npz")
    half, quarter = len(base) // 2, max(1, len(base) // 4)
    first = task.started("first")
    runs: list[list[Trajectory]] = [[first.run(0, quarter)], []]
    second = task.started("second")
    for k in range(half):
        runs[1].append(second.run(k, k + 1, phase=OTHER_PHASE))
        if quarter + k < len(base):
            runs[0].append(first.run(quarter + k, quarter + k + 1))
    second.close()
    done = sum(map(len, runs[0]))
    runs[0].append(first.run(done, len(base)))
    _same(Trajectory.joined(runs[0]), base, task.experiment, "first instance, stepped in turn with a second")
    _same(Trajectory.joined(runs[1]), other[:half], task.experiment, "second instance, stepped in turn with the first")
    return ProbeResult(message="two instances, stepped in turn, each give the bits that they give alone")


def other_phase(task: ProbeTask) -> ProbeResult:
    """Run alone the stimulus of the second instance of `second_instance`."""
    task.started().run(0, task.options["steps"], phase=OTHER_PHASE).save(task.work / "other.npz")
    return ProbeResult()


def second_load(task: ProbeTask) -> ProbeResult:
    """Free, unload, load and run several times in the same process."""
    base = Trajectory.load(task.work / "base.npz")
    for load in range(LOADS):
        instance = task.started()
        _same(instance.run(0, len(base)), base, task.experiment, f"load {load + 1} in one process")
        instance.close()
    return ProbeResult(message=f"loaded {LOADS} times in one process, the same bits each time")


def side_by_side(task: ProbeTask) -> ProbeResult:
    """Step this FMU and another one, or a copy of it unpacked elsewhere, in turn in one process."""
    neighbour = Experiment.from_json(task.options["neighbour"])
    folder, name = Path(task.options["neighbour_folder"]), task.options["neighbour_name"]
    bases = Trajectory.load(task.work / "base.npz"), Trajectory.load(task.work / task.options["neighbour_base"])
    for order in ((0, 1), (1, 0)):
        made: dict[int, CheckedInstance] = {}
        for which in order:
            opened = task.open("neighbour", folder, neighbour) if which else task.open()
            opened.initialise()
            made[which] = opened
        runs: tuple[list[Trajectory], list[Trajectory]] = ([], [])
        for k in range(min(map(len, bases))):
            for which in order:
                runs[which].append(made[which].run(k, k + 1))
        for which, experiment, words in (
            (0, task.experiment, f"together with {name}"),
            (1, neighbour, f"{name} together with it"),
        ):
            run = Trajectory.joined(runs[which])
            _same(run, bases[which][: len(run)], experiment, words)
        for which in order:
            made[which].close()
    return ProbeResult(message=f"the same bits together with {name}, whichever is loaded first")


def _same(got: Trajectory, expected: Trajectory, experiment: Experiment, when: str) -> None:
    gap = difference(got, expected, experiment)
    if gap:
        raise RunError(f"{when}: {gap}")
