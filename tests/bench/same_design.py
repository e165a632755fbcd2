"""Compare the designs that several kernels of OpenBLAS and thread counts give: `python tests/bench/same_design.py`.

A row for each environment: arrays that differ from those of the first, and the largest difference, over the largest
number of its array. All must be 0.
"""

import os
import pickle
import subprocess
import sys

import numpy as np

DESIGN = """
import pickle, sys
from flexsat.design.chain import as_arrays, build_designs
found = {}
for name in ("centralised", "distributed"):
    designs = build_designs(name)
    for variant in designs.variants:
        design = designs.variant(variant)
        for component in ("plant", "sensors", "controller"):
            found |= as_arrays(getattr(design, component), f"{name}.{variant.name}.{component}")
sys.stdout.buffer.write(pickle.dumps(found))
"""
KERNELS = ("Haswell", "Zen", "Sandybridge", "Nehalem", "Prescott")
ENVIRONMENTS = [
    {"OPENBLAS_NUM_THREADS": "1"},
    {"OPENBLAS_NUM_THREADS": "2"},
    *({"OPENBLAS_CORETYPE": kernel, "OPENBLAS_NUM_THREADS": "1"} for kernel in KERNELS),
    {"OPENBLAS_CORETYPE": "Prescott", "OPENBLAS_NUM_THREADS": "2", "NPY_DISABLE_CPU_FEATURES": "X86_V3"},
]


def designed(environment: dict[str, str]) -> dict[str, np.ndarray]:
    """Return the arrays of both designs, computed in a process with these variables."""
    done = subprocess.run(
        [sys.executable, "-c", DESIGN], env=os.environ | environment, check=True, stdout=subprocess.PIPE
    )
    found: dict[str, np.ndarray] = pickle.loads(done.stdout)
    return found


def main() -> int:
    """Print the table; return 1 if anything differs."""
    first, worst = designed(ENVIRONMENTS[0]), 0
    for environment in ENVIRONMENTS[1:]:
        other = designed(environment)
        differing = [name for name in first if first[name].tobytes() != other[name].tobytes()]
        spread = [np.abs(first[n] - other[n]).max() / np.abs(first[n]).max() for n in differing]
        text = " ".join(f"{key}={value}" for key, value in environment.items())
        print(f"{len(differing):4} of {len(first)} arrays, by {max(spread, default=0.0):.1e}   {text}")
        worst = max(worst, len(differing))
    return 1 if worst else 0


if __name__ == "__main__":
    sys.exit(main())
