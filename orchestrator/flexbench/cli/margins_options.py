"""The options of `flexsat margins`."""

from __future__ import annotations

import argparse
from pathlib import Path


def add_margin_options(parser: argparse.ArgumentParser) -> None:
    """Add the system and all options."""
    add = parser.add_argument
    add("system", type=Path, help="a .ssd file, an unpacked SSP folder, or a .ssp archive")
    add("--controller-fmu", type=Path, metavar="FMU", help="measure this controller instead of the system's")
    add("--analytic-only", action="store_true", help="only analyse the design, without a run")
    add("--find-delay", action="store_true", help="also bisect the delay that makes the co-simulation unstable")
    add("--quiet", action="store_true", help="without sensor noise and jitter")
    add("--seed", type=int, metavar="N", help="seed of plant and sensors")
    add("--set", action="append", default=[], metavar="C.P=V", help="set parameter P of component C")
    add("--delay", action="append", default=[], metavar="A:B=N", help="delay from A to B in ticks")
    add("--band", type=float, nargs=2, metavar="HZ", help="lowest and highest frequency of the test signal")
    add("--lines", type=int, metavar="N", help="number of frequencies (default: as many as find room)")
    add("--length", type=float, default=20.0, metavar="S", help="of a period of the test signal (default: 20)")
    add("--periods", type=int, default=4, metavar="N", help="periods to average (default: 4)")
    add("--settle", type=int, default=2, metavar="N", help="periods left out at the start (default: 2)")
    add("--zoom", type=float, default=0.0, metavar="N",
        help="measure again, with periods N times as long, where lines are too far apart")  # fmt: skip
    add("--amplitude", type=float, metavar="A", help="peak of the test signal (default: 40 %% of the torque limit)")
    add("--slow-period", type=float, metavar="S", help="of the slowest sampler in the loop (default: known for ours)")
    add("--directions", choices=("body", "channels"), default="body", metavar="KIND",
        help="body axes, or each input of the plant on its own (default: body where known)")  # fmt: skip
    add(
        "--controller", default="controller", metavar="NAME", help="component whose output is cut (default: controller)"
    )
    add("--plant", default="plant", metavar="NAME", help="component that it drives (default: plant)")
    add("--out", type=Path, metavar="DIR", help="results folder (default: results/margins-NAME OF THE SYSTEM)")
