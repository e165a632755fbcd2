"""Margins of loops: closed forms, python-control, plain simulation, and the delay margins of record."""

from dataclasses import replace
from pathlib import Path

import control
import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.sparse import csc_array

from flexbench.studies.margins.analysis import analyse, body_loops
from flexbench.studies.margins.designed_loop import Delays, DesignedLoop
from flexbench.studies.margins.interpolation import SPLIT, densified
from flexbench.studies.margins.periodic_loop import PeriodicLoop, Phase, loop_of_sensitivity
from flexbench.studies.margins.response import delayed_hold, disk_margins, loop_margins
from flexbench.studies.margins.stability import delay_margin, stability_margins
from flexsat.description.built_in import CONFIGURATIONS, configuration
from flexsat.design import chain
from flexsat.design.chain import build_design
from flexsat.spacecraft import assembly as spacecraft
from flexsat.spacecraft.variation import with_modes
from flexsat.structure import modes as structure
from flexsat.structure.kirchhoff_plate import assemble
from flexsat.structure.mesh import Mesh, polar
from flexsat.variants import AS_PUBLISHED

PERIOD = 0.1  # s, of the small loops
DATA = Path(__file__).parents[5] / "shared" / "data" / "cachim_antenna_fem.npz"


def time_invariant(system):
    """Return a discrete python-control system without feedthrough as a loop."""
    phase = Phase(a=system.A, c=system.C)
    return PeriodicLoop(first=phase, rest=phase, b=system.B, steps=1, period=system.dt)


def small_plant():
    """Return a lightly damped mode on an integrator, sampled."""
    s = control.tf("s")
    plant = control.ss(0.8 / s + 0.15 * s / (s**2 + 0.06 * s + 9.0)) * control.ss(6.0 / (s + 6.0))
    return control.sample_system(plant, PERIOD, method="zoh")


@pytest.fixture(scope="module")
def designs():
    """Return the published designs, each with a plant of the modes that it knows."""
    return {name: build_design(with_modes(configuration(name, "published"), 25)) for name in CONFIGURATIONS}


# Small loops


def test_complementary_sensitivity_is_that_of_python_control():
    plant = small_plant()
    frequency = np.geomspace(0.01, 4.9, 40)
    found = time_invariant(plant).complementary_sensitivity(frequency)[:, 0, 0]
    reference = control.feedback(plant, 1)(np.exp(2j * np.pi * frequency * PERIOD))
    assert_allclose(found, reference, rtol=1e-9)  # rounding, near a resonance


def test_margins_are_those_of_python_control():
    plant = small_plant()
    frequency = np.geomspace(0.01, 4.9, 4000)  # dense: a crossing is then good to 1e-5
    omega = 2.0 * np.pi * frequency
    loop = plant(np.exp(1j * omega * PERIOD))
    # its polynomials lose digits on a sampled plant, and its own grid is coarse
    response = control.FrequencyResponseData(loop, omega, smooth=True)
    gain, phase, _, gain_at, phase_at, _ = control.stability_margins(response)
    found = loop_margins(frequency, loop)
    assert found.gain_up == pytest.approx(gain, rel=1e-4)
    assert found.gain_up_at == pytest.approx(gain_at / (2.0 * np.pi), rel=1e-4)
    assert found.phase == pytest.approx(phase, rel=1e-4)
    assert found.phase_at == pytest.approx(phase_at / (2.0 * np.pi), rel=1e-4)
    assert found.unresolved == ()
    disk, _, _ = control.disk_margins(control.ss(plant), omega, skew=0.0)
    assert found.disk == pytest.approx(disk, rel=1e-6)


def test_the_loci_of_two_channels_have_the_margins_of_the_nearer_one():
    plant = small_plant()
    frequency = np.geomspace(0.01, 4.9, 4000)
    loop = plant(np.exp(2j * np.pi * frequency * PERIOD))
    mixed = np.array([[2.0, 1.0], [0.5, 3.0]])
    diagonal = np.einsum("f,ij->fij", loop, np.diag([1.0, 0.3]))
    both = mixed @ diagonal @ np.linalg.inv(mixed)
    one, together = loop_margins(frequency, loop), loop_margins(frequency, both)
    for name in ("gain_up", "phase", "delay"):
        assert getattr(together, name) == pytest.approx(getattr(one, name), rel=1e-9)
    assert together.disk <= one.disk * (1.0 + 1e-9)  # it allows for any coupling
    assert_allclose(loop_of_sensitivity(both @ np.linalg.inv(np.eye(2) + both)), both, rtol=1e-8)


def test_exact_margins_of_a_sampled_integrator():
    # x+ = x + k h u: one pole, at 1 - k h, reaches -1 at k h = 2
    gain = 0.4
    integrator = control.ss([[1.0]], [[gain]], [[1.0]], [[0.0]], PERIOD)
    loop = time_invariant(integrator)
    found = stability_margins(lambda delay: delayed_integrator(gain / PERIOD, delay))
    assert found.gain_up == pytest.approx(2.0 / gain, rel=1e-5)
    assert found.gain_down == 0.0
    # pole at 1 - k h e^(-i phi), on the circle when 2 cos(phi) = k h
    assert found.phase == pytest.approx(np.degrees(np.arccos(gain / 2.0)), rel=1e-5)
    assert found.radius == pytest.approx(loop.radius()) == pytest.approx(1.0 - gain)


def test_exact_margins_of_an_unstable_plant_have_a_lower_gain_margin():
    # x+ = p x + u, fed back by k: the pole p - f k lies in the circle for f from (p - 1) / k to (p + 1) / k
    pole, gain = 1.2, 0.5
    found = stability_margins(lambda delay: late_input(pole, gain, delay))
    assert found.gain_down == pytest.approx((pole - 1.0) / gain, rel=1e-5)
    assert found.gain_up == pytest.approx((pole + 1.0) / gain, rel=1e-5)


def late_input(pole, gain, delay):
    """Return x+ = pole x + (1 - m) u + m (u of the step before), m = delay / PERIOD, fed back by `gain`."""
    part = delay / PERIOD
    phase = Phase(a=np.array([[pole, part], [0.0, 0.0]]), c=np.array([[gain, 0.0]]))
    return PeriodicLoop(first=phase, rest=phase, b=np.array([[1.0 - part], [1.0]]), steps=1, period=PERIOD)


def test_lower_gain_margin_of_a_conditionally_stable_loop():
    # k (s + 1)^2 / s^3 crosses the negative axis at 1 rad/s, where it is -2 k: it becomes unstable below 1 / (2 k)
    frequency, factor = np.geomspace(0.01, 3.0, 2000), 2.0
    s = 2j * np.pi * frequency
    found = loop_margins(frequency, factor * (s + 1.0) ** 2 / s**3)
    assert found.gain_down == pytest.approx(1.0 / (2.0 * factor), rel=1e-4)  # interpolation between the lines
    assert found.gain_down_at == pytest.approx(1.0 / (2.0 * np.pi), rel=1e-4)
    assert found.gain_up == np.inf


@pytest.mark.parametrize("rate", [12.0, 15.0, 19.0])
def test_exact_delay_margin_of_a_sampled_integrator(rate):
    # z (z - 1) + k ((h - tau) z + tau) = 0: the product of its roots is k tau
    assert delay_margin(lambda delay: delayed_integrator(rate, delay), 0.2) == pytest.approx(1.0 / rate, rel=1e-5)


def delayed_integrator(rate, delay):
    """Return x' = rate u, u held over PERIOD and late by less than that."""
    a = np.array([[1.0, rate * delay], [0.0, 0.0]])
    phase = Phase(a=a, c=np.array([[1.0, 0.0]]))
    return PeriodicLoop(first=phase, rest=phase, b=np.array([[rate * (PERIOD - delay)], [1.0]]), steps=1, period=PERIOD)


@pytest.mark.parametrize("rate", [12.0, 15.0, 19.0])
def test_the_delay_margin_from_the_response_counts_the_hold(rate):
    frequency = np.geomspace(0.5, 4.95, 500)
    back = np.exp(-2j * np.pi * frequency * PERIOD)
    loop = rate * PERIOD * back / (1.0 - back)
    assert loop_margins(frequency, loop, PERIOD).delay == pytest.approx(1.0 / rate, rel=1e-3)  # interpolation
    # as if the input were continuous it would be several per cent off
    assert loop_margins(frequency, loop).delay != pytest.approx(1.0 / rate, rel=0.02)
    assert_allclose(delayed_hold(0.7, 2.0 * PERIOD, PERIOD), np.exp(-1.4j), rtol=1e-12)  # whole periods: a pure delay


def test_crossing_between_lines_too_far_apart_is_listed_and_not_used():
    plant = 3.0 * small_plant()  # its resonance reaches beyond gain one
    dense, sparse = np.geomspace(0.05, 4.0, 3000), np.geomspace(0.05, 4.0, 14)
    found = loop_margins(sparse, plant(np.exp(2j * np.pi * sparse * PERIOD)))
    assert loop_margins(dense, plant(np.exp(2j * np.pi * dense * PERIOD))).unresolved == ()
    assert found.unresolved


def test_between_lines_the_interpolation_is_of_third_order():
    plant = small_plant()
    errors = []
    for lines in (17, 33, 65):
        frequency = np.geomspace(0.7, 4.0, lines)
        loop = plant(np.exp(2j * np.pi * frequency * PERIOD))
        values = np.column_stack([np.log(np.abs(loop)), np.unwrap(np.angle(loop))])
        grid, fine = densified(frequency, values, np.full((lines - 1, 2), True))
        assert_allclose(fine[::SPLIT], values)
        exact = np.log(np.abs(plant(np.exp(2j * np.pi * grid * PERIOD))))
        inside = slice(SPLIT, -SPLIT)  # the outermost intervals know one slope alone
        errors.append(np.abs(fine[inside, 0] - exact[inside]).max())
    assert errors[0] / errors[1] > 5.0  # 8 for a third order, in the limit
    assert errors[1] / errors[2] > 5.0
    straight = densified(frequency, values, np.full((lines - 1, 2), False))[1]
    assert_allclose(straight[SPLIT // 2 :: SPLIT], 0.5 * (values[1:] + values[:-1]))


def random_periodic_loop(seed=5):
    generator = np.random.default_rng(seed)
    size, channels = 5, 2
    first, rest = (
        Phase(a=0.4 * generator.standard_normal((size, size)), c=0.2 * generator.standard_normal((channels, size)))
        for _ in range(2)
    )
    return PeriodicLoop(first=first, rest=rest, b=generator.standard_normal((size, channels)), steps=4, period=0.01)


def test_response_of_a_periodic_loop_at_the_frequency_of_the_injection_is_as_simulated():
    loop = random_periodic_loop()
    assert loop.radius() < 0.95
    frequency, along = 13.0, np.array([0.3, -1.0])
    steps, phases = 8000, [loop.first, loop.rest, loop.rest, loop.rest]
    state, found = np.zeros(5, complex), np.zeros(2, complex)
    for k in range(2 * steps):  # the first half dies out
        turned = np.exp(2j * np.pi * frequency * k * loop.period)
        phase = phases[k % 4]
        back = phase.c @ state
        if k >= steps:
            found += back / turned / steps
        state = phase.a @ state + loop.b @ (along * turned - back)
    predicted = loop.complementary_sensitivity(np.array([frequency]), along[:, None])[0, :, 0]
    # 80 s hold whole periods of 13 Hz and of the sidebands at 13 + 25 k Hz, so that these average out
    assert_allclose(found, predicted, rtol=1e-9)


def test_one_direction_opened_leaves_the_others_closed():
    loop = random_periodic_loop()
    loop = replace(loop, first=loop.rest)  # time-invariant: the loops are exact
    frequency = np.array([3.0, 20.0])
    t = loop.complementary_sensitivity(frequency)
    together, single = body_loops(t, np.eye(2))
    # close the second channel by hand
    closed_second = loop.rest.a - loop.b[:, 1:] @ loop.rest.c[1:]
    z = np.exp(2j * np.pi * frequency * loop.period)
    by_hand = [loop.rest.c[0] @ np.linalg.solve(each * np.eye(5) - closed_second, loop.b[:, 0]) for each in z]
    assert_allclose(single[:, 0], by_hand, rtol=1e-9)
    opened = [loop.rest.c @ np.linalg.solve(each * np.eye(5) - loop.rest.a, loop.b) for each in z]
    assert_allclose(together, opened, rtol=1e-9)


def test_unstable_loop_is_refused():
    with pytest.raises(ValueError, match=r"unstable, spectral radius 1\.5: it has no margins"):
        stability_margins(lambda delay: delayed_integrator(25.0, delay))


def test_matrices_that_do_not_match_are_refused():
    phase = Phase(a=np.eye(2), c=np.ones((1, 2)))
    with pytest.raises(ValueError, match=r"must be \(3, 3\) and \(1, 3\)"):
        PeriodicLoop(first=phase, rest=phase, b=np.ones((3, 1)), steps=1, period=0.1)


# The designed loop


@pytest.mark.parametrize(("name", "margin"), [("centralised", 3.783e-3), ("distributed", 4.932e-3)])
def test_delay_margin_of_the_mesh_of_record(designs, name, margin):
    # the co-simulation becomes unstable there too (tests/system/test_margins.py)
    loop = DesignedLoop(design=designs[name])
    assert loop.at(margin - 1e-5).radius() < 1.0 < loop.at(margin + 1e-5).radius()
    assert loop.at(0.0).radius() < loop.at(margin - 1e-3).radius() + 1e-6 < 1.0


@pytest.mark.parametrize(("name", "margin"), [("centralised", 4.1e-3), ("distributed", 5.6e-3)])
def test_delay_margin_with_the_authors_matrices_as_published(monkeypatch, request, name, margin):
    if not DATA.exists():
        pytest.skip(f"the authors' finite-element data are not there: {DATA}")
    with np.load(DATA) as archive:
        data = dict(archive)
    monkeypatch.setattr(spacecraft, "structure_of", lambda config: authors_structure(data, config.plate))
    monkeypatch.setattr(
        Mesh, "node_at", lambda mesh, *site: int(np.argmin(np.linalg.norm(mesh.nodes - polar(*site), axis=1)))
    )  # the authors' inner sites are up to 7 cm from those of flexsat
    forget_designs()
    request.addfinalizer(forget_designs)  # what is built here is nobody else's
    loop = DesignedLoop(design=build_design(with_modes(configuration(name, "published"), 25), AS_PUBLISHED))
    printed = 5e-5  # PHYSICS section 6 gives a tenth of a millisecond
    assert loop.at(margin - printed).radius() < 1.0 < loop.at(margin + printed).radius()


def forget_designs():
    """Empty the chain's caches, which other tests of this process have filled."""
    chain.build_design.cache_clear()
    chain._structure.cache_clear()


def authors_structure(data, plate):
    """Return the authors' structure: their mesh, stiffness and clamping."""
    mesh = Mesh(nodes=data["nodes"], triangles=data["triangles"].astype(np.intp), hole=np.arange(6, dtype=np.intp))
    stiffness = csc_array(0.5 * (data["stiffness"] + data["stiffness"].T))
    matrices = replace(assemble(mesh, plate), stiffness=stiffness)
    frequency, shape = structure.solve_modes(matrices, data["clamped_dofs"].astype(np.intp), 25)
    return structure.of_plate(mesh, plate, matrices, frequency, shape)


def test_delays_of_the_system_and_of_the_margin_act_alike(designs):
    early = DesignedLoop(design=designs["centralised"], delays=Delays(actuation=0.0021)).at(0.0047)
    late = DesignedLoop(design=designs["centralised"]).at(0.0068)
    assert early.b.shape == late.b.shape
    assert_allclose(early.radius(), late.radius(), rtol=1e-9)


def test_loop_is_stable_with_compensated_delays_and_unstable_without(designs):
    delays = Delays(samples=1, actuation=0.005)
    compensated = {"star_tracker.fine": True, "delay.measurement": 0.005, "delay.actuation": 0.005}
    assert DesignedLoop(design=designs["centralised"], delays=delays).at().radius() > 1.0
    assert DesignedLoop(design=designs["centralised"], delays=delays, parameters=compensated).at().radius() < 1.0
    # compensation of delays that do not exist destabilises as well
    assert DesignedLoop(design=designs["centralised"], parameters=compensated).at().radius() > 1.0


@pytest.fixture(scope="module")
def analysis(designs):
    return analyse(DesignedLoop(design=designs["centralised"]))


def test_the_time_invariant_equivalent_has_the_exact_margins(analysis):
    found, exact = analysis.margins["all wheels"], analysis.exact
    assert found.unresolved == ()
    # the star tracker touches low frequencies alone; the rest is interpolation between lines, and the hold on a plant
    # that integrates nearly, but not quite
    assert found.gain_up == pytest.approx(exact.gain_up, rel=0.01)
    assert found.phase == pytest.approx(exact.phase, rel=0.01)
    assert found.delay == pytest.approx(exact.delay, rel=0.005)


def test_six_wheels_on_the_bus_have_the_margins_of_the_body_axes(analysis):
    body, everything = analysis.margins["body axes"], analysis.margins["all wheels"]
    for name in ("gain_up", "phase", "delay", "disk"):
        assert getattr(body, name) == pytest.approx(getattr(everything, name), rel=1e-6)


def test_singular_values_bound_the_disk_margin(analysis):
    # |S - T| <= |S| + |T|, and >= 2 |S| - 1
    least = 2.0 / disk_margins(analysis.all_wheels)
    assert np.all(least <= analysis.sensitivity + analysis.complementary + 1e-9)
    assert np.all(least >= 2.0 * analysis.sensitivity - 1.0 - 1e-9)
