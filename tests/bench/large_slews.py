"""Fly large slews on raised limits in the monolith, both layouts, and print how far from the command they end.

    python tests/bench/large_slews.py [angle in deg ...]

Each slew about an oblique axis, torque limit times 20 and speed band raised so that it lasts a minute or two; the error
is the RMS angle to the commanded attitude over the last 10 s, against the noise of the star tracker, 10 arcsec.
"""

from __future__ import annotations

import math
import sys
import time

import numpy as np

from flexsat.closed_loop import ClosedLoop
from flexsat.description.built_in import CONFIGURATIONS
from flexsat.design.chain import build_designs
from flexsat.parameters import ARCSECOND, DEGREE
from flexsat.runtime.prepared_controller import plan_slew
from flexsat.runtime.rotations import error_angle

AXIS = np.array([0.6, 0.64, 0.48])
REST = 25.0  # s after the slew
ATTITUDE, REFERENCE = "plant.attitude.mrp", "controller.reference.mrp"


def fly(designs, degrees: float) -> tuple[float, float, float]:
    """Return the end of the slew [s], the RMS error and the greatest deviation from the reference [rad]."""
    wheel, rotation = designs.corrected.config.wheel, degrees * DEGREE * AXIS
    limits = {
        "wheel.torque_limit": 20.0 * wheel.torque_limit,
        "wheel.speed_band": wheel.speed_band * (1.0 + 2.0 * degrees),
    }
    command = {"command.rotation": tuple(rotation), "command.start_time": 1.0, "jitter.feed_forward": False}
    loop = ClosedLoop(
        designs,
        {
            "plant": {"wheel.torque_limit": limits["wheel.torque_limit"]},
            "sensors": {"jitter.enabled": False},
            "controller": limits | command,
        },
    )
    end = plan_slew(loop.controller, rotation, 1.0).end
    stop = float(math.ceil(end + REST))
    run = loop.run(stop, [ATTITUDE, REFERENCE], record_ticks=10)
    commanded = np.tile(math.tan(0.25 * degrees * DEGREE) * AXIS, (len(run.time), 1))
    error = error_angle(run.signals[ATTITUDE], commanded)[run.time >= stop - 10.0]
    deviation = error_angle(run.signals[ATTITUDE], run.signals[REFERENCE])
    return end, float(np.sqrt(np.mean(error**2))), float(deviation.max())


def main() -> None:
    """Print a line for each layout and angle."""
    for name in CONFIGURATIONS:
        designs = build_designs(name)
        for degrees in [float(text) for text in sys.argv[1:]] or [1.0, 20.0, 90.0, 179.0]:
            began = time.process_time()
            end, error, deviation = fly(designs, degrees)
            cost = time.process_time() - began
            print(
                f"{name:12} {degrees:5.0f} deg, ends at {end:5.0f} s: error {error / ARCSECOND:6.2f} arcsec,"
                f" greatest deviation from the reference {deviation / ARCSECOND:6.2f} arcsec ({cost:.0f} s of CPU)",
                flush=True,
            )


if __name__ == "__main__":
    main()
