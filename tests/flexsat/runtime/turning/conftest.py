"""A spacecraft whose array turns, with a wheel and sensors on it, and one that stands still."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from flexsat.design.chain import plant_matrices
from flexsat.runtime.plant_parameters import PlantMatrices
from fmus.turning_array import spacecraft

SPEED = np.array([40.0, -60.0, 55.0, 30.0, -80.0])  # rad/s


@pytest.fixture(scope="session")
def at(tmp_path_factory: pytest.TempPathFactory) -> Callable[..., PlantMatrices]:
    """Return a maker of the plant that is built with the arrays that turn at some angles, in deg."""
    folder: Path = tmp_path_factory.mktemp("turning")

    def built(north: float, south: float = -15.0) -> PlantMatrices:
        return plant_matrices(spacecraft(folder, north, south), SPEED, 1e-3)

    return built
