"""`flexsat margins`: what the command does."""

from __future__ import annotations

import argparse
import sys
from dataclasses import replace
from pathlib import Path

from rich.console import Console
from rich.table import Table

from lockstep import load_system
from lockstep.cli.run_options import assignments, with_delays
from lockstep.system.component import Value

from ..figures import save_figure
from ..figures.margins import margin_figures
from ..studies.margins.estimate import COHERENT
from ..studies.margins.recognise import recognise, with_controller
from ..studies.margins.study import Settings, read_study, run_study
from ..studies.margins.tables import EXACT_HEADER, HEADER, Rows, exact_rows, explanation, margin_rows


def margins(options: argparse.Namespace) -> int:
    """Analyse and measure the margins of a system's loop; print the tables, leave JSON and figures."""
    system = with_delays(load_system(options.system), options.delay)
    if options.controller_fmu is not None:
        system = with_controller(system, options.controller, options.controller_fmu)
    overrides: dict[str, Value] = dict(assignments(options.set))
    if options.seed is not None:
        overrides |= {"plant.seed": options.seed, "sensors.seed": options.seed}
    loop = recognise(system, overrides, options.controller, options.plant, options.directions == "channels")
    settings = Settings(
        band=tuple(options.band) if options.band else None,
        length=options.length,
        settle=options.settle,
        periods=options.periods,
        lines=options.lines,
        amplitude=options.amplitude,
        quiet=options.quiet,
        zoom=options.zoom,
        overrides=overrides,
    )
    if options.slow_period is not None:
        loop = replace(loop, slow_period=options.slow_period)
    folder = options.out or Path("results", f"margins-{system.name}")
    say = lambda text: print(text, file=sys.stderr)  # noqa: E731
    run_study(loop, folder, settings, options.analytic_only, options.find_delay, say)
    content = read_study(folder)
    if exact_rows(content):
        _print(EXACT_HEADER, exact_rows(content))
    _print(HEADER, margin_rows(content))
    print(explanation(content))
    for name, figure in margin_figures(content, COHERENT).items():
        save_figure(figure, folder / "figures", name)
    print(f"margins.json and figures: {folder}")
    return 0


def _print(header: tuple[str, ...], rows: Rows) -> None:
    table = Table(*header)
    for row in rows:
        table.add_row(*row)
    console = Console()
    if not console.is_terminal:
        console.width = 170  # a pipe has no width of its own
    console.print(table)
