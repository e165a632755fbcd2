"""Plan random slews past keep-out cones, and print how many lead round them, how much farther, and what it costs.

    python tests/bench/slews_round_cones.py [commands]

Slews of up to 180 deg about any axis from any attitude, with one cone and with a second one of half its half-angle.
"""

from __future__ import annotations

import sys
import time

import numpy as np

from flexsat.arrays import Array
from flexsat.parameters import DEGREE
from flexsat.runtime.keep_out import keep_out, plan_legs

HALF_ANGLES = (5.0, 15.0, 30.0, 45.0, 60.0)  # deg


def angles(turns: Array) -> Array:
    """Return the angles of turns (m, 3) and 10 mrad for each stop, as a measure of time."""
    return np.asarray(np.linalg.norm(turns, axis=1) + 0.01)


def main() -> None:
    """Print a line for each half-angle and number of cones."""
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 1000
    print("half-angle  cones  refused  none found  direct  turns (mean, most)  angle over direct (mean, most)  ms")
    for half in HALF_ANGLES:
        for second in (0.0, 0.5 * half):
            rng = np.random.default_rng(1)
            inside, lost, direct, numbers, farther, seconds = 0, 0, 0, [1], [1.0], [0.0]
            for _ in range(count):
                cones = keep_out(rng.standard_normal(3), rng.standard_normal((2, 3)), np.array([half, second]) * DEGREE)
                attitude, rotation = rng.standard_normal(4), rng.standard_normal(3)
                attitude /= np.linalg.norm(attitude)
                rotation *= rng.uniform(0.0, np.pi) / np.linalg.norm(rotation)
                began = time.process_time()
                try:
                    turns = plan_legs(cones, attitude, rotation, angles)
                except ValueError as error:
                    inside += "within" in str(error)
                    lost += "within" not in str(error)
                    continue
                number = int(np.count_nonzero(np.any(turns, axis=1)))
                if number == 1:
                    direct += 1
                    continue
                seconds.append(time.process_time() - began)
                numbers.append(number)
                farther.append(float(np.linalg.norm(turns, axis=1).sum() / np.linalg.norm(rotation)))
            print(
                f"{half:7.0f} deg {1 + (second > 0.0):6d} {inside:8d} {lost:11d} {direct:7d}"
                f" {np.mean(numbers):10.2f} {max(numbers):7d} {np.mean(farther):18.2f} {max(farther):12.2f}"
                f" {1e3 * np.mean(seconds):8.1f}",
                flush=True,
            )


if __name__ == "__main__":
    main()
