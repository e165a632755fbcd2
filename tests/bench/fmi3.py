"""Compare closed loops of native FMUs of FMI 3.0 with those of FMI 2.0, bit by bit, and print the table.

python tests/bench/fmi3.py --fmus fmus [--duration 20]

`flexsat build --fmi3` makes the FMUs. One minute for 20 s of both layouts and both scenarios.
"""

import argparse
import tempfile
from pathlib import Path
from time import perf_counter

import numpy as np

from lockstep import load_system, read_signals, simulate

KINDS = ("native", "native/fmi3")


def loop(fmus, layout, scenario, duration):
    """Return the signals of each kind, and the seconds that each run took."""
    found, seconds = [], []
    for kind in KINDS:
        system = load_system(fmus / layout / kind / f"{scenario}.ssd")
        with tempfile.TemporaryDirectory(prefix="flexsat_bench_") as folder:
            begun = perf_counter()
            simulate(system, Path(folder) / "run", stop_time=duration, record=["all"], record_period=0.005,
                     overrides={"plant.seed": 3, "sensors.seed": 3})  # fmt: skip
            seconds.append(perf_counter() - begun)
            found.append(read_signals(Path(folder) / "run"))
    return found, seconds


def main():
    """Print a line for each loop; end with 1 if a bit differs."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--fmus", type=Path, default=Path("fmus"))
    parser.add_argument("--duration", type=float, default=20.0, help="s")
    given = parser.parse_args()
    print(
        "| layout | scenario | signals | rows | that differ | FMI 2.0, s | FMI 3.0, s |\n|---|---|---|---|---|---|---|"
    )
    worst = 0
    for layout in ("centralised", "distributed"):
        for scenario in ("fine_pointing", "slew"):
            (two, three), (first, second) = loop(given.fmus, layout, scenario, given.duration)
            assert two.columns.keys() == three.columns.keys()
            differ = sum(not np.array_equal(values, three[name]) for name, values in two.columns.items())
            row = (layout, scenario, len(two.columns), len(two.time), differ, f"{first:.1f}", f"{second:.1f}")
            print(f"| {' | '.join(map(str, row))} |", flush=True)
            worst = max(worst, differ)
    return int(worst > 0)


if __name__ == "__main__":
    raise SystemExit(main())
