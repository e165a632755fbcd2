"""What is prepared is never written to: runs that share it are independent, bit for bit."""

from dataclasses import fields, is_dataclass

import numpy as np
import pytest

from flexsat.ports import sensors as sensor_ports
from flexsat.runtime import bearing_friction, controller, plant, sensors
from flexsat.runtime.named_state import named_values, restore_values

STEPS = 45  # two star tracker samples of 20 periods each, and more
ABOUT_X = np.array([0.01, 0.0, 0.0])


class PlantRun:
    """A plant under random torques and jitter, one wheel braked."""

    def __init__(self, prepared, seed):
        self.prepared, self.state = prepared, plant.init(prepared)
        self.friction = bearing_friction.prepare(prepared, np.eye(prepared.wheels)[0])
        self.random = np.random.default_rng(seed)

    def step(self, _k):
        inputs = self.random.standard_normal(self.prepared.input_count)
        return plant.step(self.prepared, self.state, inputs, self.friction).flat.copy()


class SensorRun:
    """Sensors of random truths."""

    def __init__(self, prepared, seed):
        self.prepared, self.state = prepared, sensors.init(prepared)
        self.random = np.random.default_rng(seed)

    def step(self, _k):
        p, draw = self.prepared, self.random.standard_normal
        quaternion = draw(4)
        inputs = sensors.SensorInputs(
            quaternion / np.linalg.norm(quaternion),
            draw(p.gyros),
            draw(p.accelerometers),
            draw(p.wheels),
            draw(p.wheels),
        )
        outputs = sensors.step(p, self.state, inputs)
        return np.concatenate([np.ravel(getattr(outputs, item.name)) for item in fields(outputs)])


class ControllerRun:
    """A controller of random measurements in a slew, with delays."""

    def __init__(self, prepared, seed):
        self.prepared, self.state = prepared, controller.init(prepared, ABOUT_X, 0.3)
        self.random = np.random.default_rng(seed)

    def step(self, k):
        p, draw = self.prepared, self.random.standard_normal
        g, n = len(p.c) - 3 - p.wheels, p.wheels
        rows = 1e-6 * draw(g)
        seen = controller.Measurements(
            rows[:23], rows[23:], p.nominal_speed + 1e-3 * draw(n), draw(n), 1e-6 * draw(3), k % 20 == 0
        )
        outputs = controller.step(p, self.state, 5e-3 * k, seen)
        return np.concatenate([getattr(outputs, item.name) for item in fields(outputs)])


@pytest.fixture(params=["plant", "sensors", "controller"])
def component(request, design, quiet_run, flight):
    """Return what is prepared for one component, and a maker of runs of it."""
    if request.param == "plant":
        parameters = quiet_run(design.plant, rate=np.array([1e-3, -2e-3, 3e-3]), torque_limit=0.5)
        return plant.prepare(design.plant, parameters, 1e-3), PlantRun
    if request.param == "sensors":
        values = {port.name: port.start for port in sensor_ports.ports(design.sensors)}
        return sensors.prepare(sensor_ports.parameters(design.sensors, values.__getitem__)), SensorRun
    given = flight(design, feed_forward_jitter=True, measurement_delay=0.006, actuation_delay=0.003)
    return controller.prepare(design.controller, given), ControllerRun


def arrays_of(value, path):
    """Yield every array inside dataclasses, with its path."""
    for item in fields(value):
        inner = getattr(value, item.name)
        if isinstance(inner, np.ndarray):
            yield f"{path}.{item.name}", inner
        elif is_dataclass(inner):
            yield from arrays_of(inner, f"{path}.{item.name}")


def test_alternating_runs_give_what_each_gives_alone(component):
    prepared, kind = component
    alone = []
    for seed in (1, 2):
        single = kind(prepared, seed)
        alone.append([single.step(k) for k in range(STEPS)])
    first, second = kind(prepared, 1), kind(prepared, 2)
    for k in range(STEPS):
        np.testing.assert_array_equal(first.step(k), alone[0][k])
        np.testing.assert_array_equal(second.step(k), alone[1][k])
    assert not np.array_equal(alone[0][-1], alone[1][-1])


def test_two_states_share_no_array_that_is_written(component):
    prepared, kind = component
    first, second = (list(arrays_of(kind(prepared, seed).state, "state")) for seed in (1, 2))
    fixed = list(arrays_of(prepared, "prepared"))
    for name, array in first:
        shared = [other for other, values in second + fixed if np.shares_memory(array, values)]
        assert shared == [], name


def test_prepared_arrays_are_read_only(component):
    prepared, kind = component
    found = list(arrays_of(prepared, "prepared"))
    assert len(found) >= 4
    assert [name for name, array in found if array.flags.writeable] == []
    before = [array.copy() for _, array in found]
    run = kind(prepared, 3)
    for k in range(STEPS):
        run.step(k)
    for (name, array), old in zip(found, before, strict=True):
        np.testing.assert_array_equal(array, old, err_msg=name)


def test_a_restored_state_continues_bitwise(component):
    """In a state with another past: outputs and work arrays are not needed to go on."""
    prepared, kind = component
    run = kind(prepared, 1)
    for k in range(23):
        run.step(k)
    saved, random = named_values(run.state), run.random.bit_generator.state
    expected = [run.step(k) for k in range(23, STEPS)]

    other = kind(prepared, 2)
    for k in range(5):
        other.step(k)
    restore_values(other.state, saved)
    other.random.bit_generator.state = random

    for k, row in zip(range(23, STEPS), expected, strict=True):
        np.testing.assert_array_equal(other.step(k), row)


def test_a_state_of_another_spacecraft_is_refused(centralised, distributed, quiet_run):
    small, large = (plant.init(plant.prepare(d.plant, quiet_run(d.plant), 1e-3)) for d in (centralised, distributed))
    with pytest.raises(ValueError, match=r"^vector is float64 \(95,\) in the saved state, and float64 \(65,\) in this"):
        restore_values(small, named_values(large))
