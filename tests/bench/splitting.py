"""Repeat splitting along time on two processes with known probabilities of 1e-5: bias, deviation, share of bounds.

python tests/bench/splitting.py --repeat 300
"""

import argparse
import math
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[2]))  # `tests` from its root

from tests.flexbench.campaign.statistics.test_splitting import (
    STEPS,
    Process,
    passage_of_relaxing,
    passage_of_walk,
    relaxing,
    walk,
)

from flexbench.campaign.statistics.splitting import splitting

TOYS = (("walk", walk, 33.5, passage_of_walk(34)), ("Ornstein-Uhlenbeck", relaxing, 5.0, passage_of_relaxing(5.0)))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repeat", type=int, default=300)
    parser.add_argument("--samples", type=int, default=250, help="runs at once")
    asked = parser.parse_args()
    for name, follow, threshold, exact in TOYS:
        found = [
            splitting(Process(follow), threshold, STEPS - 1, samples=asked.samples, seed=1 + k)
            for k in range(asked.repeat)
        ]
        estimates = np.array([one.probability for one in found]) / exact
        stated = np.array([one.deviation for one in found if math.isfinite(one.deviation)])
        bounds = np.array([one.bounds() for one in found])
        held = np.mean((bounds[:, 0] < exact) & (exact < bounds[:, 1]))
        runs, families = np.mean([one.runs for one in found]), np.median([one.families for one in found])
        error = estimates.std() / asked.repeat**0.5
        print(f"{name}: p {exact:.2g}, mean / p {estimates.mean():.2f} +- {error:.2f}, coefficient of variation"
              f" {estimates.std():.2f}, stated {np.median(stated):.2f} (median), {runs:.0f} runs, {families:.1f}"
              " equal families (median)")  # fmt: skip
        above, below = np.mean(bounds[:, 0] >= exact), np.mean(bounds[:, 1] <= exact)
        print(f"  95 % bounds hold in {100 * held:.1f} %, lie above in {100 * above:.1f} %, below in"
              f" {100 * below:.1f} %; {100 * np.mean(bounds[:, 1] == 1.0):.1f} % have none: one family")  # fmt: skip


if __name__ == "__main__":
    main()
