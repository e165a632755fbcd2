"""Probes of the state: set back in the same instance, and restored in another process."""

from __future__ import annotations

from lockstep.check.dynamic.probe_process import ProbeResult, ProbeTask
from lockstep.check.dynamic.trajectory import Trajectory, difference
from lockstep.errors import RunError

FILE = "state"


def saved_at(steps: int) -> int:
    """Return the step before which a run of so many steps is saved: in its middle, between usual samples."""
    return max(1, steps // 2 - 3)


def roll_back(task: ProbeTask) -> ProbeResult:
    """Save in the middle of a run, step on, set back and step on again; serialise if the FMU can."""
    base = Trajectory.load(task.work / "base.npz")
    saved, end = saved_at(len(base)), len(base)
    instance = task.started()
    instance.run(0, saved)
    state = instance.get_state()
    content = instance.serialised(state) if task.experiment.serialises_state else b""
    (task.work / FILE).write_bytes(content)
    _same(task, instance.run(saved, end), base[saved:], saved, "after its state was read the run continues differently")
    for again in ("", " a second time"):
        instance.set_state(state)
        _same(task, instance.run(saved, end), base[saved:], saved, f"set back{again}, the run continues differently")
    instance.free_state(state)
    if task.experiment.most_steps is None:
        instance.run(end, end + 3)  # a freed state must leave nothing behind that the run needs
    return ProbeResult(message="set back in the middle of a run, the same bits", numbers={"state [B]": len(content)})


def restore(task: ProbeTask) -> ProbeResult:
    """Continue from the serialised state in this new process."""
    base = Trajectory.load(task.work / "base.npz")
    saved = saved_at(len(base))
    instance = task.open()
    if task.options["initialised"]:
        instance.initialise()
        instance.run(0, 3, phase=1)
    state = instance.deserialised((task.work / FILE).read_bytes())
    instance.set_state(state)
    _same(task, instance.run(saved, len(base)), base[saved:], saved, "restored in another process, the run differs")
    instance.free_state(state)
    return ProbeResult(message="restored in another process, the same bits")


def _same(task: ProbeTask, got: Trajectory, expected: Trajectory, first: int, words: str) -> None:
    gap = difference(got, expected, task.experiment, first)
    if gap:
        raise RunError(f"{words}: {gap}")
