"""The example with a controller in Python in the loop: it points, and an episode is repeated bit by bit."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest

EXAMPLE = Path(__file__).parents[2] / "examples" / "stepped_controller.py"


@pytest.fixture(scope="module")
def example():
    spec = importlib.util.spec_from_file_location("stepped_controller", EXAMPLE)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_fine_pointing_holds_with_a_controller_in_python(example, delivered):
    """The same seed from the snapshot, which is quicker, and from a new run; another one differs."""
    environment = example.FinePointing(delivered / "centralised/native/fine_pointing.ssd", seconds=3.0)
    flights = []
    for seed in (1, 1, 2, 1):
        controller = example.ProportionalDerivative(environment.system)
        observation, _ = environment.reset(seed=seed)
        errors, over = [], False
        while not over:
            action = controller(observation)
            observation, reward, terminated, truncated, info = environment.step(action)
            np.testing.assert_array_equal(environment.run["plant.wheel.torque"], action)
            assert reward == -info["error_arcsec"]
            errors.append(info["error_arcsec"])
            over = terminated or truncated
        flights.append(errors)
    environment.close()

    assert not terminated
    assert len(flights[0]) == 600
    assert flights[0] == flights[1] == flights[3] != flights[2]
    assert max(map(max, flights)) < 0.3  # arcsec; without torque it drifts on
