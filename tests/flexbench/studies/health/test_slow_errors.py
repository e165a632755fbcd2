"""Judging estimated torque and biases: truth drawn again, covariance of the filter, bounds, refusals."""

from types import SimpleNamespace

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from flexbench.studies.health.analysis import analyse
from flexbench.studies.health.replay import Replay
from flexbench.studies.health.slow_errors import SlowErrors, slow_covariance, slow_errors, true_biases
from flexbench.studies.health.statistics import normalised
from flexbench.studies.health.study import _torque_source
from flexsat.closed_loop import port_values
from flexsat.ports import sensors as interface
from flexsat.runtime import sensors
from lockstep import Connection, InputError

STEP = 1e-3  # s, of the sensors


@pytest.fixture(scope="module")
def design(built):
    return built["centralised"].corrected


def test_the_biases_that_walked_are_drawn_again_beside_a_drift_of_the_star_tracker(design):
    given = {"seed": 7, "gyro.bias_deviation": 5e-6, "gyro.bias_walk": 1e-6, "gyro.bias[2]": 1e-5,
             "star_tracker.low_frequency_error": 1e-6, "star_tracker.low_frequency_time": 50.0}  # fmt: skip
    values = port_values("sensors", interface.ports(design.sensors), given)
    prepared = sensors.prepare(interface.parameters(design.sensors, values.__getitem__, STEP))
    state = sensors.init(prepared)
    inputs = sensors.SensorInputs(np.array([0.0, 0.0, 0.0, 1.0]), np.zeros(prepared.gyros),
                                  np.zeros(prepared.accelerometers), np.ones(6), np.zeros(6))  # fmt: skip
    flown = []
    for tick in range(round(0.35 / STEP)):  # three samples of the star tracker after the first
        sensors.step(prepared, state, inputs)
        if tick % prepared.fast_steps == 0:
            flown.append(state.errors.gyro_bias.copy())
    found = true_biases(design, given, len(flown))

    assert_array_equal(found, flown)
    assert np.ptp(found, axis=0).min() > 1e-8
    assert_array_equal(true_biases(design, {"seed": 7}, 3), 0.0)


def replay_of(known, choice, factor=1.0, end=None):
    """Return a run whose errors have the covariance of filter and vibration, long after the filter has settled."""
    start = 8.0 * known.time_constant
    last = start + 40.0 if end is None else end
    time = np.concatenate([np.linspace(0.0, 0.99 * start, 100), np.linspace(start, last, 4000)])
    used = np.diag(known.covariance) > 0.0
    part = (known.covariance + known.vibration)[np.ix_(used, used)]
    error = np.zeros((len(time), len(used)))
    white = np.random.default_rng(5).standard_normal((len(time), used.sum()))
    error[:, used] = factor * white @ np.linalg.cholesky(part).T
    error[time < start] = 1.0  # what is not judged may be anything
    return time, SlowErrors(error=error, choice=choice)


@pytest.mark.parametrize("choice", [(True, False), (False, True), (True, True)])
def test_errors_of_the_filters_covariance_are_consistent_and_twice_as_large_ones_optimistic(design, choice):
    known = slow_covariance(design, True, choice)
    model = design.model
    size = len(design.fine.c)
    states = model.index.unfiltered

    def judged(factor, end=None):
        time, slow = replay_of(known, choice, factor, end)
        run = Replay(time=time, phase=np.arange(len(time)) % 20, innovation=np.ones((len(time), size)) + 1e-3
                     * np.random.default_rng(1).standard_normal((len(time), size)),
                     error=np.ones((len(time), states)), fine=True, slow=slow)  # fmt: skip
        return analyse({1: run}, design)

    found = judged(1.0).error
    names = [name for name, chosen in zip(("external torque", "gyro biases"), choice, strict=True) if chosen]
    assert [name for name in found if name in ("external torque", "gyro biases")] == names
    for name in names:
        assert found[name].value == pytest.approx(1.0, abs=0.05)  # four deviations of 12,000
        assert found[name].assessment == "consistent"
        assert judged(2.0).error[name].value == pytest.approx(4.0 * found[name].value)
        assert judged(2.0).error[name].assessment.startswith("optimistic")
    short = judged(1.0, end=8.0 * known.time_constant + 1.0)
    assert not {"external torque", "gyro biases"} & set(short.error)
    assert short.needs == pytest.approx(8.0 * known.time_constant + 2.0)


def test_vibration_is_counted_in_single_rows_and_left_out_of_means_over_a_second(design):
    """Biases off by one draw, and a vibration at the wheels' speeds that the filter takes for rate."""
    known = slow_covariance(design, True, (False, True))
    time, slow = replay_of(known, (False, True))
    judged = time >= 8.0 * known.time_constant
    inside, shaken = known.covariance[3:, 3:], (known.covariance + known.vibration)[3:, 3:]
    slow.error[judged] = slow.error[-1]
    still = float(np.sum(normalised(slow.error[-1:, 3:], inside) ** 2)) / len(inside)
    # the direction in which the vibration is largest, at 4 Hz
    vibration = np.zeros_like(slow.error)
    vibration[:, 3:] = np.outer(np.sin(2.0 * np.pi * 4.0 * time), np.sqrt(2.0 * np.diag(known.vibration)[3:]))
    shaken_error = slow.error + vibration

    def judge(wheels_shake):
        run = Replay(time=time, phase=np.arange(len(time)) % 20, fine=True,
                     error=np.ones((len(time), design.model.index.unfiltered)),
                     innovation=np.random.default_rng(1).standard_normal((len(time), len(design.fine.c))),
                     slow=SlowErrors(error=shaken_error, choice=(False, True), shaken=wheels_shake))  # fmt: skip
        return analyse({1: run}, design).error

    counted, ignored = judge(True), judge(False)
    each = shaken_error[judged, 3:]
    for found, covariance in ((counted, shaken), (ignored, inside)):
        expected = float(np.mean(np.sum(normalised(each, covariance) ** 2, axis=1))) / len(inside)
        assert found["gyro biases"].value == pytest.approx(expected)
        assert found["gyro biases, 1 s"].value == pytest.approx(still, rel=2e-3)  # rows are 0.01 s apart but for 1/4000
    assert ignored["gyro biases"].value > counted["gyro biases"].value + 0.4


def test_the_torque_is_as_slow_as_its_walk_says(design):
    """A torque that walks, on a body whose acceleration has white noise: the ratio of both is the time constant."""
    weights = design.config.weights
    ratio = weights.torque_noise / weights.torque_walk  # 170 s
    assert 0.5 * ratio < slow_covariance(design, True, (True, False)).time_constant < 2.0 * ratio


def test_errors_are_estimates_less_truth_of_what_is_estimated():
    estimate = np.array([[1.0, 2.0, 3.0, 4.0, 5.0]])
    found = slow_errors(estimate, np.array([[0.5, 0.5, 0.5]]), np.array([[1.0, 1.0]]), (False, True))
    assert_allclose(found.error, [[0.0, 0.0, 0.0, 3.0, 4.0]])


def connection(source, output, target, name):
    return Connection(from_component=source, output=output, to_component=target, input=name, delay=0)


def test_a_controller_behind_a_mission_manager_is_refused_and_the_source_of_the_torque_is_named(tmp_path):
    torque = connection("environment", "external.torque[1]", "plant", "external.torque[1]")
    system = SimpleNamespace(name="m", connections=(torque, connection("sensors", "x", "controller", "x")))
    assert _torque_source(system) == "environment.external.torque"
    assert _torque_source(SimpleNamespace(name="m", connections=())) is None
    header = tmp_path / "torque.csv"
    header.write_text("time,plant.external.torque[1]\n0,1\n", encoding="utf-8")
    assert _torque_source(SimpleNamespace(name="m", connections=()), [header]) == "plant.external.torque"
    header.write_text("time,plant.external.force[1]\n0,1\n", encoding="utf-8")
    assert _torque_source(SimpleNamespace(name="m", connections=()), [header]) is None
    system.connections += (connection("mission", "shown.encoder.speed[1]", "controller", "encoder.speed[1]"),)
    with pytest.raises(InputError, match=r"controller.encoder.speed\[1\] comes from mission; .* environment.ssd"):
        _torque_source(system)
