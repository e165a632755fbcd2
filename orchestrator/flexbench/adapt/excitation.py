"""Measure a controller's static response to attitude and rate errors.

Each experiment runs in a process of its own: an FMU may allow one instance in a process, or crash it.
"""

from __future__ import annotations

import math
import pickle
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, closing, contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from tempfile import mkdtemp

import numpy as np
from numpy.typing import NDArray

from flexsat.arrays import Array
from lockstep.adapter.bind import Binding, Variables, bind
from lockstep.adapter.rotation import quaternion_from_mrp
from lockstep.adapter.slave import AdaptedSlave
from lockstep.errors import RunError
from lockstep.fmi.instantiate import instantiate
from lockstep.fmi.model_description import Description, read_description
from lockstep.fmi.slave import DTYPES, SCALARS, WARNING, Buffer
from lockstep.fmi.temporary_folder import temporary_folder
from lockstep.operating_system import can_serve_copies
from lockstep.processes.child_call import call_in_child
from lockstep.processes.child_process import ChildProcess, environment_of, printed_lines
from lockstep.processes.fork_server import ForkServer
from lockstep.system.adapter_file import Adapter
from lockstep.system.clock import seconds
from lockstep.system.component import Component

Call = Callable[[], object]
_TIME_LIMIT = 300.0  # [s] for all experiments of one command
_TASK, _ANSWERS = "task", "answers"  # files between the command and the process of its experiments
_MODULE, _ROTATIONS = "flexbench.adapt.excitation", "scipy.spatial.transform"  # what that process imports


@dataclass(frozen=True, slots=True, kw_only=True)
class Excitation:
    """State of rest, errors to apply and expected response of a spacecraft, in the SI units of the interface ports."""

    component: str  # name of the contract, such as controller:centralised
    ports: Variables  # of the interface
    period: int  # [ns] of flexsat's component
    nominal: Mapping[str, float]  # inputs at rest
    attitude: tuple[str, str, str]  # inputs: MRP, body from inertial
    rate: Mapping[str, tuple[float, float, float]]  # inputs that measure rate, and their axes
    torque: tuple[str, ...]  # outputs
    wheel_axis: Array  # (n, 3)
    stiffness: Array  # (3, 3) [N.m/rad]: minus the body torque of the reference for an attitude error
    damping: Array  # (3, 3) [N.m.s/rad]: the same for a rate error
    angle: float  # [rad] attitude error to apply
    speed: float  # [rad/s] rate error to apply


@dataclass(frozen=True, slots=True, kw_only=True)
class Response:
    """Hold the torque on the body: at rest, (3,) [N.m], and for errors about axis k in column k, (3, 3)."""

    rest: Array
    attitude: Array  # [N.m/rad]
    rate: Array  # [N.m.s/rad]
    wheels: float = 0.0  # [N.m] largest change of a wheel's torque: more than 0 where the torques cancel on the body


Respond = Callable[[Sequence[Adapter], float], list[Response | str]]
"""Returns the response after a time [s] through each adapter, or why there is none; raises InputError, RunError."""


@contextmanager
def experiments(fmu: Path, adapter: Adapter, excitation: Excitation) -> Iterator[Respond]:
    """Open the experiments with one FMU, behind an adapter and variants of it; raises InputError.

    Their processes are copies of one that has imported what they need, where the system can: imports take longer than
    the experiments with an adapter that is right.
    """
    component = Component(name=fmu.stem.replace(".", "_") or "fmu", source=fmu.absolute(), period=excitation.period)
    description = read_description(component)
    modules = [_MODULE, *[_ROTATIONS] * any(entry.attitude is not None for entry in adapter.entries)]
    with temporary_folder("adapt") as folder, ExitStack() as stack:
        server = None
        if can_serve_copies():
            server = stack.enter_context(closing(ForkServer(modules, environment_of(folder / "tmp"), folder)))
        yield partial(_respond, component, description, excitation, folder, server)


def _respond(
    component: Component,
    description: Description,
    excitation: Excitation,
    folder: Path,
    server: ForkServer | None,
    adapters: Sequence[Adapter],
    span: float,
) -> list[Response | str]:
    for adapter in adapters:
        bind(adapter, excitation.ports, description.variables)
    (folder / _TASK).write_bytes(pickle.dumps((component, description, list(adapters), excitation, span)))
    directory = Path(mkdtemp(dir=folder))  # an FMU may write to the working directory
    words = [f"{_MODULE}:serve"]
    if server is None:
        words = ["-c", f"import sys; from {_MODULE} import serve; serve(sys.argv[1:])"]
    try:
        child = ChildProcess(
            [*words, str(folder)],
            printed=folder / "printed",
            temporary=folder / "tmp",
            directory=directory,
            server=server,
        )
    except OSError as error:  # an FMU may have ended the server
        raise RunError(f"{component.source}: the experiments failed: {error}") from None
    try:
        code = child.wait(_TIME_LIMIT, pauses=True)
    finally:
        child.kill()
        child.wait()
    if code is None:
        raise RunError(f"{component.source}: the experiments took more than {_TIME_LIMIT:g} s")
    if code != 0:
        reason = "".join(printed_lines(child.printed, 1)) or f"exit code {code}"
        raise RunError(f"{component.source}: the experiments failed: {reason}")
    answers: list[Response | str] = pickle.loads((folder / _ANSWERS).read_bytes())
    return answers


def serve(arguments: Sequence[str]) -> int:
    """Answer the task in the folder that is the argument; runs in a process of one thread, which may fork."""
    folder = Path(arguments[0])
    component, description, adapters, excitation, span = pickle.loads((folder / _TASK).read_bytes())
    if any(entry.attitude is not None for adapter in adapters for entry in adapter.entries):
        quaternion_from_mrp(np.zeros(3))  # imports SciPy's rotations here, once: the copies of this process have them
    answers = [_variant(component, description, adapter, excitation, span) for adapter in adapters]
    (folder / _ANSWERS).write_bytes(pickle.dumps(answers))
    return 0


def _variant(
    component: Component, description: Description, adapter: Adapter, excitation: Excitation, span: float
) -> Response | str:
    binding = bind(adapter, excitation.ports, description.variables)
    experiment = partial(_torque, component, description, binding, excitation, span)
    zero = np.zeros(3)
    cases = [(zero, zero)]
    cases += [(excitation.angle * axis, zero) for axis in np.eye(3)]
    cases += [(zero, excitation.speed * axis) for axis in np.eye(3)]
    calls = [partial(experiment, *case) for case in cases]
    if description.once_per_process:
        answers = [call_in_child(call) for call in calls]
    else:
        together = call_in_child(partial(_all, calls))
        answers = together if isinstance(together, list) else [together]
    for answer in answers:
        if isinstance(answer, str):
            return answer
    wheels = np.array([np.asarray(answer) for answer in answers]).T  # [N.m] a row a wheel, a column an experiment
    body = -excitation.wheel_axis.T @ wheels
    change = body[:, 1:] - body[:, :1]
    return Response(
        rest=body[:, 0],
        attitude=change[:, :3] / excitation.angle,
        rate=change[:, 3:] / excitation.speed,
        wheels=float(np.max(np.abs(wheels[:, 1:] - wheels[:, :1]))),
    )


def _all(calls: Sequence[Call]) -> list[object]:
    return [call() for call in calls]


def _torque(
    component: Component,
    description: Description,
    binding: Binding,
    excitation: Excitation,
    span: float,
    rotation: Array,
    rate: Array,
) -> Array:
    """Return the torque of each wheel at the end of a motion from rest to this attitude error, or at this rate."""
    step = binding.adapter.step or excitation.period
    count = max(2, math.ceil(span / seconds(step)))
    positions, rates = motion(rotation, rate, count, seconds(step))
    with temporary_folder("adapt") as folder:
        slave = instantiate(component, description, folder, lambda *_: None, alone=True)
        try:
            adapted = AdaptedSlave(slave, binding)
            sensors = _Sensors(adapted, binding, excitation)
            _called(adapted, "SetupExperiment", adapted.setup_experiment(0.0, len(rates) * seconds(step)))
            _called(adapted, "EnterInitializationMode", adapted.enter_initialization())
            sensors.measure(positions[0], rates[0])
            _called(adapted, "ExitInitializationMode", adapted.exit_initialization())
            for number, (position, speed) in enumerate(zip(positions, rates, strict=True)):
                sensors.measure(position, speed)
                _called(adapted, "DoStep", adapted.do_step(seconds(number * step), seconds(step), 1))
            torque = np.zeros(len(excitation.torque))
            references = [binding.shown[name].reference for name in excitation.torque]
            adapted.getter("Real", np.array(references, np.uint32), torque)()
        finally:
            slave.close()
    return torque


def motion(rotation: Array, rate: Array, count: int, step: float) -> tuple[Array, Array]:
    """Return attitudes and rates of the samples of a motion from rest at zero, which gyros and star tracker both see.

    To an attitude error the body turns for `count` steps and stays for as many. A rate lasts for the last `count` steps
    and ends at zero attitude, so that no attitude error acts; the body turns back before. An error from the first
    sample on would be the attitude at which a run begins, from which a controller may count.

    Parameters
    ----------
    rotation, rate : (3,) [rad], [rad/s]: one of them is zero

    Returns
    -------
    positions, rates : (2 count + 1, 3) each
    """
    turning = rotation / (count * step) - rate
    back = np.zeros(3) + rate
    rates = np.vstack([np.zeros(3), np.tile(turning, (count, 1)), np.tile(back, (count, 1))])
    return step * np.cumsum(rates, axis=0), rates


class _Sensors:
    """Inputs of a slave that hold the sensors' measurements, at rest until a motion is measured."""

    def __init__(self, slave: AdaptedSlave, binding: Binding, excitation: Excitation) -> None:
        moved = (*excitation.attitude, *excitation.rate)
        values = {**excitation.nominal, **dict.fromkeys(moved, 0.0)}
        self._axes = np.array(list(excitation.rate.values())).reshape(-1, 3)
        self._calls: list[Callable[[], int]] = []
        self._places: list[tuple[Buffer, NDArray[np.intp], NDArray[np.intp]]] = []  # buffer, positions, which is moved
        for scalar in SCALARS:
            ports = [v for v in binding.shown.values() if v.name in values and v.scalar == scalar]
            if not ports:
                continue
            names = [v.name for v in ports]
            buffer: Buffer = np.array([values[name] for name in names], DTYPES[scalar])
            self._calls.append(slave.setter(scalar, np.array([v.reference for v in ports], np.uint32), buffer))
            there = [k for k, name in enumerate(moved) if name in names]
            self._places.append(
                (buffer, np.array([names.index(moved[k]) for k in there], np.intp), np.array(there, np.intp))
            )

    def measure(self, rotation: Array, rate: Array) -> None:
        """Set the measurements. The rotation is about one axis, so that the MRP is tan(angle / 4)."""
        measured = np.concatenate([np.tan(rotation / 4.0), self._axes @ rate])
        for buffer, positions, which in self._places:
            buffer[positions] = measured[which]
        for call in self._calls:
            call()


def _called(slave: AdaptedSlave, call: str, status: int) -> None:
    if status > WARNING:
        slave.failed(status)
        raise RunError(f"{slave.outcome(call, status)}: {slave.last_messages() or 'it logged no reason'}")
