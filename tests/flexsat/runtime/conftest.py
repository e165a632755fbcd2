"""Runs of the plant that several files of tests make."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from flexsat.design.chain import Design
from flexsat.runtime import plant as stepper
from flexsat.runtime.plant_parameters import PlantMatrices, PlantParameters


def _inputs_of(spacecraft, torque, jitter, force, moment):
    """Return the stepper's inputs for wheel torque, jitter of the wheels, and loads at the body origin."""
    return np.concatenate([torque, spacecraft.wrench_of_jitter @ np.ravel(jitter), force, moment])


@pytest.fixture(scope="session")
def run() -> Callable[..., tuple[stepper.PlantState, stepper.PlantOutputs]]:
    """Return a function that steps through segments of (duration, inputs): state and outputs at the end."""

    def stepped(spacecraft, plant, segments):
        state = stepper.init(plant)
        for duration, held in segments:
            for _ in range(round(duration / plant.step_length)):
                outputs = stepper.step(plant, state, _inputs_of(spacecraft, *held))
        return state, outputs

    return stepped


@pytest.fixture(scope="session")
def rigid() -> Callable[[Design], PlantMatrices]:
    """Return a function that gives the plant's matrices with the modes uncoupled from the body."""

    def uncoupled(design):
        mass = design.plant.mass_matrix.copy()
        mass[:6, 6:], mass[6:, :6] = 0.0, 0.0
        return replace(design.plant, mass_matrix=mass)

    return uncoupled


@pytest.fixture(scope="session")
def turning(quiet_run) -> Callable[..., PlantParameters]:
    """Return a maker of parameters of a passive run: no net linear momentum, wheels at speed."""

    def make(design, amplitude, damped=True):
        rng = np.random.default_rng(7)
        m, n = design.plant.modes, design.plant.wheels
        velocity = amplitude * rng.standard_normal(m)
        return quiet_run(
            design.plant,
            rate=amplitude * np.array([0.02, -0.03, 0.01]),
            velocity=-design.spacecraft.translation @ velocity / design.spacecraft.mass,
            modal_displacement=amplitude * rng.standard_normal(m) / design.plant.frequency,
            modal_velocity=velocity,
            wheel_speed=rng.uniform(-40.0, 40.0, n),
            damping_dispersion=np.zeros(m) if damped else np.full(m, -1.0),
        )

    return make
