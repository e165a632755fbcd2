"""Designs of both configurations, parameters of a quiet run, and the authors' finite-element data."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from flexsat.description.built_in import CONFIGURATIONS, configuration
from flexsat.description.spacecraft_file import SpacecraftFile, parse_spacecraft
from flexsat.design.chain import Design, build_design
from flexsat.parameters import PUBLISHED_MODES
from flexsat.runtime.controller_parameters import ControllerParameters
from flexsat.runtime.plant_parameters import PlantMatrices, PlantParameters
from flexsat.spacecraft.variation import with_modes
from flexsat.structure.modal_data import ModalData
from flexsat.structure.modal_file import write_modal

DATA = Path(__file__).parents[3] / "shared" / "data" / "cachim_antenna_fem.npz"


@pytest.fixture(scope="session")
def centralised() -> Design:
    """Return the published design, on its own 25 modes, of the configuration with six wheels on the bus."""
    return build_design(with_modes(configuration("centralised", "published"), PUBLISHED_MODES))


@pytest.fixture(scope="session")
def distributed() -> Design:
    """Return the published design, on its own 25 modes, of the configuration with 33 wheels."""
    return build_design(with_modes(configuration("distributed", "published"), PUBLISHED_MODES))


@pytest.fixture(scope="session", params=CONFIGURATIONS)
def design(request: pytest.FixtureRequest) -> Design:
    """Return each configuration's design in turn."""
    return request.getfixturevalue(request.param)


PYRAMID = """\
name = "pyramid"
wheels = [
  {{ at = "bus", axes = [[1, 0, 1], [0, -1, -1], [-1, 0, 1], [0, 1, -1]] }},
  {{ at = "bus", axes = ["+x"], kind = "small" }},
]
gyros = [{{ at = "bus", axes = ["+x", "+y", "+z"] }}]
accelerometers = [{{ at = "bus", axes = ["+x"] }}]
[bus]
mass = 500
inertia = [200, 180, 220]
[wheel]
inertia = 0.2
torque_limit = 0.2
{wheel}
[wheel_kinds.small]
inertia = 0.1
torque_limit = 0.05
{small}
[[appendages]]
name = "array"
file = "array.npz"
at = [0, 1, 0]
orientation = [0, 0, "90 deg"]
[modes]
design = 2
{more}
"""


@pytest.fixture(scope="session")
def pyramid(tmp_path_factory: pytest.TempPathFactory) -> Callable[..., SpacecraftFile]:
    """Return what makes a rigid bus with five wheels and an array of two clamped modes [Hz]; keys of tables as TOML."""

    def make(frequency: tuple[float, float], wheel: str, small: str, more: str = "") -> SpacecraftFile:
        folder = tmp_path_factory.mktemp("pyramid")
        mass, shape = np.array([4.0]), np.zeros((1, 3, 2))
        shape[0, 2, 0] = shape[0, 1, 1] = 1.0 / np.sqrt(mass[0])
        array = ModalData(
            kind="clamped",
            frequency=np.array(frequency),
            damping_ratio=np.full(2, 0.005),
            node_position=np.array([[2.0, 0.0, 0.0]]),
            node_translation=shape,
            node_mass=mass,
        )
        write_modal(folder / "array.npz", array)
        return parse_spacecraft(PYRAMID.format(wheel=wheel, small=small, more=more), "pyramid.toml", folder)

    return make


@pytest.fixture(scope="session")
def authors_fem() -> dict[str, np.ndarray]:
    """Return the authors' finite-element matrices; skip where the data are not there."""
    if not DATA.exists():
        pytest.skip(f"the authors' finite-element data are not there: {DATA}")
    with np.load(DATA) as data:
        return dict(data)


@pytest.fixture(scope="session")
def quiet_run() -> Callable[..., PlantParameters]:
    """Return a maker of plant parameters: at rest, wheels stopped, nothing dispersed, unless changed."""

    def make(matrices: PlantMatrices, **changes: object) -> PlantParameters:
        m, n = matrices.modes, matrices.wheels
        quiet = PlantParameters(
            mrp=np.zeros(3),
            rate=np.zeros(3),
            velocity=np.zeros(3),
            modal_displacement=np.zeros(m),
            modal_velocity=np.zeros(m),
            wheel_speed=np.zeros(n),
            wheel_angle=np.zeros(n),
            torque_limit=np.inf,
            frequency_dispersion=np.zeros(m),
            damping_dispersion=np.zeros(m),
            inertia_dispersion=np.zeros(3),
        )
        return replace(quiet, **changes)

    return make


@pytest.fixture(scope="session")
def flight() -> Callable[..., ControllerParameters]:
    """Return a maker of controller parameters: no delay, no feed-forward of jitter, unless changed."""

    def make(design: Design, **changes: object) -> ControllerParameters:
        wheel = design.config.wheel
        nominal = ControllerParameters(
            period=design.config.rates.controller,
            fine_sensor=False,
            feed_forward_jitter=False,
            smoothed=False,
            open_loop=False,
            torque_limit=wheel.torque_limit,
            speed_band=wheel.speed_band,
            authority=design.config.slew.authority,
            measurement_delay=0.0,
            actuation_delay=0.0,
            imbalance_force=wheel.imbalance_force,
            imbalance_torque=wheel.imbalance_torque,
        )
        return replace(nominal, **changes)

    return make
