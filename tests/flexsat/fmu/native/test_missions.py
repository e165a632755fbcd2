"""The native FMUs of missions against the Python steppers: outputs, and messages."""

import math
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from flexsat.ports import environment as environment_ports
from flexsat.ports import mission as mission_ports
from flexsat.ports import thrusters as thruster_ports
from flexsat.runtime.missions import environment, manager, thrusters
from flexsat.runtime.rotations import quaternion_from_mrp
from fmus.mission_numbers import MISSION_DATA, values_of
from fmus.mission_runs import STEPS, InOtherOrder, InOtherUnits, differences, without_effect
from fmus.native.twin import Twin

Made = Callable[..., Twin]
PORTS: dict[str, Any] = {"environment": environment_ports, "thrusters": thruster_ports, "mission": mission_ports}
STEP = 5e-3  # s
WRONG: dict[str, tuple[str, dict[str, Any]]] = {
    "orbit.radius must be > 6378137 m": ("environment", {"orbit.radius": 6378137.0}),
    "solar.normal must be a direction": ("environment", {"solar.normal": (0.0, 0.0, 0.0)}),
    "thrust.maximum must be > 0": ("thrusters", {"thrust.maximum": 0.0}),
    "thruster.direction[4] to [6] must be": (
        "thrusters", {"thruster.direction": (0.0, 0.0, 1.0, *[0.0] * 3, *[1.0] * 30)}),
    "thrust.minimum_impulse must be at most": ("thrusters", {"thrust.minimum_impulse": 0.0101}),
    "wheel.axis must be axes": ("mission", {"wheel.axis": (1.0, 0.0, 0.0, 0.0, 1.0, 0.0) * 3}),
    "timeline.time[2] must be >=": ("mission", {"timeline.time": (3.0, *[2.0] * 47), "timeline.action": (2,) * 48}),
    "timeline.rotation[1] to [3] must turn": ("mission", {"timeline.action": (1,) * 48}),
    "solar.specular + solar.diffuse must be at most 1": (
        "environment", {"solar.specular": 0.7, "solar.diffuse": 0.4}),
}  # fmt: skip


@pytest.fixture
def made(compiled: Callable[..., Path]) -> Iterator[Made]:
    """Yield a maker of instances of a component."""
    instances: list[Twin] = []

    def make(component: str, **values: Any) -> Twin:
        ports = PORTS[component].ports(MISSION_DATA)
        instances.append(Twin(compiled("missions", component, ports, {}), ports, **values))
        return instances[-1]

    yield make
    for instance in instances:
        instance.close()


@pytest.mark.parametrize("message", WRONG)
def test_wrong_values_are_refused_alike(made: Made, message: str):
    component, values = WRONG[message]
    given = (values_of(PORTS[component].ports(MISSION_DATA), values), *(() if component == "environment" else (0.1,)))
    with pytest.raises(ValueError, match="must") as python:
        PORTS[component].parameters(*given)
    twin = made(component, **values)
    with pytest.raises(ValueError, match="must") as native:
        twin.start()

    assert str(native.value) == str(python.value)
    assert str(python.value).startswith(message)


def test_the_environment_is_that_of_the_python_stepper(made: Made):
    given: dict[str, Any] = {
        "orbit__radius": 7.1e6, "orbit__node": 0.3, "orbit__inclination": 1.1, "orbit__argument": 2.0,
        "solar__sun_direction": (1.0, 0.3, 0.0), "solar__normal": (0.1, 0.2, 0.9),
        "magnetic__dipole_axis": (0.1, 0.2, 2.0), "constant__torque": (1e-4, 2e-4, 3e-4),
    }  # fmt: skip
    twin = made("environment", **given)
    twin.start()
    values = values_of(environment_ports.ports(MISSION_DATA), given)
    prepared = environment.prepare(environment_ports.parameters(values))
    lit = set()
    for k in range(40):
        quaternion = np.array(quaternion_from_mrp((0.3 * math.sin(k), 0.2 * math.cos(2 * k), 0.1))) * (1.0 + 1e-6)
        twin.set("attitude.quaternion", quaternion)
        twin.advance(150.0 * k, 0.1)
        found = environment.step(prepared, 150.0 * k, quaternion)
        lit.add(found.sunlit)
        for port, values in (("external.force", found.force), ("external.torque", found.torque),
                             ("solar.torque", found.solar_torque), ("magnetic.torque", found.magnetic_torque),
                             ("gravity_gradient.torque", found.gravity_torque), ("magnetic.field", found.field),
                             ("orbit.position", found.position), ("solar.lit", found.sunlit)):  # fmt: skip
            scale = max(1e-30, float(np.abs(values).max()))
            assert_allclose(twin.view(port), values, rtol=0.0, atol=1e-11 * scale)  # rounding alone
    assert lit == {True, False}


def test_thrusters_are_those_of_the_python_stepper(made: Made):
    given: dict[str, Any] = {"seed": 11, "thrust__noise": 0.1, "thrust__lag": 0.03, "thrust__period": 0.04}
    twin = made("thrusters", **given)
    twin.start()
    twin.first_step(STEP)
    prepared = thrusters.prepare(thruster_ports.parameters(values_of(thruster_ports.ports(MISSION_DATA), given), STEP))
    state = thrusters.init(prepared)
    for k in range(200):
        command = 0.06 * (1.0 + np.sin(0.05 * k + np.arange(thruster_ports.COUNT)))
        twin.set("thrust.command", command)
        twin.set("disturbance.torque", (1e-3 * k, 0.0, -1.0))
        if k == 100:
            saved = twin.save()
            twin.restore(saved)
        twin.advance(STEP * k, STEP)
        thrust = thrusters.step(prepared, state, command)
        wrench = prepared.wrench @ thrust

        assert_allclose(twin.view("thrust"), thrust, rtol=1e-13, atol=1e-16)  # rounding alone
        assert_allclose(
            twin.view("external.torque"), wrench[3:] + twin.view("disturbance.torque"), rtol=0.0, atol=1e-15
        )
        assert_allclose(twin.view("thrust.angular_impulse"), state.angular_impulse, rtol=1e-12, atol=1e-15)
        assert twin.view("thrust.pulses").tolist() == state.pulses.tolist()
    assert 0 < state.pulses.min() < 25


def test_the_manager_is_that_of_the_python_stepper(made: Made):
    ports = mission_ports.ports(MISSION_DATA)
    given: dict[str, Any] = {
        "timeline__time": (0.2, 2.0, 4.0, 5.0, 5.5, 6.0, *[0.0] * 42),
        "timeline__action": (1, 2, 3, 1, 4, 2, *[0] * 42),
        "timeline__rotation": (0.01, 0.0, 0.02, *[0.0] * 6, 0.1, *[0.0] * 134),
        "settle__dwell": 0.1, "settle__band": 1e-3, "off_loading__duration": 1.0, "off_loading__automatic": 0.5,
        "thrust__minimum_impulse": 2e-3,
    }  # fmt: skip
    twin = made("mission", **given)
    twin.start()
    twin.first_step(STEP)
    prepared = mission_ports.parameters(values_of(ports, given), STEP)
    state = manager.init(prepared)
    names = ("demanded.wheel.torque", "encoder.speed", "estimate.mrp", "reference.mrp", "reference.rate",
             "reference.torque", "star_tracker.valid")  # fmt: skip
    inputs = manager.ManagerInputs(*(twin.view(name) for name in names[:-1]), twin.view("star_tracker.valid"))
    speed = MISSION_DATA.nominal_speed + 0.1 * np.arange(6)
    modes, fired = set(), 0.0
    for k in range(1800):
        time = STEP * k
        twin.set("demanded.wheel.torque", 5.0 * np.sin(3.0 * time + np.arange(6)))
        speed += STEP * state.torque / MISSION_DATA.wheel_inertia
        speed[0] *= 1.0 if time < 3.0 else 0.98  # seizes
        twin.set("encoder.speed", speed)
        twin.set("estimate.mrp", 1e-4 * np.sin(time + np.arange(3)))
        twin.set("reference.rate", (0.0, 1e-4 if 0.6 < time < 1.2 else 0.0, 0.0))
        twin.set("star_tracker.valid", k % 20 == 0 and not 4.4 < time < 8.0)
        if k == 900:
            twin.restore(twin.save())
        twin.advance(time, STEP)
        manager.step(prepared, state, time, inputs)
        modes.add(state.modes.mode)
        fired += float(state.off_loading.command.sum())
        for port, values in (("wheel.torque", state.torque), ("applied.wheel.torque", state.applied),
                             ("thrust.command", state.off_loading.command), ("momentum", state.momentum),
                             ("command.rotation", state.modes.rotation), ("pointing.error", state.error),
                             ("command.start_time", state.modes.start), ("wheel.status", state.detection.status),
                             ("wheel.residual", state.detection.residual), ("shown.encoder.speed", state.shown_speed),
                             ("mode", state.modes.mode),
                             ("timeline.done", state.modes.next)):  # fmt: skip
            assert_allclose(twin.view(port), values, rtol=1e-11, atol=1e-12, err_msg=f"{port} at {time}")
    assert fired > 0.0
    assert modes == set(range(6))
    assert state.detection.status.tolist() == [2, 0, 0, 0, 0, 0]


@pytest.mark.parametrize("component", STEPS)
def test_every_parameter_changes_a_run(made: Made, component: str):
    """As of the Python components in tests/flexsat/ports/test_every_mission_parameter.py."""
    assert without_effect(made, component) == []


@pytest.mark.parametrize("component", ["thrusters", "mission"])  # the environment's constants of the Earth are in SI
def test_numbers_in_other_units_are_the_same_run(made: Made, component: str):
    assert differences(made, component, InOtherUnits()) == {}


@pytest.mark.parametrize("component", STEPS)
def test_wheels_thrusters_and_axes_in_another_order_are_the_same_run(made: Made, component: str):
    assert differences(made, component, InOtherOrder(), 1e-11) == {}  # sums in another order
