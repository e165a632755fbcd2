"""Components in hosts that know one rate, or read outputs after they set inputs; as Python classes, without FMUs."""

import math

import numpy as np
import pytest

from flexsat.design.chain import Designs
from flexsat.fmu.build import SHELLS, component_resources
from flexsat.fmu.python.load_matrices import MODEL_FILE
from flexsat.variants import VARIANTS

TICK, PERIOD = 1e-3, 5e-3  # s


@pytest.fixture(scope="module")
def made(centralised, tmp_path_factory):
    """Return a maker of an initialised component with some parameters."""
    folders = {}
    for name in SHELLS:
        folders[name] = tmp_path_factory.mktemp(name)
        designs = Designs(dict.fromkeys(VARIANTS, centralised))
        (folders[name] / MODEL_FILE).write_bytes(component_resources(designs, name)[MODEL_FILE])

    def make(name, start=True, **parameters):
        slave = SHELLS[name](instance_name=name, resources=str(folders[name]))
        for port, value in parameters.items():
            write(slave, port, value)
        if start:
            slave.setup_experiment(0.0)
            slave.enter_initialization_mode()
            slave.exit_initialization_mode()
        return slave

    return make


def references(slave, port):
    return [v.value_reference for v in slave.table.variables if v.port.name == port]


def write(slave, port, *values):
    chosen = references(slave, port)
    getattr(slave, f"set_{slave.table[port].kind}")(chosen, list(values) * (1 if len(values) > 1 else len(chosen)))
    assert reasons(slave) == []


def read(slave, port):
    return getattr(slave, f"get_{slave.table[port].kind}")(references(slave, port))


def outputs(slave):
    return [value for port in slave.table if port.causality == "output" for value in read(slave, port.name)]


def reasons(slave):
    return [message.msg for message in slave.log_queue]


def drive(slave, steps, length, first=0):
    """Step with inputs that move; return the outputs after each step."""
    rows = []
    for k in range(first, first + steps):
        time = round(k * length, 9)
        for number, port in enumerate(slave.table):
            if port.causality == "input" and port.kind == "real" and not port.name.startswith("command"):
                write(slave, port.name, *(1e-3 * math.sin(number + i + time) + s for i, s in enumerate(port.starts)))
        assert slave.do_step(time, length), reasons(slave)
        rows.append(outputs(slave))
    return rows


@pytest.mark.parametrize("step", [TICK, PERIOD])
def test_sensors_take_the_first_step_as_if_it_were_set(made, step):
    assert drive(made("sensors"), 25, step) == drive(made("sensors", step_size=step), 25, step)
    assert made("sensors", start=False).table["step_size"].start == 0.0


def test_a_host_that_subtracts_times_gives_the_same_step(made):
    assert drive(made("sensors"), 1, 1.1 - 1.099) == drive(made("sensors"), 1, TICK)


@pytest.mark.parametrize(
    ("component", "parameters", "step", "reason"),
    [
        ("sensors", {}, 3e-3, "fast_period = 0.005 s must be a whole multiple of the step of 0.003 s"),
        ("sensors", {}, 0.01, "fast_period = 0.005 s must be a whole multiple of the step of 0.01 s"),
        ("sensors", {"step_size": TICK}, PERIOD, "a step of 0.005 s is not accepted; the step is 0.001 s, set by"
                                                 " parameter step_size"),
        ("sensors", {}, 1e-12, "a step of 1e-12 s is not accepted; the shortest is 1e-9 s"),
        ("controller", {}, 3e-3, "a step of 0.003 s is not accepted; the controller samples every 0.005 s, which its"
                                 " gains were designed for: step it with that, or with a whole fraction of it, such as"
                                 " 0.001 s"),
        ("controller", {}, 0.01, "a step of 0.01 s is not accepted; the controller samples every 0.005 s"),
    ],
)  # fmt: skip
def test_a_first_step_that_does_not_fit_is_refused_by_name(made, component, parameters, step, reason):
    slave = made(component, **parameters)

    assert slave.do_step(0.0, step) is False
    (message,) = reasons(slave)
    assert message.startswith(f"doStep at t = 0.0 s: {reason}")


@pytest.mark.parametrize("component", ["sensors", "controller"])
def test_later_steps_are_as_long_as_the_first(made, component):
    slave = made(component)
    drive(slave, 2, TICK)

    assert slave.do_step(2 * TICK, PERIOD) is False
    reason = "a step of 0.005 s is not accepted; the step is 0.001 s, set by the first step"
    assert reasons(slave) == [f"doStep at t = {2 * TICK} s: {reason}"]


def test_a_step_size_below_a_microsecond_is_refused(made):
    slave = made("sensors", step_size=1e-7)

    expected = "exitInitializationMode: step_size must be 0 for that of the first step, or >= 1e-06 s, got 1e-07"
    assert reasons(slave) == [expected]


def test_the_controller_holds_its_outputs_between_its_samples(made):
    slow, fast = made("controller"), made("controller")
    for k in range(4):
        measured = [1e-6 * (k + 1)] * len(references(slow, "gyro.rate"))
        write(slow, "gyro.rate", *measured)
        write(fast, "gyro.rate", *measured)
        assert slow.do_step(k * PERIOD, PERIOD)
        for i in range(5):
            assert fast.do_step(round(k * PERIOD + i * TICK, 9), TICK), reasons(fast)
            assert outputs(fast) == outputs(slow)
            write(fast, "gyro.rate", *(1.0 for _ in measured))  # between its samples nobody reads it
    assert np.any(read(fast, "wheel.torque"))


@pytest.mark.parametrize(("component", "step"), [("sensors", PERIOD), ("controller", TICK)])
def test_a_saved_state_has_the_length_of_the_steps_and_the_place_between_samples(made, component, step):
    slave = made(component)
    drive(slave, 7, step)
    state = slave._get_fmu_state()
    rest = drive(slave, 8, step, first=7)
    other = made(component, start=False)
    other._set_fmu_state(state)

    assert drive(other, 8, step, first=7) == rest
    assert other.do_step(15 * step, 2e-3) is False
    assert f"the step is {step} s, set by the first step" in reasons(other)[0]
    begun = made(component)
    before = begun._get_fmu_state()
    drive(begun, 1, step)
    begun._set_fmu_state(before)  # from before the first step: another may be chosen
    drive(begun, 1, 2.5e-3)


def test_sensors_that_nobody_feeds_at_first_measure_the_nominal_wheel_speed(made, centralised):
    sensors = made("sensors", seed=1)
    assert sensors.do_step(0.0, TICK)

    nominal = centralised.sensors.nominal_speed
    assert read(sensors, "wheel.speed") == nominal.tolist()
    error = np.abs(np.array(read(sensors, "encoder.speed")) - nominal)
    assert error.max() < 6.0 * centralised.sensors.encoder_noise  # of a normal sample of six


def acceleration_of_inputs(plant):
    """Return the accelerations per unit of each input, (k, inputs)."""
    return plant.observed[-plant.accelerometers :, -plant.load_count :] @ plant.load_of_input


def test_accelerations_follow_inputs_that_are_set_without_a_step(made):
    plant, twin = made("plant"), made("plant")
    drive(plant, 3, TICK)
    drive(twin, 3, TICK)
    change = 0.05 * np.arange(1.0, 1.0 + plant._plant.wheels)  # equal ones would cancel
    torque, held = read(plant, "wheel.torque"), outputs(plant)
    quiet, turned = (
        np.array(read(plant, "accelerometer_site.acceleration")),
        [x + d for x, d in zip(torque, change, strict=True)],
    )
    write(plant, "wheel.torque", *turned)
    now = np.array(read(plant, "accelerometer_site.acceleration"))
    stepper = plant._plant
    jump = acceleration_of_inputs(stepper)[:, : stepper.wheels] @ change

    np.testing.assert_allclose(now - quiet, jump, atol=1e-15 * np.abs(now).max() + 1e-16, rtol=1e-12)
    assert np.abs(jump).max() > 1e-5
    write(plant, "wheel.torque", *torque)
    assert outputs(plant) == held  # bitwise: nothing else has changed
    write(plant, "wheel.torque", *turned)
    state = plant._get_fmu_state()
    plant._set_fmu_state(state)
    assert read(plant, "accelerometer_site.acceleration") == now.tolist()
    write(twin, "wheel.torque", *turned)
    for one in (plant, twin):  # read before the step or not
        assert one.do_step(3 * TICK, TICK)
    assert outputs(plant) == outputs(twin)


def test_accelerations_at_the_start_are_those_with_the_inputs_of_the_start(made):
    plant = made("plant", start=False)
    write(plant, "external.force", 0.0, 0.0, 42.0)
    plant.setup_experiment(0.0)
    plant.enter_initialization_mode()
    early = read(plant, "accelerometer_site.acceleration")
    plant.exit_initialization_mode()

    assert read(plant, "accelerometer_site.acceleration") == early
    column = acceleration_of_inputs(plant._plant)[:, plant._plant.input_count - 4]  # of the external force along z
    np.testing.assert_allclose(early, 42.0 * column, atol=1e-12)  # at rest; the gyroscopic terms are zero
    assert early[2] > 42.0 / 4200.0  # at the bus, which the modes leave lighter than the whole
    index = {v.name: v.index for v in plant.table.variables}
    first = next(v for v in plant.table.variables if v.name == "accelerometer_site.acceleration[1]")
    assert index["external.force[3]"] in plant.table.dependencies(first, initial=True)


def test_a_branch_of_the_sensors_has_the_noise_of_the_seed_that_is_set(made):
    sensors = made("sensors", seed=1)
    drive(sensors, 5, TICK)
    state = sensors._get_fmu_state()
    went_on = drive(sensors, 10, TICK, first=5)
    branches = []
    for seed in (2, 3, 2):
        sensors._set_fmu_state(state)
        write(sensors, "seed", seed)
        branches.append(drive(sensors, 10, TICK, first=5))
    assert branches[0] == branches[2]
    assert branches[0] != branches[1]
    assert branches[0] != went_on
    sensors._set_fmu_state(state)
    assert read(sensors, "seed") == [1]
    assert drive(sensors, 10, TICK, first=5) == went_on
