"""The commanded attitude is the reference of a controller that outputs none."""

from __future__ import annotations

import math

import numpy as np
import pytest

from flexbench.runs.commands import Command, command_of, commanded_attitude
from lockstep import InputError

TIME = np.arange(4.0)
TURN = Command(time=2.0, rotation=(0.0, 0.0, 0.5))


def record(**parameters: object) -> dict[str, object]:
    """Return the part of run.toml that holds a controller's parameters."""
    return {"component": [{"name": "controller", "parameters": parameters}]}


def test_it_is_where_the_run_begins_and_turns_at_the_commanded_time():
    near, far = np.array([1e-6, 0.0, 0.0]), np.array([0.0, 0.0, math.tan(0.1)])
    turned = math.tan(0.125)

    assert not np.any(commanded_attitude(TIME, None, near))  # an error to regulate
    assert np.allclose(commanded_attitude(TIME, TURN, near)[:, 2], [0.0, 0.0, turned, turned], atol=1e-15)
    # about the same axis the angles add up: 0.4 and 0.5 rad
    assert np.allclose(commanded_attitude(TIME, TURN, far)[:, 2], np.tan([0.1, 0.1, 0.225, 0.225]), atol=1e-15)
    assert np.array_equal(commanded_attitude(TIME, None, far), np.tile(far, (4, 1)))


def test_the_command_is_that_of_the_record():
    given = record(**{"command.rotation[3]": 0.5, "command.start_time": 2.0})
    assert command_of(given, "controller") == TURN
    assert command_of(record(**{"command.rotation[3]": 0.0}), "controller") is None
    assert command_of(record(), "controller") is None
    with pytest.raises(InputError, match=r"the parameter command\.rotation\[3\] = 'x' must be a number"):
        command_of(record(**{"command.rotation[3]": "x"}), "controller")
