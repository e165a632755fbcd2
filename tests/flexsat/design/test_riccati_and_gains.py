"""Riccati recursions by doubling, the regulator and the Kalman filter, against other solvers and plain recursions."""

from dataclasses import replace
from functools import reduce

import control
import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.linalg import expm, solve_discrete_are, solve_discrete_lyapunov

from flexsat.design.chain import build_design
from flexsat.design.estimator import design_estimator, measurement_noise, process_covariance
from flexsat.design.regulator import design_regulator
from flexsat.design.riccati import RiccatiStep, steady_state
from flexsat.variants import AS_PUBLISHED


def random_step(rng: np.random.Generator, n: int = 5) -> RiccatiStep:
    b, c = rng.standard_normal((n, 2)), rng.standard_normal((2, n))
    return RiccatiStep(a=rng.standard_normal((n, n)) / np.sqrt(n), g=c.T @ c, h=b @ b.T)


def plain(a, g, h, p):
    """Return g + a P (I + h P)^-1 a^T, by the textbook's inverse."""
    return g + a @ p @ np.linalg.inv(np.eye(len(p)) + h @ p) @ a.T


def test_a_step_is_the_recursion():
    rng = np.random.default_rng(1)
    step, root = random_step(rng), rng.standard_normal((5, 5))
    p = root @ root.T
    assert_allclose(step.apply(p), plain(step.a, step.g, step.h, p), rtol=1e-11)  # rounding times condition, 1e3


def test_composition_is_one_step_after_the_other():
    rng = np.random.default_rng(2)
    first, second, third, root = random_step(rng), random_step(rng), random_step(rng), rng.standard_normal((5, 5))
    p = root @ root.T
    both, all_three = first.then(second), first.then(second).then(third)
    assert_allclose(both.apply(p), second.apply(first.apply(p)), rtol=1e-10)  # rounding times condition
    assert_allclose(all_three.apply(p), third.apply(second.apply(first.apply(p))), rtol=1e-10)
    assert_allclose(all_three.apply(p), first.then(second.then(third)).apply(p), rtol=1e-10)  # associative


def test_steady_state_is_where_plain_steps_end():
    steps = [random_step(np.random.default_rng(seed)) for seed in (3, 4, 5)]
    p = np.eye(5)
    for _ in range(300):
        for step in steps:
            p = plain(step.a, step.g, step.h, p)
    assert_allclose(steady_state(steps), p, rtol=1e-9, atol=1e-9 * np.abs(p).max())  # stops at 1e-12 of the norm


def test_steady_state_against_two_solvers_of_algebraic_equations():
    rng = np.random.default_rng(6)
    a, b = rng.standard_normal((6, 6)), rng.standard_normal((6, 2))
    q, r = np.diag(rng.uniform(0.5, 2.0, 6)), np.diag([0.5, 2.0])
    found = steady_state([RiccatiStep(a=a.T, g=q, h=b @ np.linalg.solve(r, b.T))])
    # all three are backward stable; the condition of this equation is some 1e3
    assert_allclose(found, solve_discrete_are(a, b, q, r), rtol=1e-9, atol=1e-9 * np.abs(found).max())
    slycot, _, _ = control.dare(a, b, q, r, method="slycot")
    assert_allclose(found, slycot, rtol=1e-9, atol=1e-9 * np.abs(found).max())


@pytest.mark.parametrize("growth", [1.0, 1.1])
def test_undetectable_state_is_refused(growth):
    """Noise drives a state that no measurement shows: its variance grows without bound."""
    blind = RiccatiStep(a=np.diag([0.5, growth]), g=np.eye(2), h=np.diag([1.0, 0.0]))
    with (
        np.errstate(over="ignore", invalid="ignore"),
        pytest.raises(ValueError, match="not stabilisable or not detectable"),
    ):
        steady_state([blind])


def test_doubling_is_plain_iteration_on_the_real_regulator(design):
    """Ten doublings are 1024 steps from P = 0."""
    a, b, q, r = regulator_problem(design)
    step = RiccatiStep(a=a.T, g=q, h=b @ np.linalg.solve(r, b.T))
    doubled = reduce(lambda done, _: done.then(done), range(10), step)
    p = np.zeros_like(q)
    for _ in range(1024):
        gain = np.linalg.solve(r + b.T @ p @ b, b.T @ p @ a)
        p = q + a.T @ p @ (a - b @ gain)
        p = 0.5 * (p + p.T)
    scale = np.sqrt(np.outer(np.diag(p), np.diag(p)))  # states of very different size: compare as correlations
    assert np.abs((doubled.g - p) / scale).max() < 1e-8  # 1024 steps of rounding, and weights from 1e-2 to 1e8


def regulator_problem(design):
    """Return a, b, q, r of the regulator on its subspace, sampled by SciPy's exponential."""
    regulator, n = design.regulator, design.model.index.unfiltered
    a, b = design.model.a[:n, :n], design.model.b_torque[:n]
    block = np.zeros((n + b.shape[1],) * 2)
    block[:n, :n], block[:n, n:] = a, b
    sampled = expm(block * design.config.rates.controller)[:n]
    basis = regulator.basis
    return basis.T @ sampled[:, :n] @ basis, basis.T @ sampled[:, n:], regulator.state_weight, regulator.torque_weight


def test_regulator_is_stable_and_cannot_be_improved(design):
    """Policy iteration (Hewer 1971): the cost of the gain by a Lyapunov equation, the best gain for that cost."""
    a, b, q, r = regulator_problem(design)
    gain = design.regulator.gain @ design.regulator.basis
    closed = a - b @ gain
    assert np.abs(np.linalg.eigvals(closed)).max() < 1.0
    cost = solve_discrete_lyapunov(closed.T, q + gain.T @ r @ gain)
    improved = np.linalg.solve(r + b.T @ cost @ b, b.T @ cost @ a)
    # states measured by what they cost; the slowest pole, 1 - 8e-5, loses four digits of the Lyapunov solution, and
    # the cost's range as many again: 6e-9 seen
    cost_of_one = np.sqrt(np.diag(cost))
    assert (np.abs(improved - gain) / cost_of_one).max() < 1e-7 * (np.abs(gain) / cost_of_one).max()


def test_regulator_gain_agrees_with_the_doubling_solver(design):
    """python-control orders a Schur form, doubling composes steps: they share no operation."""
    a, b, q, r = regulator_problem(design)
    cost = steady_state([RiccatiStep(a=a.T, g=q, h=b @ np.linalg.solve(r, b.T))])
    expected = np.linalg.solve(r + b.T @ cost @ b, b.T @ cost @ a)
    gain = design.regulator.gain @ design.regulator.basis
    cost_of_one = np.sqrt(np.diag(cost))
    # states measured by what they cost: 4e-10 seen; without the step of policy iteration 7e-8
    assert (np.abs(gain - expected) / cost_of_one).max() < 1e-8 * (np.abs(expected) / cost_of_one).max()


def test_where_scipy_cannot_order_the_eigenvalues_doubling_gives_the_same_gain(centralised, monkeypatch):
    """It fails so on some processors, with modes up to 60 Hz in the design; both gains are refined to 12 digits."""
    config, period = centralised.config, centralised.controller.period
    known = (centralised.spacecraft, centralised.model, config.weights, period)
    usual = design_regulator(*known)

    def fails(*_, **__):
        raise ValueError("Reordering of (A, B) failed")

    monkeypatch.setattr(control, "dlqr", fails)
    found = design_regulator(*known)
    assert_allclose(found.gain, usual.gain, rtol=0.0, atol=1e-11 * np.abs(usual.gain).max())
    with pytest.raises(ValueError, match=r"no stabilising gain with Weights\(.*mrp=0\.0"):
        design_regulator(*known[:2], replace(config.weights, mrp=0.0), period)


@pytest.mark.parametrize("weight", ["mrp", "null_wheel_speed"])
def test_zero_weight_of_an_integrating_state_is_refused(centralised, weight):
    """Attitude and null-space wheel speed keep their value without control: their weight must be positive."""
    weights = replace(centralised.config.weights, **{weight: 0.0})
    with pytest.raises(ValueError, match=rf"no stabilising gain with Weights\(.*{weight}=0\.0.*must be > 0"):
        design_regulator(centralised.spacecraft, centralised.model, weights, 0.005)


def test_regulator_leaves_the_net_wheel_momentum_alone(design):
    """It feeds back no wheel speed but the null space's."""
    axis = design.spacecraft.wheels.axis
    speeds = design.model.index.wheel_speed
    feedback = design.regulator.gain[:, speeds]
    assert_allclose(feedback @ axis, 0.0, atol=1e-12 * np.abs(feedback).max())  # rounding of orthogonal vectors


def test_regulator_weights(design):
    weights, w = design.config.weights, design.spacecraft.frequency
    scale = 5.5 if design.config.name == "centralised" else 1.0
    n, m = design.plant.wheels, design.plant.modes
    expected = np.concatenate(
        [np.full(3, 1e7), 1e8 / w**2, np.full(3, 1e3), 10.0 / w**2, np.full(n - 3, 0.1 / scale)]
    )  # PHYSICS section 6
    assert_allclose(np.diag(design.regulator.state_weight), expected, rtol=1e-14)
    assert_allclose(design.regulator.torque_weight, 0.1 / scale * np.eye(n), rtol=1e-14)
    assert weights.process_noise == 1e-12
    assert design.regulator.gain.shape == (n, 6 + 2 * m + n)


@pytest.fixture(scope="session")
def variant(request, design):
    """Return the design of a configuration: corrected, or with the errors of the published release."""
    return build_design(design.config, AS_PUBLISHED) if request.param == "as published" else design


def kalman_problem(design, star_tracker):
    """Return a, q, the variances, written from PHYSICS sections 6 and 7 with SciPy's exponential."""
    model, wheel, noise = design.model, design.config.wheel, design.config.noise
    n, wheels = model.index.size, model.index.wheels
    inputs = np.hstack([model.b_torque, model.b_jitter])
    block = np.zeros((n + inputs.shape[1],) * 2)
    block[:n, :n], block[:n, n:] = model.a, inputs
    sampled = expm(block * 0.005)[:n]
    torque, jitter = sampled[:, n : n + wheels], sampled[:, n + wheels :]
    if design.variant == AS_PUBLISHED:
        # the release: inputs are all torques, then (force a, force b, torque a, torque b) of each wheel in turn; of
        # these it takes the first 4 n, with the deviations of the jitter
        by_wheel = [jitter[:, kind * wheels + i] for i in range(wheels) for kind in range(4)]
        columns = np.column_stack([torque, *by_wheel])[:, : 4 * wheels]
        broadband = [wheel.broadband_force, wheel.broadband_force, wheel.broadband_torque, wheel.broadband_torque]
        spread = columns * np.tile(broadband, wheels)
    else:
        spread = jitter * np.repeat([wheel.broadband_force, wheel.broadband_torque], 2 * wheels)
    corner = 2.0 * np.pi * 80.0
    base = np.full(n, 1e-12)
    base[model.index.filter_output] *= corner**4  # the release's companion coordinates: see estimator._noise_scale
    base[model.index.filter_rate] *= corner**2
    deviation = [noise.gyro] * 23 + [noise.accelerometer] * 13 + [noise.encoder] * wheels + [star_tracker] * 3
    return sampled[:, :n], np.diag(base) + spread @ spread.T, np.array(deviation) ** 2


@pytest.mark.parametrize("variant", ["corrected", "as published"], indirect=True)
@pytest.mark.parametrize("sensor", ["coarse", "fine"])
def test_kalman_filter_repeats_over_the_star_trackers_period(variant, sensor):
    """One period of the plain filter, gain by gain, from the steady covariance, comes back to it (Joseph's form).

    The variants differ in the columns through which the broadband noise enters: neither passes with the other's.
    """
    estimator, noise = getattr(variant, sensor), variant.config.noise
    a, q, variance = kalman_problem(variant, getattr(noise, f"star_tracker_{sensor}"))
    p, c, identity = estimator.covariance, variant.model.c, np.eye(len(a))
    assert estimator.gain.shape == (20, *c.T.shape)
    transition = identity
    for phase in range(20):
        rows = len(c) if phase == 0 else len(c) - 3
        h, r = c[:rows], np.diag(variance[:rows])
        gain = np.linalg.solve(h @ p @ h.T + r, h @ p).T
        # states in their own deviation, measurements likewise: 2e-10 seen, largest entry .4
        unit = np.sqrt(variance[:rows]) / np.sqrt(np.diag(p))[:, None]
        assert (np.abs(estimator.gain[phase][:, :rows] - gain) * unit).max() < 1e-8, f"phase {phase}"
        correction = identity - gain @ h
        p = correction @ p @ correction.T + gain @ r @ gain.T
        p = a @ p @ a.T + q
        transition = a @ correction @ transition
    deviation = np.sqrt(np.diag(estimator.covariance))
    # the steady state is found to 1e-12 of the largest entry's norm; as correlations of small states, 4e-10 is seen
    assert np.abs((p - estimator.covariance) / np.outer(deviation, deviation)).max() < 1e-8
    assert np.abs(np.linalg.eigvals(transition)).max() < 1.0  # the error dies out: this steady state is the right one


@pytest.mark.parametrize("variant", ["corrected", "as published"], indirect=True)
def test_process_covariance_takes_the_columns_of_its_variant(variant):
    _, expected, _ = kalman_problem(variant, 1.0)
    given = (variant.model, variant.config.wheel_set.broadband, variant.config.weights.process_noise, 0.005)
    scale, slip = np.sqrt(np.diag(expected)), variant.variant == AS_PUBLISHED

    q = process_covariance(*given, slip)

    assert np.abs((q - expected) / np.outer(scale, scale)).max() < 1e-9  # rounding of two exponentials
    other = process_covariance(*given, not slip)
    assert np.abs((other - expected) / np.outer(scale, scale)).max() > 1e-3


def test_star_tracker_counts_in_its_phase_alone(design):
    for estimator in (design.coarse, design.fine):
        assert not estimator.gain[1:, :, -3:].any()
        assert np.abs(estimator.gain[0, :3, -3:]).max() > 1e-6
    finer = np.abs(np.diag(design.fine.gain[0][:3, -3:]))
    assert np.all(finer > np.abs(np.diag(design.coarse.gain[0][:3, -3:])))  # a better sensor is trusted more


def test_variances_stand_in_the_order_of_the_outputs(design):
    noise, n = design.config.noise, design.plant.wheels
    variance = measurement_noise(design.model, noise, 0.5)
    degree = np.pi / 180.0
    expected = [1e-5 * degree] * 23 + [2e-5] * 13 + [3e-4] * n + [0.5] * 3  # PHYSICS section 4
    assert_allclose(variance, np.square(expected), rtol=1e-14)


def test_attitude_without_star_tracker_is_refused(centralised):
    """Gyros alone do not measure the attitude: its variance grows for ever."""
    model = centralised.model
    blind = measurement_noise(model, centralised.config.noise, np.inf)
    with pytest.raises(ValueError, match="not stabilisable or not detectable"):
        design_estimator(model, centralised.config.wheel_set.broadband, blind, 1e-12, 0.005, 20)
