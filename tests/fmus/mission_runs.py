"""Short runs of the components of missions in which each parameter acts, for a Python component or its native twin.

Inputs are stimuli, but for the encoders of the manager: its wheels follow their torque, and one of them seizes.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from flexsat.fmu.build_missions import MISSION_SHELLS
from flexsat.ports.table import Port, PortTable
from flexsat.ports.thrusters import COUNT, DIRECTIONS
from flexsat.ports.units import unit_of

Values = Mapping[str, Any]
Run = dict[str, NDArray[np.float64]]  # output to (steps, size)
STEPS = {"environment": 3, "thrusters": 12, "mission": 116}
STEP = {"environment": 400.0, "thrusters": 5e-3, "mission": 5e-3}  # s
WHEELS = 6
SPEED = np.array([36.0, 33.0, 23.0, 30.0, 27.0, 21.0])  # rad/s
STARTING_SPEED = SPEED + np.array([0.12, -0.1, 0.08, 0.05, -0.06, -0.015])
SEIZES = 70  # step
INERTIA = np.array([4.62, 4.1, 3.9, 5.0, 4.4, 4.8])  # kg.m2
_TIMES, _ACTIONS = (0.05, 0.15, 0.32, 0.4), (1, 2, 1, 0)
_ROTATIONS = ((0.01, 0.0, 0.02), (0.0, 0.0, 0.0), (0.0, -0.03, 0.04), (0.0, 0.0, 0.0))
# numbers of one SI unit: no two units of ports have the same, and roots of powers of four are exact
OTHER_UNITS = {"m": 2.0**6, "s": 2.0**4, "kg": 2.0**-10, "A": 2.0**2, "rad": 1.0}
BASE: dict[str, dict[str, Any]] = {
    "environment": {
        "orbit.radius": 7.1e6, "orbit.node": 0.3, "orbit.inclination": 1.1, "orbit.argument": 2.0,
        "solar.sun_direction": (1.0, 0.3, 0.1), "solar.normal": (0.1, 0.2, 0.9),
        "solar.centre_of_pressure": (0.1, 0.05, -0.2), "magnetic.dipole_axis": (0.1, 0.2, 2.0),
        "magnetic.residual_dipole": (10.0, 7.0, -3.0),
        "constant.force": (1e-3, 4e-3, -2e-3), "constant.torque": (1e-4, 2e-4, 3e-4),
    },
    "thrusters": {"thrust.period": 0.02, "thrust.noise": 0.1, "seed": 3},
    "mission": {
        "timeline.time": (*_TIMES, *[0.0] * 44),
        "timeline.action": (*_ACTIONS, *[0] * 44),
        "timeline.rotation": (*np.ravel(_ROTATIONS), *[0.0] * 132),
        "settle.dwell": 0.02, "settle.band": 1e-3, "star_tracker.outage_time": 0.03, "safe.outage_time": 0.03,
        "thrust.period": 0.01, "thrust.minimum_impulse": 5e-4, "off_loading.duration": 0.1,
        "off_loading.tolerance": 0.6, "wheel.nominal_speed": tuple(SPEED), "wheel.inertia": tuple(INERTIA),
        "wheel.torque_limit": (4.4, 3.6, 4.2, 2.9, 4.9, 4.0),
        "wheel.axis": (0.8, 0.6, 0.0, 0.0, 0.8, 0.6, 0.6, 0.0, 0.8, -1.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, -1.0),
    },
}  # fmt: skip
# what a parameter needs to have an effect: wheels leave their nominal speeds by up to 0.06 of the band
NEEDS: dict[str, dict[str, Values]] = {
    "environment": {},
    "thrusters": {},
    "mission": {"wheel.speed_band": {"off_loading.automatic": 0.07}},
}
_OPPOSITE = tuple(-x for row in DIRECTIONS for x in row)
# values where a quarter less, or a small number in place of zero, is refused or too little
OTHER: dict[str, Any] = {
    "orbit.radius": 7.3e6,
    "solar.sun_direction": (1.0, 0.3, 0.4),
    "solar.normal": (0.1, 0.4, 0.9),
    "magnetic.dipole_axis": (0.1, 0.2, 1.0),
    "thruster.direction": _OPPOSITE,
    "thrust.minimum_impulse": 9e-4,
    "off_loading.duration": 0.13,
    "failure.threshold": 10.0,
    "seed": 4,
    "timeline.action": (*_ACTIONS[:2], 3, *[0] * 45),
}
PERIODS_OTHER = {"thrusters": 0.03, "mission": 0.02}  # of the thrusters: whole steps


class Instance(Protocol):
    """A component outside an FMU, of either kind."""

    @property
    def table(self) -> PortTable: ...

    def set(self, name: str, value: Any) -> None: ...

    def start(self) -> None: ...

    def first_step(self, length: float) -> None: ...

    def advance(self, time: float, step: float) -> None: ...

    def view(self, name: str) -> Any: ...


class PythonInstance:
    """A Python component as its FMU calls it, for the life cycle of a twin. A refused call raises ValueError."""

    def __init__(self, component: str, resources: Path) -> None:
        self._slave = MISSION_SHELLS[component](instance_name=component, resources=str(resources))
        self.table = self._slave.table

    def _check(self) -> None:
        if self._slave.log_queue:
            raise ValueError(self._slave.log_queue[0].msg)

    def set(self, name: str, value: Any) -> None:
        port, span = self.table[name], self.table.span(name)
        first = self.table.first_reference[port.kind] + span.start
        values = np.broadcast_to(value, port.length).tolist()
        getattr(self._slave, f"set_{port.kind}")(list(range(first, first + port.length)), values)

    def start(self) -> None:
        self._slave.setup_experiment(0.0)
        self._slave.enter_initialization_mode()
        self._slave.exit_initialization_mode()
        self._check()

    def first_step(self, length: float) -> None:
        """Leave it to the component, which is prepared in its first step."""

    def advance(self, time: float, step: float) -> None:
        self._slave.do_step(time, step)
        self._check()

    def view(self, name: str) -> Any:
        return self._slave.view(name)


def other_value(component: str, port: Port, settings: Values) -> Any:
    """Return another legal value of a parameter, different in all elements that act."""
    if port.name == "thrust.period":
        return PERIODS_OTHER[component]
    if port.name in OTHER:
        return OTHER[port.name]
    now = np.ravel((BASE[component] | dict(settings)).get(port.name, port.start))
    if port.kind == "boolean":
        return not now[0]
    return 0.75 * now if np.any(now) else 1e-3


@dataclass(frozen=True)
class AsPorts:
    """Values as the ports state them: in SI, in the order of the settings."""

    second: float = 1.0  # in units of the component's time

    def given(self, _port: Port, value: Any) -> Any:
        """Return a value for a port of the component."""
        return value

    def read(self, _port: Port, value: Any) -> Any:
        """Return the value that a port of the component shows."""
        return value


@dataclass(frozen=True)
class InOtherUnits(AsPorts):
    """Values in units other than SI."""

    second: float = OTHER_UNITS["s"]

    def factor(self, unit: str) -> float:
        """Return the number in these units of one of a unit in SI."""
        exponents = unit_of(unit).exponents
        assert exponents is not None, unit
        return math.prod(OTHER_UNITS[base] ** power for base, power in exponents.items())

    def given(self, port: Port, value: Any) -> Any:
        return self.factor(port.unit) * np.asarray(value) if port.kind == "real" else value

    def read(self, port: Port, value: Any) -> Any:
        return value / self.factor(port.unit)


@dataclass(frozen=True)
class InOtherOrder(AsPorts):
    """Wheels and thrusters in another order, and body axes that are named in another order, y first."""

    wheels: tuple[int, ...] = (3, 0, 5, 1, 4, 2)
    thrusters: tuple[int, ...] = (4, 11, 7, 0, 9, 2, 1, 10, 5, 3, 8, 6)
    axes: tuple[int, ...] = (1, 2, 0)

    def _places(self, port: Port) -> NDArray[np.intp]:
        """Return where each element of a port of the component stands in the given one."""
        rows = {WHEELS: self.wheels, COUNT: self.thrusters}
        if port.length == 3:
            return np.array(range(3) if port.frame == "inertial" else self.axes)
        if port.length == 9:
            return np.add.outer(3 * np.array(self.axes), self.axes).ravel()
        if port.length in rows:
            return np.array(rows[port.length])
        if port.length > 1 and port.unit != "s" and port.kind == "real":  # rows of three
            return np.add.outer(3 * np.array(rows.get(port.length // 3, range(port.length // 3))), self.axes).ravel()
        return np.arange(port.length)

    def given(self, port: Port, value: Any) -> Any:
        if port.name == "attitude.quaternion":
            renamed = Rotation.from_matrix(np.eye(3)[list(self.axes)])
            return (Rotation.from_quat(value) * renamed.inv()).as_quat()
        return np.broadcast_to(value, port.length)[self._places(port)] if port.size else value

    def read(self, port: Port, value: Any) -> Any:
        found = np.empty(port.length)
        found[self._places(port)] = value
        return found


AS_PORTS = AsPorts()


def fly(
    instance: Instance, component: str, settings: Values, form: AsPorts = AS_PORTS, steps: int | None = None
) -> Run:
    """Return all outputs after each step; settings and inputs are given to the component in a form, and read in it."""
    table, step = instance.table, STEP[component]

    def put(name: str, value: Any) -> None:
        instance.set(name, form.given(table[name], value))

    outputs = [port for port in table if port.causality == "output"]
    for name, value in {
        **{port.name: port.starts for port in table if port.causality != "output"},
        **BASE[component],
        **settings,
    }.items():
        put(name, value)
    instance.start()
    views = {port.name: instance.view(port.name) for port in outputs}
    rows: dict[str, list[Any]] = {name: [] for name in views}
    wheels = np.array(STARTING_SPEED)
    for k in range(steps or STEPS[component]):
        if component == "mission":
            wheels += step * form.read(table["wheel.torque"], np.array(views["wheel.torque"])) / INERTIA
            if k > SEIZES:
                wheels[0] *= 0.8
        for name, value in INPUTS[component](k, wheels).items():
            put(name, value)
        if k == 0:
            instance.first_step(step * form.second)
        instance.advance(k * step * form.second, step * form.second)
        for name, values in views.items():
            rows[name].append(np.array(values))
    shown = {port: np.reshape(np.array(rows[port.name], np.float64), (-1, port.length)) for port in outputs}
    return {port.name: np.array([form.read(port, row) for row in values]) for port, values in shown.items()}


def _environment_inputs(k: int, _wheels: object) -> Values:
    """Return an attitude that turns."""
    turned = np.array([0.3 + 0.1 * k, -0.2, 0.1 * k, 1.0])
    return {"attitude.quaternion": turned / np.linalg.norm(turned)}


def _thruster_inputs(k: int, _wheels: object) -> Values:
    """Return commands of less than the minimum impulse, of a part of a period, and of more than the maximum."""
    return {
        "thrust.command": np.linspace(0.0, 0.12, COUNT) + 0.002 * k,
        "disturbance.force": (1e-3 * k, 2e-3, -1e-3),
        "disturbance.torque": (1e-2, 1e-3 * k, -2e-2),
    }


def _manager_inputs(k: int, wheels: NDArray[np.float64]) -> Values:
    """Return what controller and sensors would give in two slews, an off-loading, a failure and an outage."""
    return {
        "demanded.wheel.torque": (5.0 if k < 12 else 0.05) * np.sin(0.3 * k + np.arange(WHEELS)),
        "encoder.speed": wheels,
        "estimate.mrp": (2.2e-4 - 2e-6 * k, 3e-5, -1e-5),
        "reference.mrp": (1e-5, 0.0, 2e-5),
        "reference.rate": (0.0, 1e-4 if 14 < k < 22 or 75 < k < 80 else 0.0, 0.0),
        "star_tracker.valid": k % 4 == 0 and k < 84,
    }


INPUTS: dict[str, Callable[[int, NDArray[np.float64]], Values]] = {
    "environment": _environment_inputs,
    "thrusters": _thruster_inputs,
    "mission": _manager_inputs,
}


def without_effect(make: Callable[[str], Instance], component: str) -> list[str]:
    """Return the parameters of a component whose change changes no output; each is changed in turn."""
    runs: dict[str, Run] = {}
    silent = []
    for port in make(component).table:
        if port.causality != "parameter":
            continue
        settings = NEEDS[component].get(port.name, {})
        key = repr(settings)
        if key not in runs:
            runs[key] = fly(make(component), component, settings)
        there = fly(make(component), component, {**settings, port.name: other_value(component, port, settings)})
        if all(np.array_equal(there[name], values) for name, values in runs[key].items()):
            silent.append(port.name)
    return silent


def differences(make: Callable[[str], Instance], component: str, form: AsPorts, limit: float = 0.0) -> dict[str, float]:
    """Return outputs that differ by more than a limit of their largest value where numbers are given in a form."""
    by_order = component == "thrusters" and isinstance(form, InOtherOrder)
    settings = {"thrust.noise": 0.0} if by_order else {}  # which is drawn for one thruster after the other
    expected, found = fly(make(component), component, settings), fly(make(component), component, settings, form)
    worst = {
        name: float(np.max(np.abs(found[name] - values)) / max(1e-30, np.max(np.abs(values))))
        for name, values in expected.items()
    }
    return {name: value for name, value in worst.items() if not value <= limit}  # not a number differs, too
