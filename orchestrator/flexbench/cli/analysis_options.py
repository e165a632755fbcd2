"""The options of `flexsat budget`, `spectra`, `shadow` and `waterfall`; no numpy, so that --help is quick."""

from __future__ import annotations

import argparse
from pathlib import Path

BUDGET_EXAMPLE = """flexsat budget results/run --requirements examples/requirements.toml
  flexsat budget --split fmus/distributed/fine_pointing.ssd --seed 1 --stop 300

requirements file, see examples/requirements.toml:
  [[requirement]]
  name = "exposure stability"
  index = "RPE"             # APE, MPE, RPE, PDE or PRE
  axis = "line_of_sight"    # x, y, z, line_of_sight or angle
  limit = 0.2
  unit = "arcsec"           # rad, mrad, urad, nrad, deg, arcmin, arcsec or mas
  level = 0.9973            # optional, as are window, separation (PDE) and observation (PRE) in seconds

exit codes: 0 all requirements pass, 1 one fails, 2 bad input"""

SHADOW_EXAMPLE = """flexsat shadow results/vendor

which a run with a shadow has left:
  flexsat run fmus/centralised/fine_pointing.ssd --stop 100 --out results/vendor \\
      --shadow controller=vendor.fmu --shadow-adapter vendor.toml --hand-over 50"""


def add_budget_options(parser: argparse.ArgumentParser) -> None:
    """Add the results or the system to split, and the windows."""
    add = parser.add_argument
    add("results", type=Path, nargs="*", metavar="RESULTS", help="folders of runs")
    add("--requirements", type=Path, metavar="FILE", help="TOML file of requirements to judge")
    add("--split", type=Path, metavar="SYSTEM", help="run a system with one source on at a time instead")
    add("--seed", type=int, default=1, metavar="N", help="with --split: seed of plant and sensors (default: 1)")
    add("--stop", type=float, default=300.0, metavar="S", help="with --split: simulated time (default: 300)")
    add("--out", type=Path, metavar="DIR", help="with --split: results folder (default: results/SYSTEM-split-seedN)")
    add("--jobs", type=int, metavar="N", help="with --split: processes at once (default: one a core)")
    add("--window", type=float, default=10.0, metavar="S", help="of the means: MPE, RPE, PDE, PRE (default: 10)")
    add("--separation", type=float, default=60.0, metavar="S", help="of the windows of PDE (default: 60)")
    add("--observation", type=float, default=50.0, metavar="S", help="compared by PRE (default: 50)")
    add("--level", type=float, action="append", metavar="P", help="share of times (default: 0.95 and 0.9973)")
    _add_since(parser)


def add_spectra_options(parser: argparse.ArgumentParser) -> None:
    """Add the results, resolution and confidence."""
    add = parser.add_argument
    add("results", type=Path, nargs="+", metavar="RESULTS", help="folders of runs")
    add("--resolution", type=float, metavar="HZ", help="noise bandwidth (default: 0.05, coarser for short runs)")
    add("--confidence", type=float, default=0.95, metavar="P", help="of the bounds (default: 0.95)")
    _add_since(parser)


def add_shadow_options(parser: argparse.ArgumentParser) -> None:
    """Add the results and the windows."""
    add = parser.add_argument
    add("results", type=Path, nargs="+", metavar="RESULTS", help="folders of runs with --shadow")
    add("--from", dest="since", type=float, metavar="S", help="leave out what is before (default: 0)")
    add("--window", type=float, metavar="S", help="of comparison: before the hand-over, and at the end (default: all)")


def add_waterfall_options(parser: argparse.ArgumentParser) -> None:
    """Add the system and the sweep."""
    add = parser.add_argument
    add("system", type=Path, help="one of our .ssd files; its loop is opened")
    add("--points", type=int, default=24, metavar="N", help="speeds (default: 24)")
    add("--stop", type=float, default=20.0, metavar="S", help="simulated time of each (default: 20)")
    add("--range", type=float, nargs=2, metavar="RPM", help="lowest and highest speed (default: all modes and bands)")
    add("--seed", type=int, default=1, metavar="N", help="seed of plant and sensors (default: 1)")
    add("--out", type=Path, metavar="DIR", help="results folder (default: results/CONFIGURATION-waterfall)")
    add("--jobs", type=int, metavar="N", help="processes at once (default: one a core)")


def _add_since(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--from", dest="since", type=float, metavar="S",
                        help="judge from here on (default: 150, or half of a run shorter than 200)")  # fmt: skip
