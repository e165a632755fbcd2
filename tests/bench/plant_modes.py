"""Cost of a step of the plant over its number of modes: `python tests/bench/plant_modes.py [--rounds 5]`.

Each layout with 25, 50, 100 and 198 modes, stepped in turn in one run; the quickest of the rounds counts. Aims: at most
1.2 of the dense plant of 25 modes that was before (it is not there to be measured), and in proportion to the modes.
"""

from __future__ import annotations

import argparse
import sys
from time import perf_counter

import numpy as np

from flexsat.closed_loop import port_values
from flexsat.description.built_in import CONFIGURATIONS, configuration
from flexsat.design.chain import build_design
from flexsat.parameters import ALL_MODES
from flexsat.ports import plant as ports
from flexsat.runtime import plant
from flexsat.runtime.plant_parameters import lowest_modes

COUNTS = (25, 50, 100, ALL_MODES)
STEPS = 3000


def prepared(name: str, modes: int) -> tuple[plant.PreparedPlant, plant.PlantState, np.ndarray]:
    """Return a plant of the lowest modes, its state, and inputs that excite it."""
    whole = build_design(configuration(name)).plant  # type: ignore[arg-type]
    matrices = lowest_modes(whole, modes)
    values = port_values("plant", ports.ports(whole), {})
    ready = plant.prepare(matrices, ports.parameters(matrices, values.__getitem__), matrices.step_size)
    inputs = 1e-3 * np.random.default_rng(1).standard_normal(ready.input_count)
    return ready, plant.init(ready), inputs


def main() -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=5)
    rounds = parser.parse_args().rounds
    print(f"{'layout':14s}{'modes':>7s}{'us a step':>12s}{'of 25 modes':>13s}")
    for name in CONFIGURATIONS:
        plants = {modes: prepared(name, modes) for modes in COUNTS}
        least = dict.fromkeys(COUNTS, float("inf"))
        for _ in range(rounds):
            for modes, (ready, state, inputs) in plants.items():
                begun = perf_counter()
                for _ in range(STEPS):
                    plant.step(ready, state, inputs)
                least[modes] = min(least[modes], (perf_counter() - begun) / STEPS)
        for modes, seconds in least.items():
            print(f"{name:14s}{modes:7d}{1e6 * seconds:12.1f}{seconds / least[COUNTS[0]]:13.2f}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
