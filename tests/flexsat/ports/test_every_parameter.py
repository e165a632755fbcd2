"""Every parameter of the three FMUs acts on a run: each is changed in turn, alone or with what it needs beside it."""

from dataclasses import replace

import numpy as np
import pytest

from flexsat.description.built_in import configuration
from flexsat.design.chain import Designs, build_design
from flexsat.fmu.build import SHELLS, component_resources
from flexsat.fmu.python.load_matrices import MODEL_FILE
from flexsat.parameters import Modes, SpeedSelection
from flexsat.variants import AS_PUBLISHED, CORRECTED, PUBLISHED

SEED = 3  # of the constant inputs
STEPS = {"plant": 4, "sensors": 25, "controller": 42}  # past samples of the star tracker and a slew's begin
# for the wheels of the paper's layout, two along each axis, least peak and least squares are the same
TILTED = np.array(
    [[0.8, 0.6, 0.0], [0.0, 0.8, 0.6], [0.6, 0.0, 0.8], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]]
)
SLEW = {"command.rotation": (2e-3, 1e-3, 0.0), "command.start_time": 0.2}
BRIGHT = (0.1, 0.0, 1.0)  # 0.1 rad off the boresight
CONE = {"first.direction": (0.0, -0.5646, 0.8253), "first.half_angle": 0.2,
        "second.direction": (0.0, -0.9, 0.43), "second.half_angle": 0.1}  # fmt: skip
PAST_CONES = {"command.rotation": (1.5, 0.0, 0.0), "command.start_time": 0.2, "slew.authority": 1.0,
              "wheel.torque_limit": 1e5, "wheel.speed_band": 1e5,
              **{f"keep_out.{name}": value for name, value in CONE.items()}}  # fmt: skip
OF_SLEWS = ("slew.guidance", "slew.authority", "slew.least_peak", "slew.gyroscopic", "reference.smoothed",
            "wheel.torque_limit", "wheel.torque_limit_factor", "wheel.speed_band", "wheel.speed_band_factor",
            "wheel.speed_offset")  # fmt: skip
# what a parameter needs to have an effect
NEEDS = {
    "plant": {"wheel.full_torque_speed": {"wheel.speed_limit": 2000.0}},
    "sensors": {
        "star_tracker.noise_fine": {"star_tracker.fine": True},
        "star_tracker.low_frequency_time": {"star_tracker.low_frequency_error": 1e-4},
        "star_tracker.boresight": {"star_tracker.roll_factor": 10.0},
        **{f"star_tracker.{name}.direction": {f"star_tracker.{name}.half_angle": 0.3,
                                              f"star_tracker.{name}.direction": (1.0, 0.0, 0.0)}
           for name in ("sun", "earth")},
        **{f"star_tracker.{name}.half_angle": {f"star_tracker.{name}.direction": BRIGHT} for name in ("sun", "earth")},
    },
    "controller": {
        **dict.fromkeys(OF_SLEWS, SLEW),
        "slew.gyroscopic": SLEW | {"wheel.speed_offset": (1.0, 0.0, -1.0, 0.5, 0.0, 0.0)},
        **{f"keep_out.{name}": PAST_CONES for name in ("axis", *CONE)},
    },
}  # fmt: skip
BASE = {"plant": {}, "sensors": {"star_tracker.period": 0.01}, "controller": {}}
# values where a share more, or a small number in place of zero, is refused or too little
OTHER = {
    "fast_period": 0.01,
    "star_tracker.period": 0.015,
    "star_tracker.boresight": (0.0, 0.6, 0.8),
    "star_tracker.sun.direction": BRIGHT,
    "star_tracker.earth.direction": BRIGHT,
    "star_tracker.sun.half_angle": 0.3,
    "star_tracker.earth.half_angle": 0.3,
    "slew.guidance": "smoothed",
    "design": "published",
    "modes": 5,
    "seed": 7,
    "initial.capture_angle": 0.1,
    "keep_out.axis": (0.0, 0.1, 1.0),
    "keep_out.first.direction": (0.1, -0.5646, 0.8253),
    "keep_out.second.direction": (0.1, -0.9, 0.43),
}
# the length of a step, which the first step gives; what a second command does is seen in a chain of slews
NOT_HERE = ("step_size", "command.during_slew")


@pytest.fixture(scope="module")
def folders(tmp_path_factory):
    """Return the resources of the FMUs of a small plant; variants differ in damping, noise and feedback."""
    small = replace(configuration("centralised"), modes=Modes(plant=12, design=8), speeds=SpeedSelection(points=60))
    design = build_design(small)
    design = replace(design, controller=replace(design.controller, wheel_axis=TILTED))
    other = replace(
        design,
        plant=replace(design.plant, damping=2.0 * design.plant.damping),
        sensors=replace(design.sensors, gyro_noise=2.0 * design.sensors.gyro_noise),
        controller=replace(design.controller, feedback=1.1 * design.controller.feedback),
    )
    designs = Designs({CORRECTED: design, PUBLISHED: other, AS_PUBLISHED: other})
    found = {}
    for component in SHELLS:
        found[component] = tmp_path_factory.mktemp(component)
        (found[component] / MODEL_FILE).write_bytes(component_resources(designs, component)[MODEL_FILE])
    return found


def test_every_parameter_changes_a_run(folders):
    silent = []
    for component, folder in folders.items():
        runs: dict[str, np.ndarray] = {}
        for port in make(component, folder).table:
            if port.causality != "parameter" or port.name in NOT_HERE:
                continue
            settings = BASE[component] | NEEDS[component].get(port.name, {})
            key = repr(settings)
            if key not in runs:
                runs[key] = run(component, folder, settings)
            now = np.ravel(settings.get(port.name, port.start))
            other = OTHER[port.name] if port.name in OTHER else changed(port, now)
            there = run(component, folder, settings | {port.name: other})
            if np.array_equal(there, runs[key]):
                silent.append(f"{component}.{port.name}")

    assert silent == []


def changed(port, now):
    """Return other values of all elements."""
    if port.kind == "boolean":
        return not now[0]
    return [0.75 * value if value else 1e-3 for value in now]


def make(component, folder):
    """Return a component outside an FMU."""
    return SHELLS[component](instance_name=component, resources=str(folder))


def put(slave, name, value):
    """Set a port; one value for an array is that of all elements."""
    (port,) = (port for port in slave.table if port.name == name)
    references = [v.value_reference for v in slave.table.variables if v.port is port]
    values = [value] if isinstance(value, str) else np.ravel(value).tolist()
    getattr(slave, f"set_{port.kind}")(references, values * (len(references) // len(values)))


def run(component, folder, settings):
    """Return all outputs after each step, under inputs that differ from each other and mean little."""
    slave, random = make(component, folder), np.random.default_rng(SEED)
    for name, value in settings.items():
        put(slave, name, value)
    slave.setup_experiment(0.0)
    slave.enter_initialization_mode()
    slave.exit_initialization_mode()
    assert not slave.log_queue, (settings, [message.msg for message in slave.log_queue])
    h = slave.fixed_step or slave.preferred_step
    real = [port for port in slave.table if port.causality == "input" and port.kind == "real"]
    inputs = {p.name: random.uniform(0.5, 1.5, p.length) for p in real if not p.name.startswith("command.")}
    outputs = [v for v in slave.table.variables if v.port.causality == "output"]
    rows = []
    for step in range(STEPS[component]):
        for name, values in inputs.items():
            put(slave, name, stimulus(name, values, step))
        if component == "controller":
            put(slave, "star_tracker.valid", step % 20 == 0)
        slave.do_step(step * h, h)
        assert not slave.log_queue, (settings, [message.msg for message in slave.log_queue])
        rows.append([getattr(slave, f"get_{v.port.kind}")([v.value_reference])[0] for v in outputs])
    return np.array(rows, np.float64)


def stimulus(name, values, step):
    """Return an input at a step: torques beyond some limits, speeds near the nominal, an attitude that turns."""
    if name == "attitude.quaternion":
        turned = np.array([1e-3 * step, 2e-3, 0.0, 1.0])
        return turned / np.linalg.norm(turned)
    if name == "star_tracker.mrp":  # beyond the least angle at which the filter begins at the measured attitude
        return 2e-4 * values
    if "torque" in name:
        return 6.0 * values
    return (20.0 if "speed" in name else 1e-3 * (1 + step)) * values
