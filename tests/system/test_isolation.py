"""Our own FMUs in processes of their own give the same bits as in the master's, noise included."""

import numpy as np

from bare_system import run_without

COMPARE = """
from flexbench.loop.scenarios import scalar_overrides, scenario_parameters
from lockstep import load_system, read_signals, simulate
path, folder = given
system = load_system(path)
settings = scalar_overrides(scenario_parameters("fine_pointing", seed=2))
isolated = system
for component in system.components:
    isolated = isolated.with_isolation(component.name, True)
mixed = system.with_isolation("controller", True)
result = []
for name, one in {"shared": system, "isolated": isolated, "mixed": mixed}.items():
    simulate(one, Path(folder, name), stop_time=0.3, record=["all"], record_period=0.001, overrides=settings)
import tomllib
for name in ("shared", "isolated", "mixed"):
    run = tomllib.loads(Path(folder, name, "run.toml").read_text())
    result.append([component["isolated"] for component in run["component"]])
"""


def test_every_output_at_every_tick_is_the_same(fmus, python, tmp_path):
    from lockstep import read_signals

    isolated = python(COMPARE, fmus / "centralised" / "fine_pointing.ssd", tmp_path)
    shared, alone, mixed = (read_signals(tmp_path / name) for name in ("shared", "isolated", "mixed"))

    assert [any(flags) for flags in isolated] == [False, True, True]
    assert all(isolated[1])
    assert len(shared.time) == 301
    assert len(shared.columns) > 300
    assert np.ptp(shared["sensors.gyro.rate[1]"]) > 0.0  # noise: a generator that starts elsewhere would show
    for name in shared.columns:
        np.testing.assert_array_equal(alone[name], shared[name], name)
        np.testing.assert_array_equal(mixed[name], shared[name], name)


WITHOUT = """
from flexbench.loop.scenarios import scalar_overrides, scenario_parameters
from lockstep import load_system, simulate
settings = scalar_overrides(scenario_parameters("fine_pointing", seed=2))
path, folder = sys.argv[-2:]
simulate(load_system(path), folder, stop_time=1.0, record=["all"], overrides=settings)
"""


def test_a_second_is_the_same_without_what_linux_alone_offers(fmus, python, tmp_path):
    from lockstep import read_signals

    system = fmus / "centralised" / "fine_pointing.ssd"
    done = run_without(WITHOUT, system, tmp_path / "without")
    assert done.returncode == 0, done.stderr
    python("sys.argv += given\nresult = None" + WITHOUT, system, tmp_path / "with")

    without, usual = (read_signals(tmp_path / name) for name in ("without", "with"))
    assert (len(without.time), list(without.columns)) == (len(usual.time), list(usual.columns))
    for name in usual.columns:
        np.testing.assert_array_equal(without[name], usual[name], name)
