"""`flexsat health` and `flexsat robustness`: what the commands do."""

from __future__ import annotations

import argparse
import sys

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from flexsat.parameters import CONFIGURATIONS, configuration
from lockstep import InputError

from ..loop.build import build_all
from ..studies.health.study import HEADER, RESULT, run_health, table_rows
from ..studies.robustness import frequency_errors as frequency


def health(options: argparse.Namespace) -> int:
    """Fly seeds 1 to N, judge the estimator, print the table."""
    seeds = _seeds(options.seeds)
    found = run_health(options.system, options.out, seeds, options.stop, {}, options.jobs)
    from ..figures.drawing import save_figure
    from ..figures.health import estimator_health

    save_figure(estimator_health(found), options.out / "figures", "estimator-health")
    _print(HEADER, table_rows(found))
    white = found.whiteness
    print(
        f"innovations of seed {seeds[0]}: {100 * white.outside:.1f} % of the lags beyond the 95 % bound of white noise"
    )
    print(f"{RESULT}, figures and runs: {options.out}")
    return 0


def robustness(options: argparse.Namespace) -> int:
    """Fly errors of the modal frequencies; exit code 1 if a run is unstable."""
    names = tuple(options.configuration or CONFIGURATIONS)
    seeds = _seeds(options.seeds)
    levels = tuple(level / 100.0 for level in options.levels or (100.0 * each for each in frequency.LEVELS))
    frequency.check_plan(levels, options.stop)  # before anything is built
    missing = tuple(name for name in names if not (options.fmus / name / f"{options.scenario}.ssd").is_file())
    if missing:
        build_all(missing, options.fmus)
    modes = configuration(names[0]).plate.mode_count
    outcomes = frequency.run_robustness(
        options.fmus, options.out, names, options.scenario, levels, seeds, options.stop, modes, options.jobs
    )
    _print(frequency.HEADER, frequency.table_rows(outcomes))
    unstable = sum(not outcome.stable for outcome in outcomes)
    print(f"{unstable} of {len(outcomes)} runs unstable; worst of seeds {seeds[0]} to {seeds[-1]} in each row")
    if unstable:
        print("flexsat: the loop is not robust to these frequency errors", file=sys.stderr)
    return 1 if unstable else 0


def _seeds(count: int) -> range:
    if count < 1:
        raise InputError(f"--seeds {count}: must be 1 or more")
    return range(1, count + 1)


def _print(header: tuple[str, ...], rows: list[tuple[str, ...]]) -> None:
    table = Table(*map(escape, header))  # a unit in brackets is no markup
    for row in rows:
        table.add_row(*map(escape, row))
    console = Console()
    if not console.is_terminal:
        console.width = 120  # a pipe has no width of its own
    console.print(table)
