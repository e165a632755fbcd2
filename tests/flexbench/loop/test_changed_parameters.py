"""Parameters changed in the configuration are in the built FMUs, and in a run of them."""

from dataclasses import replace

import fmpy
import numpy as np
import pytest

from flexbench.loop.scenarios import scalar_overrides, scenario_parameters
from flexbench.loop.systems import build_system
from flexsat.closed_loop import ClosedLoop, Command
from flexsat.description.built_in import configuration
from flexsat.design.chain import Designs, build_design
from flexsat.fmu.build import SHELLS, component_resources
from flexsat.fmu.export import build_fmu
from flexsat.parameters import Rates, Slew
from flexsat.variants import AS_PUBLISHED, CORRECTED, PUBLISHED
from lockstep import read_signals, simulate

CONFIG = replace(
    configuration("centralised"),
    rates=Rates(plant=2e-3, sensors=2e-3, controller=4e-3, star_tracker=0.2),
    slew=Slew(rotation=(0.01, 0.002, 0.0), start_time=0.6, authority=0.5),
)
DURATION = 1.0  # s, with the start of the slew inside


@pytest.fixture(scope="module")
def designs():
    corrected = build_design(CONFIG)
    return Designs({CORRECTED: corrected, PUBLISHED: corrected, AS_PUBLISHED: build_design(CONFIG, AS_PUBLISHED)})


@pytest.fixture(scope="module")
def fmus(designs, tmp_path_factory):
    folder = tmp_path_factory.mktemp("changed")
    for component, shell in SHELLS.items():
        resources = component_resources(designs, component)
        build_fmu(f"{shell.__module__}:{shell.__name__}", folder / f"{component}.fmu", resources, component)
    return folder


def test_model_descriptions_show_the_changed_parameters(fmus):
    described = {name: fmpy.read_model_description(fmus / f"{name}.fmu") for name in SHELLS}
    starts = {f"{name}.{v.name}": v.start for name, model in described.items() for v in model.modelVariables}

    steps = {name: float(model.defaultExperiment.stepSize) for name, model in described.items()}
    assert steps == {"plant": 2e-3, "sensors": 2e-3, "controller": 4e-3}
    shown = {
        "sensors.fast_period": 4e-3,
        "sensors.star_tracker.period": 0.2,
        "controller.command.start_time": 0.6,
        "controller.slew.authority": 0.5,
    }
    assert {name: float(starts[name]) for name in shown} == shown


def test_a_run_of_the_built_fmus_follows_the_changed_parameters(designs, fmus, tmp_path):
    """Bitwise the plain loop of the same designs, which is another run than that of the stock parameters."""
    ports = ["plant.attitude.mrp", "controller.wheel.torque", "controller.reference.mrp", "sensors.star_tracker.valid"]
    parameters = scenario_parameters("slew", seed=2, slew=CONFIG.slew)
    system = replace(build_system(designs, "slew", fmus), record=tuple(ports))
    simulate(system, tmp_path / "run", stop_time=DURATION, overrides=scalar_overrides(parameters))
    signals = read_signals(tmp_path / "run")
    expected = ClosedLoop(designs, parameters).run(DURATION, ports, record_ticks=2)

    assert signals.time.tolist() == expected.time.tolist()
    for name in ports:
        np.testing.assert_array_equal(signals[name], expected.signals[name], err_msg=name)
    sampled = expected.time[np.flatnonzero(np.diff(expected.signals["sensors.star_tracker.valid"].astype(int)) > 0) + 1]
    assert sampled.tolist() == [0.2, 0.4, 0.6, 0.8, 1.0]
    reference = expected.signals["controller.reference.mrp"]
    lead = 0.6 - expected.time[np.flatnonzero(np.any(reference != 0.0, axis=1))[0]]
    assert 0.1 < lead < 0.2  # the shaped torque begins a quarter of the dominant mode's period before the slew


COMMANDS = """time,controller.command.rotation[1],controller.command.rotation[2],controller.command.start_time
0,2e-6,0,0.6
1.6,2e-6,0,1.9
2.0,0,3e-6,0
"""


def test_a_table_of_commands_is_a_chain_of_slews(designs, fmus, tmp_path):
    """Two slews from a file, and a third that takes the place of the second in flight: bitwise as the plain loop."""
    table = tmp_path / "commands.csv"
    table.write_text(COMMANDS)
    ports = ["controller.reference.mrp", "controller.reference.torque", "controller.wheel.torque"]
    parameters = scenario_parameters("slew", seed=2, slew=replace(CONFIG.slew, rotation=(2e-6, 0.0, 0.0)))
    parameters["controller"] |= {"command.during_slew": "replan", "slew.guidance": "smoothed"}
    system = replace(build_system(designs, "slew", fmus), record=tuple(ports))
    fed = COMMANDS.partition("\n")[0].split(",")
    overrides = {name: value for name, value in scalar_overrides(parameters).items() if name not in fed}
    simulate(system, tmp_path / "run", stop_time=4.2, inputs=[table], overrides=overrides)
    signals = read_signals(tmp_path / "run")
    commands = [Command(time=1.6, rotation=(2e-6, 0.0, 0.0), start=1.9),
                Command(time=2.0, rotation=(0.0, 3e-6, 0.0), start=0.0)]  # fmt: skip
    expected = ClosedLoop(designs, parameters).run(4.2, ports, record_ticks=2, commands=commands)

    for name in ports:
        np.testing.assert_array_equal(signals[name], expected.signals[name], err_msg=name)
    # from 2e-6 rad about x on: the third command leads there from where the second slew began
    assert np.allclose(4.0 * signals["controller.reference.mrp"][-1], [2e-6, 3e-6, 0.0], atol=1e-10)
