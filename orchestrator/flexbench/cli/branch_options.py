"""The options of `flexsat branch`, apart from what it does: --help shall not wait for numerics."""

import argparse
from pathlib import Path

BRANCH_EXAMPLE = "flexsat branch results/slew/checkpoints/t=100.ckpt --vary plant.wheel.friction_torque[3] 0 0.01 0.05"


def add_branch_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of `flexsat branch`."""
    parser.add_argument("checkpoint", type=Path, help="a .ckpt file, which `flexsat run --checkpoint` leaves")
    parser.add_argument("--vary", action="append", nargs="+", required=True, metavar=("C.P", "VALUE"),
                        help="values of an input or tunable parameter; of several, all combinations")  # fmt: skip
    parser.add_argument("--set", action="append", default=[], metavar="C.P=V", help="a value that all runs have")
    parser.add_argument("--fresh", action="append", default=[], metavar="C",
                        help="let component C begin anew, then also with other fixed parameters: a seed")  # fmt: skip
    parser.add_argument("--stop", type=float, metavar="S", help="stop time in seconds (default: as it was)")
    parser.add_argument("--record", action="append", metavar="PATTERN", help="outputs to record, or all")
    parser.add_argument("--out", type=Path, default=Path("results/branch"), metavar="DIR",
                        help="folder for those of the runs (default: results/branch)")  # fmt: skip
    parser.add_argument("--jobs", type=int, metavar="N", help="processes at once (default: one a core)")
