"""Checks of the state: set back in the same instance, and restored in another process."""

from __future__ import annotations

from ctypes import byref, c_size_t, c_void_p, create_string_buffer

from lockstep.check.dynamic.fmi2_instance import Failed, Instance
from lockstep.check.dynamic.probe_process import ProbeResult, ProbeTask
from lockstep.check.dynamic.trajectory import Trajectory, difference

FILE = "state"
POINTER = (c_void_p,)


def saved_at(steps: int) -> int:
    """Return the step before which a run of so many steps is saved: in its middle, between usual samples."""
    return max(1, steps // 2 - 3)


def get_state(instance: Instance) -> c_void_p:
    """Return the handle of a new state."""
    state = c_void_p()
    instance.demand("fmi2GetFMUstate", byref(state), types=POINTER)
    return state


def set_state(instance: Instance, state: c_void_p) -> None:
    """Set a state."""
    instance.demand("fmi2SetFMUstate", state, types=POINTER)


def free_state(instance: Instance, state: c_void_p) -> None:
    """Free a state."""
    instance.demand("fmi2FreeFMUstate", byref(state), types=POINTER)


def roll_back(task: ProbeTask) -> ProbeResult:
    """Save in the middle of a run, step on, set back and step on again; serialise if the FMU can."""
    base = Trajectory.load(task.work / "base.npz")
    saved, end = saved_at(len(base)), len(base)
    instance = task.started()
    instance.run(0, saved)
    state = get_state(instance)
    size = len(_serialised(task, instance, state)) if task.experiment.serialises_state else 0
    _same(task, instance.run(saved, end), base[saved:], saved, "after fmi2GetFMUstate the run goes on differently")
    for again in ("", " a second time"):
        set_state(instance, state)
        _same(task, instance.run(saved, end), base[saved:], saved, f"set back{again}, the run goes on differently")
    free_state(instance, state)
    instance.run(end, end + 3)  # a freed state must leave nothing behind that the run needs
    return ProbeResult(message="set back in the middle of a run, the same bits", numbers={"state [B]": size})


def restore(task: ProbeTask) -> ProbeResult:
    """Go on from the serialised state in this new process."""
    base = Trajectory.load(task.work / "base.npz")
    saved = saved_at(len(base))
    instance = task.open()
    if task.options["initialised"]:
        instance.initialise()
        instance.run(0, 3, phase=1)
    data = (task.work / FILE).read_bytes()
    state = c_void_p()
    buffer = create_string_buffer(data, len(data))
    types = (c_void_p, c_size_t, c_void_p)
    instance.demand("fmi2DeSerializeFMUstate", buffer, len(data), byref(state), types=types)
    set_state(instance, state)
    _same(task, instance.run(saved, len(base)), base[saved:], saved, "restored in another process, the run differs")
    free_state(instance, state)
    return ProbeResult(message="restored in another process, the same bits")


def _serialised(task: ProbeTask, instance: Instance, state: c_void_p) -> bytes:
    size = c_size_t()
    instance.demand("fmi2SerializedFMUstateSize", state, byref(size), types=(c_void_p, c_void_p))
    buffer = create_string_buffer(size.value)
    types = (c_void_p, c_void_p, c_size_t)
    instance.demand("fmi2SerializeFMUstate", state, buffer, size.value, types=types)
    (task.work / FILE).write_bytes(buffer.raw)
    return buffer.raw


def _same(task: ProbeTask, got: Trajectory, expected: Trajectory, first: int, words: str) -> None:
    gap = difference(got, expected, task.experiment, first)
    if gap:
        raise Failed(f"{words}: {gap}")
