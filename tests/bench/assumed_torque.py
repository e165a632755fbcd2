"""Fly the external torque that the filter of torque and gyro biases assumes, white noise and a random walk, and judge.

    python tests/bench/assumed_torque.py torque.parquet --duration 1440
    flexsat health fmus/centralised/fine_pointing.ssd --input torque.parquet --stop-time 1440 --out results/walk \\
        --set controller.filter.disturbance=true
    python tests/bench/assumed_torque.py torque.parquet --duration 1440 --judge results/walk

The filter estimates the walk: `health` judges it against the whole torque of the file, white noise included, `--judge`
against the walk alone. `--no-white` writes the walk alone.
"""

import argparse
from dataclasses import replace
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from flexbench.runs.run_folder import read_run
from flexbench.studies.health.analysis import analyse
from flexbench.studies.health.replay import replay
from flexbench.studies.health.study import table_rows
from flexsat.description.built_in import CONFIGURATIONS, configuration

STEP = 5e-3  # s, of the rows: that of the controller


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("file", type=Path)
    parser.add_argument("--duration", type=float, default=1440.0, help="s")
    parser.add_argument("--configuration", choices=CONFIGURATIONS, default="centralised")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--no-white", action="store_true")
    parser.add_argument("--judge", type=Path, metavar="FOLDER", help="of flexsat health with this file")
    asked = parser.parse_args()
    random, rows = np.random.default_rng(asked.seed), round(asked.duration / STEP) + 1
    weights = configuration(asked.configuration).weights
    white = weights.torque_noise / np.sqrt(STEP) * random.standard_normal((rows, 3))
    walk = weights.torque_walk * np.sqrt(STEP) * np.cumsum(random.standard_normal((rows, 3)), axis=0)
    if asked.judge is not None:
        judge(asked.judge, walk)
        return
    columns = {"time": STEP * np.arange(rows)}
    torque = walk if asked.no_white else white + walk
    columns |= {f"plant.external.torque[{axis + 1}]": torque[:, axis] for axis in range(3)}
    pq.write_table(pa.table(columns), asked.file)


def judge(folder: Path, walk: np.ndarray) -> None:
    """Print NEES of torque and biases of the runs of `flexsat health`, against the walk."""
    runs = {int(path.name.removeprefix("seed")): read_run(path) for path in sorted(folder.glob("seed*"))}
    replays = {}
    for seed, run in runs.items():
        found = replay(run, slow=True)  # against a constant torque of zero
        error = found.slow.error.copy()
        error[:, :3] -= walk[: len(error)]
        replays[seed] = replace(found, slow=replace(found.slow, error=error))
    for row in table_rows(analyse(replays, next(iter(runs.values())).design)):
        if row[0].startswith(("NEES external", "NEES gyro")):
            print("  ".join(row))


if __name__ == "__main__":
    main()
