"""What a command needs of time, torque and momentum, against what there is: before a run, in one line.

For flexsat's controller with flexsat's plant. The slew is planned as the controller will plan it, with the matrices in
its FMU; the wheels carry the momentum of the slew, of the initial rate and of constant external torques.
"""

from __future__ import annotations

import io
import math
from bisect import bisect_right
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any
from zipfile import ZipFile

import numpy as np

from flexsat.allocation import least_squares
from flexsat.arrays import Array
from flexsat.fmu.python.load_matrices import MODEL_FILE, load_matrices
from flexsat.parameters import DEGREE
from flexsat.ports import controller as interface
from flexsat.ports.table import Naming
from flexsat.runtime.controller import ControllerState, command, init
from flexsat.runtime.controller_parameters import ControllerMatrices
from flexsat.runtime.prepared_controller import PreparedController, prepare, wheel_momentum
from flexsat.runtime.rotations import quaternion_from_mrp
from flexsat.runtime.slew_commands import planned_motions, start_from
from flexsat.runtime.slew_motion import Motion
from flexsat.variants import CORRECTED, Variant
from lockstep import InputError
from lockstep.fmi.safe_zip import open_file
from lockstep.plan.plan import Plan
from lockstep.system.clock import seconds
from lockstep.system.component import Component

from .loop_parts import LoopParts, Parameters, loop_parts, number_of, numbers_of

_OFFSET = "initial.wheel.speed_offset"
OPTION = "--accept-infeasible"
MOST = 5  # angles in a line
ROUNDING = 1e-9  # share of the stop time
HELD = 1e-3  # share of a limit: a motion is scaled so that torques held over periods turn by the angle

Command = tuple[float, Array, float]  # when it comes [s], rotation (3,) [rad], start time [s]


@dataclass(frozen=True, slots=True, kw_only=True)
class Needs:
    """What the slews of a run need, and what there is. Torque and momentum are those of the hardest wheel."""

    angles: tuple[float, ...]  # rad, of the slews in their order; of their turns, where they lead round a cone
    start: float  # s, of the first
    end: float  # s, of the shaped torque of the last
    stop: float  # s
    torque: float  # N.m
    torque_limit: float
    momentum: float  # N.m.s beside that of the nominal speed, the most at any time
    momentum_limit: float  # N.m.s at the edge of the speed band

    def text(self) -> str:
        """Return the line to print before a run."""
        wheels = (
            f"torque {self.torque:.3g} of {self.torque_limit:.3g} N.m ({_percent(self.torque, self.torque_limit)}),"
            f" momentum {self.momentum:.3g} of {self.momentum_limit:.3g} N.m.s"
            f" ({_percent(self.momentum, self.momentum_limit)}) of a wheel"
        )
        if not self.angles:
            return f"no slew is commanded: {wheels}"
        return f"{self._slews()}: {self._ends()} at {self.end:.6g} s of {self.stop:.6g} s, {wheels}"

    def _slews(self) -> str:
        degrees = ", ".join(f"{angle / DEGREE:.6g}" for angle in self.angles[:MOST])
        more = f" and {len(self.angles) - MOST} more" if len(self.angles) > MOST else ""
        return f"slew{'s' if len(self.angles) > 1 else ''} of {degrees} deg{more} from {self.start:.6g} s"

    def _ends(self) -> str:
        return "the last ends" if len(self.angles) > 1 else "ends"

    def objection(self) -> str | None:
        """Return why the command cannot be carried out, and what would help; None if it can."""
        if self.angles and self.end > self.stop * (1.0 + ROUNDING):
            return (
                f"stop time {self.stop:.6g} s: the {self._slews()} {self._ends() if len(self.angles) == 1 else 'end'}"
                f" at {self.end:.6g} s; give --stop-time {np.ceil(self.end):.6g} or more"
            )
        if self.torque > self.torque_limit * (1.0 + HELD):
            return (
                f"torque: the slew needs {self.torque:.4g} N.m of a wheel that gives {self.torque_limit:.4g} N.m;"
                f" set controller.slew.authority lower, or the same wheel.torque_limit in controller and plant"
            )
        if self.momentum > self.momentum_limit * (1.0 + HELD):
            return (
                f"momentum: a wheel would have to take {self.momentum:.4g} N.m.s, and the edge of its speed band is at"
                f" {self.momentum_limit:.4g} N.m.s; set controller.slew.authority or the initial rates, speed offsets"
                " and external torques lower, or controller.wheel.speed_band higher; a slew is planned for wheels at"
                " controller.wheel.speed_offset"
            )
        return None


def _percent(part: float, whole: float) -> str:
    return f"{100.0 * part / whole:.0f} %" if whole > 0.0 else "none"


def check_feasible(plan: Plan, *, accept: bool = False, report: Callable[[str], None] = print) -> None:
    """Report what the command of a run needs; refuse one that cannot be carried out, unless it is to be accepted.

    Raises
    ------
    InputError
        If the run ends before the slew, torque or momentum do not suffice, or a slew begins or ends within a keep-out
        cone; with what would help.
    """
    needs = needs_of(plan)
    if needs is None:
        return
    if needs.angles or needs.momentum > 0.0:
        report(needs.text())
    objection = needs.objection()
    if objection is None:
        return
    if not accept:
        raise InputError(f"{objection}; {OPTION} runs it as it is")
    report(f"runs nevertheless: {objection}")


def needs_of(plan: Plan) -> Needs | None:
    """Return what a run needs; None for a loop of others, and for one whose torque is not commanded."""
    parts = loop_parts(plan.system)
    if parts is None or parts.controller is None or parts.ports is not parts.controller:
        return None
    parameters, controller = plan.wiring.parameters, parts.controller
    commands = _fed_commands(plan, parts, controller)
    if not commands and not any(any(numbers_of(*asked, parameters)) for asked in _asks(parts, controller)):
        return None
    try:
        values = _values(controller, "flat" if parts.flat else "structured", parameters)
        if values["open_loop"]:
            return None
        matrices = _matrices(controller, interface.variant(values.__getitem__))
        prepared = prepare(matrices, interface.parameters(matrices, values.__getitem__))
        first = values["command.rotation"], float(values["command.start_time"])
        state = init(prepared, *(commands[0][1:] if commands else first))
    except ValueError:
        return None  # the controller refuses it in its own words; one of another version is not read
    motions = _planned(prepared, state, _initial_attitude(parts, parameters, prepared), commands[1:])
    last = max((motion.end for motion in motions), default=0.0) + float(prepared.shaper.shifts[0])
    stop, nothing = seconds(plan.stop_time), np.zeros(prepared.wheels)
    base = _momentum(parts, parameters, prepared, least_squares(matrices.wheel_axis, np.ones(prepared.wheels)))
    torques, momenta = [nothing], [base(seconds(plan.system.start_time)), base(stop)]
    for motion in motions:
        wheels = wheel_momentum(prepared, motion)
        changes = np.abs(motion.scale * np.diff(motion.rates) / np.diff(motion.times))
        torques.append(np.abs(wheels) * changes.max())
        momenta.append(base(motion.end) + wheels * float(np.abs(motion.scale * motion.rates).max()))
    own = number_of(parts.plant, parts.name("wheel.torque_limit"), parameters)
    names = [parts.name("wheel.torque_limit_factor", k + 1) for k in range(prepared.wheels)]
    shares = np.array([1.0 if one is None else one for one in numbers_of(parts.plant, names, parameters)])
    limits = np.full(prepared.wheels, np.inf) if own is None else own * shares
    torque, torque_limit = _hardest(torques, np.minimum(prepared.torque_limit, limits))
    momentum, momentum_limit = _hardest(momenta, prepared.wheel_inertia * prepared.speed_band)
    return Needs(
        angles=tuple(motion.angle for motion in motions),
        start=motions[0].start if motions else 0.0,
        end=last + prepared.actuation_delay if motions else 0.0,
        stop=stop,
        torque=torque,
        torque_limit=torque_limit,
        momentum=momentum,
        momentum_limit=momentum_limit,
    )


def _hardest(needed: Sequence[Array], limits: Array) -> tuple[float, float]:
    """Return what is needed of a wheel and its limit, of the wheel that needs the largest share of it."""
    most = np.max(np.abs(needed), axis=0)
    wheel = int(np.argmax(np.divide(most, limits, out=np.where(most > 0.0, np.inf, 0.0), where=limits > 0.0)))
    return float(most[wheel]), float(limits[wheel])


def _initial_attitude(parts: LoopParts, parameters: Parameters, prepared: PreparedController) -> Array:
    """Return the attitude (4,) from which the first slew counts: where the run begins, if that is far from zero."""
    names = [parts.name("initial.mrp", axis) for axis in (1, 2, 3)]
    mrp = [one or 0.0 for one in numbers_of(parts.plant, names, parameters)]
    far = not prepared.linear_attitude and 4.0 * math.atan(math.hypot(*mrp)) > prepared.capture_angle
    return np.array(quaternion_from_mrp(mrp if far else (0.0, 0.0, 0.0)))


def _planned(
    prepared: PreparedController, state: ControllerState, attitude: Array, commands: Sequence[Command]
) -> list[Motion]:
    """Return the turns that the controller will fly, as it plans them when the commands come."""
    try:
        start_from(prepared, state, 0.0, attitude.tolist())
        motions = planned_motions(prepared, state)
        for time, rotation, start in commands:
            command(prepared, state, time, rotation, start)
            motions = [one for one in motions if one.start < state.profile.start] + planned_motions(prepared, state)
    except ValueError as error:
        raise InputError(str(error)) from None
    return motions


def _fed_commands(plan: Plan, parts: LoopParts, controller: Component) -> list[Command]:
    """Return the commands that a file feeds, at the times at which they change: when, rotation, start time."""
    known = plan.descriptions[controller.name].variables
    names = [parts.name("command.rotation", axis) for axis in (1, 2, 3)] + [parts.name("command.start_time")]
    fed: list[tuple[Sequence[float], Array] | None] = []
    for name in names:
        columns = [
            (part.times, part.values[:, part.references.index(known[name].reference)])
            for part in plan.inputs
            if part.component == controller.name
            and part.scalar == "Real"
            and name in known
            and known[name].reference in part.references
        ]
        fed.append(columns[0] if columns else None)
    times = sorted({time for column in fed if column is not None for time in column[0]})
    held = [one or 0.0 for one in numbers_of(controller, names, plan.wiring.parameters)] if times else []
    commands: list[Command] = []
    for time in times:
        row = [
            fixed if column is None else float(column[1][max(0, bisect_right(column[0], time) - 1)])
            for column, fixed in zip(fed, held, strict=True)
        ]
        if not commands or row != [*commands[-1][1].tolist(), commands[-1][2]]:
            commands.append((time, np.array(row[:3]), row[3]))
    return commands


def _asks(parts: LoopParts, controller: Component) -> Iterator[tuple[Component, list[str]]]:
    """Yield the parameters and inputs of which one has to differ from zero for wheels to have work before noise."""
    yield controller, [parts.name("command.rotation", axis) for axis in (1, 2, 3)]
    sizes = ((_OFFSET, len(parts.torques)), ("initial.rate", 3), ("external.torque", 3))
    yield parts.plant, [parts.name(port, k) for port, size in sizes for k in range(1, size + 1)]


def _momentum(
    parts: LoopParts, parameters: Parameters, prepared: PreparedController, distribution: Array
) -> Callable[[float], Array]:
    """Return the momentum (n,) [N.m.s] that the wheels carry at a time with the body at rest.

    That at the start, in the wheels' speed offsets and the body's rate, and what an external torque, constant in the
    body, adds.
    """
    offset, rate, torque = (
        np.array(
            [one or 0.0 for one in numbers_of(parts.plant, [parts.name(port, k + 1) for k in range(size)], parameters)]
        )
        for port, size in (
            (_OFFSET, prepared.wheels),
            ("initial.rate", 3),
            ("external.torque", 3),
        )
    )
    start = prepared.wheel_inertia * offset - distribution @ (prepared.inertia @ rate)
    return lambda time: start - distribution @ torque * time


def _values(component: Component, naming: Naming, parameters: Parameters) -> dict[str, Any]:
    """Return the value of each input and parameter of a controller by port."""
    ports = interface.ports(_matrices(component, CORRECTED))
    given = parameters.get(component.name, {})
    values: dict[str, Any] = {}
    for port in ports:
        if port.causality != "output":
            names = [port.scalar_name(k, naming) for k in range(port.length)]
            known = [given.get(name, start) for name, start in zip(names, port.starts, strict=True)]
            values[port.name] = known[0] if port.size is None else np.array(known)
    return values


def _matrices(component: Component, variant: Variant) -> ControllerMatrices:
    """Return the matrices in a controller's FMU."""
    with open_file(component.source, component.archive, component.name) as stream, ZipFile(stream) as archive:
        return load_matrices(io.BytesIO(archive.read(f"resources/{MODEL_FILE}")), ControllerMatrices, variant)
