"""Whether the torque declares that it depends on the wheels' angles: as the designs in the FMU use them."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from flexsat.design.chain import as_arrays
from flexsat.fmu.python.controller import Controller
from flexsat.runtime import controller as stepper
from flexsat.runtime.controller import Measurements


def cancelling(matrices, wanted):
    """Return the matrices with torques against the jitter, or without."""
    return replace(matrices, jitter_torque=np.full_like(matrices.jitter_torque, 1e-3 * wanted))


@pytest.mark.parametrize(("robust", "published"), [(True, False), (False, False), (False, True)])
def test_wheel_angles_are_declared_where_one_of_the_designs_answers_to_them(
    centralised, flight, tmp_path, robust, published
):
    designs = [cancelling(centralised.controller, one) for one in (robust, published)]
    names = ("corrected", "published")
    np.savez(tmp_path / "model.npz", **{key: value for one, name in zip(designs, names, strict=True)
                                        for key, value in as_arrays(one, name).items()})  # fmt: skip
    moved = []
    for matrices in designs:
        prepared = stepper.prepare(matrices, flight(centralised, feed_forward_jitter=True))
        n, g, k = prepared.wheels, matrices.gyros, matrices.accelerometers
        torques = [
            stepper.step(
                prepared,
                stepper.init(prepared, np.zeros(3), 10.0),
                0.0,
                Measurements(
                    gyro_rate=np.zeros(g),
                    accelerometer=np.zeros(k),
                    encoder_speed=matrices.nominal_speed.copy(),
                    encoder_angle=np.full(n, angle),
                    star_tracker_mrp=np.zeros(3),
                    star_tracker_valid=True,
                ),
            ).torque.copy()
            for angle in (0.0, 1.0)
        ]
        moved.append(not np.array_equal(*torques))

    shell = SimpleNamespace(resource=lambda name: tmp_path / name)
    (torque,) = [port for port in Controller.ports(shell) if port.name == "wheel.torque"]
    assert moved == [robust, published]
    assert ("encoder.angle" in torque.depends_on) == any(moved)
