"""What a command needs of time, torque and momentum, against what there is: before a run, in one line.

For flexsat's controller with flexsat's plant. The slew is planned as the controller will plan it, with the matrices in
its FMU; the wheels carry the momentum of the slew, of the initial rate and of constant external torques.
"""

from __future__ import annotations

import io
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any
from zipfile import ZipFile

import numpy as np

from flexsat.arrays import Array
from flexsat.controller_weights import Variant
from flexsat.fmu.python.load_matrices import MODEL_FILE, load_matrices
from flexsat.parameters import DEGREE
from flexsat.ports import controller as interface
from flexsat.ports.table import Naming
from flexsat.runtime.controller_parameters import ControllerMatrices
from flexsat.runtime.prepared_controller import PreparedController, plan_motion, prepare
from lockstep import InputError
from lockstep.fmi.safe_zip import open_file
from lockstep.plan.plan import Plan
from lockstep.system.clock import seconds
from lockstep.system.component import Component

from .loop_parts import LoopParts, Parameters, loop_parts, number_of

_OFFSET = "initial.wheel.speed_offset"
OPTION = "--accept-infeasible"
ROUNDING = 1e-9  # share of the stop time
HELD = 1e-3  # share of a limit: a motion is scaled so that torques held over periods turn by the angle


@dataclass(frozen=True, slots=True, kw_only=True)
class Needs:
    """What the first command of a run needs, and what there is. Torque and momentum are those of the hardest wheel."""

    rotation: tuple[float, ...]  # rad
    start: float  # s
    end: float  # s: of the shaped torque
    stop: float  # s
    torque: float  # N.m
    torque_limit: float
    momentum: float  # N.m.s beside that of the nominal speed, the most at any time
    momentum_limit: float  # N.m.s at the edge of the speed band

    @property
    def angle(self) -> float:
        """The angle to turn by [rad]."""
        return float(np.linalg.norm(self.rotation))

    def text(self) -> str:
        """Return the line to print before a run."""
        wheels = (
            f"torque {self.torque:.3g} of {self.torque_limit:.3g} N.m ({_percent(self.torque, self.torque_limit)}),"
            f" momentum {self.momentum:.3g} of {self.momentum_limit:.3g} N.m.s"
            f" ({_percent(self.momentum, self.momentum_limit)}) of a wheel"
        )
        if self.angle == 0.0:
            return f"no slew is commanded: {wheels}"
        slew = f"slew of {self.angle / DEGREE:.6g} deg from {self.start:.6g} s"
        return f"{slew}: ends at {self.end:.6g} s of {self.stop:.6g} s, {wheels}"

    def objection(self) -> str | None:
        """Return why the command cannot be carried out, and what would help; None if it can."""
        if self.angle and self.end > self.stop * (1.0 + ROUNDING):
            return (
                f"stop time {self.stop:.6g} s: the slew of {self.angle / DEGREE:.6g} deg from {self.start:.6g} s"
                f" ends at {self.end:.6g} s; give --stop-time {np.ceil(self.end):.6g} or more"
            )
        if self.torque > self.torque_limit * (1.0 + HELD):
            return (
                f"torque: the slew needs {self.torque:.4g} N.m of a wheel that gives {self.torque_limit:.4g} N.m;"
                f" set controller.slew.authority lower, or the wheel.torque_limit of controller and plant alike"
            )
        if self.momentum > self.momentum_limit * (1.0 + HELD):
            return (
                f"momentum: a wheel would have to take {self.momentum:.4g} N.m.s, and the edge of its speed band is at"
                f" {self.momentum_limit:.4g} N.m.s; set controller.slew.authority or the initial rates, speed offsets"
                " and external torques lower, or controller.wheel.speed_band higher"
            )
        return None


def _percent(part: float, whole: float) -> str:
    return f"{100.0 * part / whole:.0f} %" if whole > 0.0 else "none"


def check_feasible(plan: Plan, *, accept: bool = False, report: Callable[[str], None] = print) -> None:
    """Report what the command of a run needs; refuse one that cannot be carried out, unless it is to be accepted.

    Raises
    ------
    InputError
        If the run ends before the slew, or torque or momentum do not suffice; with what would help.
    """
    needs = needs_of(plan)
    if needs is None:
        return
    if needs.angle or needs.momentum > 0.0:
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
    parameters = plan.wiring.parameters
    if not any(number_of(*one, parameters) for one in _asks(parts, parts.controller)):
        return None
    values = _values(parts.controller, "flat" if parts.flat else "structured", parameters)
    if values["open_loop"]:
        return None
    try:
        matrices = _matrices(parts.controller, interface.variant(values.__getitem__))
        prepared = prepare(matrices, interface.parameters(matrices, values.__getitem__))
        motion = plan_motion(prepared, values["command.rotation"], float(values["command.start_time"]))
    except ValueError:
        return None  # the controller refuses it in its own words
    stop, turns = seconds(plan.stop_time), motion.angle > 0.0
    body = prepared.inertia @ motion.axis
    rate = float(np.abs(motion.scale * motion.rates).max())
    acceleration = float(np.abs(motion.scale * np.diff(motion.rates) / np.diff(motion.times)).max())
    own = number_of(parts.plant, parts.name("wheel.torque_limit"), parameters)
    base = _momentum(parts, parameters, prepared)
    slew = prepared.distribution @ body * rate
    return Needs(
        rotation=tuple(values["command.rotation"].tolist()),
        start=float(values["command.start_time"]),
        end=motion.end + float(prepared.shaper.shifts[0]) + prepared.actuation_delay if turns else 0.0,
        stop=stop,
        torque=float(np.abs(prepared.distribution @ body).max()) * acceleration if turns else 0.0,
        torque_limit=min(prepared.torque_limit, np.inf if own is None else own),
        momentum=max(
            float(np.abs(one).max()) for one in (base(0.0), base(stop), *((base(motion.end) + slew,) if turns else ()))
        ),
        momentum_limit=prepared.wheel_inertia * prepared.speed_band,
    )


def _asks(parts: LoopParts, controller: Component) -> Iterator[tuple[Component, str]]:
    """Yield the parameters and inputs of which one has to differ from zero for wheels to have work before noise."""
    yield from ((controller, parts.name("command.rotation", axis)) for axis in (1, 2, 3))
    for port, size in ((_OFFSET, len(parts.torques)), ("initial.rate", 3), ("external.torque", 3)):
        yield from ((parts.plant, parts.name(port, k)) for k in range(1, size + 1))


def _momentum(parts: LoopParts, parameters: Parameters, prepared: PreparedController) -> Callable[[float], Array]:
    """Return the momentum (n,) [N.m.s] that the wheels carry at a time with the body at rest.

    That at the start, in the wheels' speed offsets and the body's rate, and what an external torque, constant in the
    body, adds.
    """
    offset, rate, torque = (
        np.array([number_of(parts.plant, parts.name(port, k), parameters) or 0.0 for k in range(1, size + 1)])
        for port, size in (
            (_OFFSET, prepared.wheels),
            ("initial.rate", 3),
            ("external.torque", 3),
        )
    )
    start = prepared.wheel_inertia * offset - prepared.distribution @ (prepared.inertia @ rate)
    return lambda time: start - prepared.distribution @ torque * time


def _values(component: Component, naming: Naming, parameters: Parameters) -> dict[str, Any]:
    """Return the value of each input and parameter of a controller by port."""
    ports = interface.ports(_matrices(component, "corrected"))
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
