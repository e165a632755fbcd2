"""The same seed gives the same run, whatever else a process has done; another seed gives another one."""

import pytest

# Runs of `cases` (configuration, scenario, seed) one after the other; of each, a digest of every column's bytes.
RUNS = """
from hashlib import sha256
from flexbench.loop.scenarios import scalar_overrides, scenario_parameters
from lockstep import load_system, read_signals, simulate
fmus, folder, cases = given
result = []
for number, (name, scenario, seed) in enumerate(cases):
    where = Path(folder, str(number))
    simulate(load_system(Path(fmus, name, f"{scenario}.ssd")), where, stop_time=1.5, record=["all"],
             overrides=scalar_overrides(scenario_parameters(scenario, seed=seed)))
    signals = read_signals(where)
    result.append({"time": sha256(signals.time.tobytes()).hexdigest()}
                | {column: sha256(values.tobytes()).hexdigest() for column, values in signals.columns.items()})
"""
A, B = ["centralised", "fine_pointing", 1], ["distributed", "fine_pointing", 1]
OTHER_SEED = ["centralised", "fine_pointing", 2]
# what noise, broadband jitter, wheel phases and initial attitude reach from the first second on
OFF = ("controller.estimate.disturbance", "controller.estimate.gyro_bias")  # 0 without their filters
NOISY = (
    "sensors.gyro.rate",
    "sensors.accelerometer.acceleration",
    "sensors.encoder.speed",
    "sensors.encoder.angle",
    "sensors.star_tracker.mrp",
    "sensors.star_tracker.quaternion",
    "sensors.jitter",
    "controller.wheel.torque",
    "controller.estimate",
    "plant.attitude",
    "plant.rate",
    "plant.velocity",
    "plant.modal",
    "plant.wheel.speed",
    "plant.wheel.angle",
    "plant.gyro_site",
    "plant.accelerometer_site",
    "plant.rms_deformation",
    "plant.energy",
)


@pytest.fixture(scope="module")
def one_process(fmus, python, tmp_path_factory):
    """Return digests of five runs in one process: twice the same, the other configuration, again, another seed."""
    return python(RUNS, fmus, tmp_path_factory.mktemp("one"), [A, A, B, A, OTHER_SEED, B])


@pytest.fixture(scope="module")
def another_process(fmus, python, tmp_path_factory):
    """Return digests of the two configurations in the other order, in another process."""
    return python(RUNS, fmus, tmp_path_factory.mktemp("another"), [B, A])


def test_twice_in_one_process_is_bitwise_the_same(one_process):
    assert len(one_process[0]) > 200
    assert one_process[0] == one_process[1]


def test_two_processes_give_bitwise_the_same(one_process, another_process):
    assert one_process[0] == another_process[1]
    assert one_process[2] == another_process[0]


def test_configurations_in_one_process_do_not_mix(one_process):
    first, _, distributed, again, _, distributed_again = one_process
    assert first == again
    assert distributed == distributed_again
    assert distributed["plant.rate[1]"] != first["plant.rate[1]"]


def test_another_seed_changes_every_noisy_signal(one_process):
    first, other = one_process[0], one_process[4]
    noisy = [column for column in first if column.startswith(NOISY) and not column.startswith(OFF)]
    assert {name for name in NOISY if not any(column.startswith(name) for column in noisy)} == set()
    assert [column for column in noisy if first[column] == other[column]] == []


def test_another_seed_changes_nothing_else(one_process):
    first, other = one_process[0], one_process[4]
    rest = [column for column in first if not column.startswith((*NOISY, "plant.angular_momentum"))]
    assert any(column.startswith("controller.reference") for column in rest)
    assert [column for column in rest if first[column] != other[column]] == []
