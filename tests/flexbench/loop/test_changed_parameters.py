"""Parameters changed in the configuration, and in a mission file, are in the built FMUs, and in a run of them."""

from dataclasses import replace

import fmpy
import numpy as np
import pytest

from flexbench.loop.mission_file import mission_values
from flexbench.loop.missions import AUTHORITY, BAND_FACTOR, mission_ports, mission_system
from flexbench.loop.scenarios import scalar_overrides, scenario_parameters
from flexbench.loop.systems import build_system
from flexsat.closed_loop import ClosedLoop, Command
from flexsat.description.built_in import configuration
from flexsat.design.chain import Designs, build_design
from flexsat.fmu.build import SHELLS, component_resources
from flexsat.fmu.build_missions import FOLDER, MISSION_SHELLS, mission_resources
from flexsat.fmu.export import build_fmu
from flexsat.parameters import ENVIRONMENT_PERIOD, Rates, Slew, Wheel
from flexsat.quantities import quantity
from flexsat.variants import AS_PUBLISHED, CORRECTED, PUBLISHED
from lockstep import read_signals, simulate

CONFIG = replace(
    configuration("centralised"),
    rates=Rates(plant=2e-3, sensors=2e-3, controller=4e-3, star_tracker=0.2),
    slew=Slew(rotation=(0.01, 0.002, 0.0), start_time=0.6, authority=0.5),
    wheel=replace(configuration("centralised").wheel, inertia=5.1, torque_limit=3.9, speed_band=2.2),
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


MISSION = """
[[command]]
at = 0.02
do = "slew"
rotation = [0.0, 30.0, 0.0]
unit = "deg"
[set]
"mission.slew.lead" = 3.0
"mission.settle.dwell" = 0.0
"thrusters.thrust.lag" = 0.0
"environment.orbit.radius" = 8e6
"environment.constant.force" = [0.25, 0.5, -0.125]
"""


@pytest.fixture(scope="module")
def layout(designs, fmus):
    """Return the folder of the FMUs with those of missions in it, without documentation."""
    (fmus / FOLDER).mkdir()
    for component, shell in MISSION_SHELLS.items():
        target = fmus / FOLDER / f"{component}.fmu"
        build_fmu(f"{shell.__module__}:{shell.__name__}", target, mission_resources(designs.corrected), component)
    return fmus


def test_ports_start_with_the_changed_wheel_in_its_unit_and_range(designs):
    ports = {port.name: port for port in mission_ports(designs)["mission"]}

    for field, tighter in (("inertia", {"minimum", "maximum"}), ("torque_limit", set()), ("speed_band", {"minimum"})):
        port, known = ports[f"wheel.{field}"], quantity(Wheel, field)
        assert np.ravel(port.start) == pytest.approx(getattr(CONFIG.wheel, field), rel=1e-15)
        assert port.unit == known.unit
        assert port.minimum == known.range.least or "minimum" in tighter
        assert port.maximum == known.range.most or "maximum" in tighter
    assert np.shape(ports["wheel.inertia"].start) == (6,)


def test_model_descriptions_of_missions_show_the_changed_parameters(layout):
    described = {name: fmpy.read_model_description(layout / FOLDER / f"{name}.fmu") for name in MISSION_SHELLS}
    steps = {name: float(model.defaultExperiment.stepSize) for name, model in described.items()}
    starts = {v.name: v.start for v in described["mission"].modelVariables}

    assert steps == {"environment": ENVIRONMENT_PERIOD, "thrusters": 4e-3, "mission": 4e-3}
    assert float(starts["wheel.torque_limit[6]"]) == pytest.approx(3.9, rel=1e-15)
    assert float(starts["wheel.inertia[6]"]) == pytest.approx(5.1, rel=1e-15)
    assert float(starts["wheel.speed_band"]) == pytest.approx(2.2, rel=1e-15)


def test_the_system_of_a_mission_has_the_changed_periods_and_limits(designs, layout):
    system = mission_system(designs, "mission", layout)
    periods = {one.name: one.period for one in system.components}
    delays = {(one.from_component, one.to_component): one.delay for one in system.connections}
    controller = next(one for one in system.components if one.name == "controller").parameters

    assert system.tick == 2_000_000
    assert periods["mission"] == periods["thrusters"] == 4_000_000
    assert periods["environment"] == round(ENVIRONMENT_PERIOD * 1e9)
    assert (delays["mission", "controller"], delays["plant", "environment"]) == (2, 1)  # ticks: a step of the source
    assert controller["wheel.speed_band_factor[6]"] == BAND_FACTOR
    assert controller["slew.authority"] == AUTHORITY


def test_a_run_follows_the_mission_file(designs, layout, tmp_path):
    """Of the three components alone: the loop around them rests."""
    file = tmp_path / "mission.toml"
    file.write_text(MISSION)
    system = alone(mission_system(designs, "mission", layout))
    values = mission_values(system, file) | {"mission.star_tracker.valid": True}
    simulate(system, tmp_path / "run", stop_time=0.06, overrides=values)
    run = read_signals(tmp_path / "run")
    begun = int(np.flatnonzero(run["mission.timeline.done"])[0])

    assert run.time[begun] == pytest.approx(0.02, abs=1e-12)
    np.testing.assert_allclose(run["mission.command.rotation"][begun], [0.0, np.pi / 6.0, 0.0], rtol=1e-15)
    assert run["mission.command.start_time"][begun] == pytest.approx(3.02, rel=1e-12)
    np.testing.assert_allclose(np.linalg.norm(run["environment.orbit.position"], axis=1), 8e6, rtol=1e-12)
    sunlight = run["environment.solar.force"]
    np.testing.assert_allclose(run["thrusters.external.force"] - sunlight, [[0.25, 0.5, -0.125]] * len(sunlight))


def alone(system):
    """Return the components of missions without the loop around them."""
    return replace(
        system,
        components=tuple(one for one in system.components if one.name in MISSION_SHELLS),
        connections=tuple(
            one for one in system.connections if {one.from_component, one.to_component} <= MISSION_SHELLS.keys()
        ),
        record=("mission.*", "environment.*", "thrusters.external.force"),
        ports=(),
        strict_inputs=False,
    )
