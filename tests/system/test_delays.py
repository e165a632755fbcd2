"""Delays between the FMUs: one sample in each path makes the published loop limit-cycle, unless it knows them.

The runs of 40 s have native FMUs; that those in Python do the same under delays is in `test_equivalence.py`.
"""

import pytest

pytestmark = pytest.mark.slow

# A fine-pointing run with delays in the master [ticks of 1 ms] and compensated in the controller [s]; RMS over the
# second half. The loop is in its limit cycle within a second, and the start's transient is over after ten.
DELAYED = """
import numpy as np
from flexbench.loop.native_fmus import with_native_fmus
from flexbench.runs import histories
from flexbench.loop.scenarios import scalar_overrides, scenario_parameters
from lockstep import load_system, read_signals, simulate
fmus, folder, name, cases = given
result = {}
for case, (measurement, actuation, known_measurement, known_actuation) in cases.items():
    system = with_native_fmus(load_system(Path(fmus, name, "fine_pointing.ssd")))
    system = system.with_delay("sensors", "controller", measurement).with_delay("controller", "plant", actuation)
    overrides = scalar_overrides(scenario_parameters("fine_pointing", seed=1))
    overrides |= {"controller.design": "published", "plant.modes": 25}  # the robust one bears these delays unknown
    overrides |= {"controller.delay.measurement": known_measurement, "controller.delay.actuation": known_actuation}
    simulate(system, Path(folder, case), stop_time=40.0, overrides=overrides)
    signals = read_signals(Path(folder, case))
    steady = signals.time >= 20.0
    rms = lambda history: float(np.sqrt(np.mean(history(signals)[steady] ** 2)))
    result[case] = {"torque": rms(histories.torque_norm), "deformation": rms(histories.deformation),
                  "pointing": rms(histories.pointing_error)}
"""

SAME = 0.12  # deformation with known delays: 10.5 % more at the wheel speeds of the full plant, over these 20 s
CENTRALISED = {
    "none": (0, 0, 0.0, 0.0),
    "unknown": (5, 5, 0.0, 0.0),
    "known": (5, 5, 0.005, 0.005),
    "measurement unknown": (5, 0, 0.0, 0.0),
    "measurement known": (5, 0, 0.005, 0.0),
    "actuation unknown": (0, 5, 0.0, 0.0),
    "actuation known": (0, 5, 0.0, 0.005),
    "fraction unknown": (3, 4, 0.0, 0.0),
    "fraction known": (3, 4, 0.003, 0.004),
    "fraction and age known": (3, 4, 0.005, 0.004),
}
DISTRIBUTED = {"none": (0, 0, 0.0, 0.0), "unknown": (5, 5, 0.0, 0.0), "known": (5, 5, 0.005, 0.005)}


@pytest.fixture(scope="module")
def centralised(fmus, python, tmp_path_factory):
    """Return RMS torque [N.m], deformation [m] and pointing error [rad] of the centralised loop by case."""
    return python(DELAYED, fmus, tmp_path_factory.mktemp("delays"), "centralised", CENTRALISED, timeout=600)


@pytest.fixture(scope="module")
def distributed(fmus, python, tmp_path_factory):
    """Return the same of the distributed loop."""
    return python(DELAYED, fmus, tmp_path_factory.mktemp("delays"), "distributed", DISTRIBUTED, timeout=600)


def test_without_delay_the_torque_is_small(centralised):
    assert 0.08 < centralised["none"]["torque"] < 0.11  # N.m; PHYSICS section 7: .093 to .100


def test_one_sample_in_each_path_is_a_limit_cycle(centralised):
    # torque saturates: at most 6 x 4.4 N.m; the pointing error hardly shows it (PHYSICS section 6)
    assert 5.0 < centralised["unknown"]["torque"] < 26.4
    assert centralised["unknown"]["deformation"] > 10.0 * centralised["none"]["deformation"]
    assert centralised["unknown"]["pointing"] < 10.0 * centralised["none"]["pointing"]


@pytest.mark.parametrize("path", ["measurement", "actuation"])
def test_one_sample_in_either_path_is_a_limit_cycle(centralised, path):
    assert centralised[f"{path} unknown"]["torque"] > 5.0


@pytest.mark.parametrize("path", ["measurement", "actuation"])
def test_a_known_sample_in_either_path_costs_little(centralised, path):
    assert centralised[f"{path} known"]["torque"] < 0.15
    assert centralised[f"{path} known"]["deformation"] == pytest.approx(centralised["none"]["deformation"], rel=SAME)


def test_known_samples_in_both_paths_cost_half_as_much_torque_again_and_no_deformation(centralised):
    known, none = centralised["known"], centralised["none"]
    assert known["torque"] < 0.2
    # PHYSICS section 6: .100 -> .148; here .092 -> .140
    assert known["torque"] / none["torque"] == pytest.approx(1.5, rel=0.1)
    assert known["deformation"] == pytest.approx(none["deformation"], rel=SAME)
    assert known["pointing"] == pytest.approx(none["pointing"], rel=SAME)


def test_fractions_of_a_sample_are_known_too(centralised):
    assert centralised["fraction unknown"]["torque"] > 5.0
    assert centralised["fraction known"]["torque"] < 0.2
    assert centralised["fraction known"]["deformation"] == pytest.approx(centralised["none"]["deformation"], rel=SAME)


def test_a_measurement_of_three_ticks_ago_is_a_sample_of_five(centralised):
    # sampled at 0, 5, 10 ms: what a controller sees at 5 ms through 3 ticks was sampled at 0
    assert centralised["fraction and age known"]["torque"] < 0.95 * centralised["fraction known"]["torque"]


def test_the_distributed_loop_needs_to_know_too(distributed):
    none, unknown, known = (distributed[case] for case in ("none", "unknown", "known"))
    # its margin is wider (5.6 ms) and its wheels are smaller: 3.4 N.m, against .45 without delay
    assert unknown["torque"] > 5.0 * none["torque"]
    assert unknown["deformation"] > 10.0 * none["deformation"]
    assert known["torque"] == pytest.approx(none["torque"], rel=0.2)  # .503 against .447 N.m
    assert known["deformation"] < 1.35 * none["deformation"]  # .105 against .085 um
