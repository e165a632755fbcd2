"""The command `flexsat compare-layouts`."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path

import click

from lockstep.cli.command import command
from lockstep.cli.options import DISTINGUISHED, assignments, jobs_option, out_option, set_option, stop_time_option
from lockstep.cli.outcome import remark, show_table, wrote
from lockstep.cli.parameter_types import Number, OneOf
from lockstep.errors import InputError

from .options import SCENARIOS, fmus_option, python_option, seeds, seeds_option, spacecraft_option

_EXAMPLES = """
exit code: 0 the layouts are compared, 1 too many runs are lost to compare any, 2 bad input

example:
  {program} compare-layouts --seeds 12
  {program} compare-layouts --scenario fine_pointing --dispersion frequency=2 --dispersion inertia=5
  {program} compare-layouts --configuration one.toml --configuration other.toml
"""


@command("compare-layouts", _EXAMPLES, then="open {path} in a browser", tables=True)
@spacecraft_option
@click.option("--scenario", type=OneOf(SCENARIOS[:2]), multiple=True, metavar="NAME",
              help="slew or fine_pointing (default: both)")  # fmt: skip
@click.option("--dispersion", multiple=True, metavar="WHAT=PERCENT",
              help="largest error of the structure (default: frequency=5, damping=50, inertia=10)")  # fmt: skip
@seeds_option(8)
@stop_time_option(200.0)
@click.option("--settling-band", type=Number(above=0.0, most=648000.0), metavar="ARCSEC",
              help="settled below this pointing error, in arcsec (default: 5; fine sensor: 0.5)")  # fmt: skip
@set_option
@out_option(f"results folder (default: results/layouts{DISTINGUISHED})")
@fmus_option
@python_option
@jobs_option
def compare_layouts(
    configuration: tuple[str, ...],
    scenario: tuple[str, ...],
    dispersion: tuple[str, ...],
    seed_count: int,
    stop_time: float,
    settling_band: float | None,
    settings: tuple[str, ...],
    out: Path | None,
    fmus: Path,
    python: bool,
    jobs: int | None,
) -> int:
    """Compare centralised with distributed wheels, or two spacecraft, over the same model errors, with intervals."""
    from flexsat.parameters import ARCSECOND

    from ..figures.drawing import save_figure
    from ..figures.layouts import layouts_figure
    from ..loop.chosen_spacecraft import build_missing, choose
    from ..report import write_report
    from ..runs.study_folder import study_folder
    from ..studies.layouts import tables
    from ..studies.layouts.dispersions import dispersion_of
    from ..studies.layouts.plan import COMPARED, ComparisonPlan
    from ..studies.layouts.study import run_layouts

    chosen = choose(configuration, fmus)
    if len(chosen) != 2 or len({one.root for one in chosen}) != 1:
        raise InputError(
            f"--configuration {' '.join(one.name for one in chosen)}: give two spacecraft with FMUs in one folder, each"
            " with --configuration; `flexsat campaign` simulates any number of systems"
        )
    plan = ComparisonPlan(
        layouts=tuple(one.name for one in chosen),
        seeds=seeds(seed_count),
        dispersion=dispersion_of(percentages(dispersion)),
        duration={name: stop_time for name in COMPARED if name in (scenario or COMPARED)},
        band=None if settling_band is None else settling_band * ARCSECOND,
        overrides=assignments(settings),
    )
    for one in plan.duration:
        build_missing(chosen, one)
    with study_folder(out, "layouts") as folder:
        found = run_layouts(chosen[0].root, folder, plan, jobs, partial(print, flush=True), python)
        rows = tables.compare(found)
        show_table(tables.header(found), [tables.cells(row) for row in rows])
        remark(*map(tables.verdict, rows))
        if wheels := tables.wheel_rows(found):
            show_table(tables.wheels_header(found), wheels)
        remark(*tables.answer(found, rows), *tables.notes(found))
        save_figure(layouts_figure(found, rows), folder / "figures", "layouts")
        wrote(*write_report([folder], folder / "report.html"))
        print(f"layouts.txt, layouts.csv, layouts.json, figures and every run: {folder}")
    return 0 if any(row.contrast is not None for row in rows) else 1


def percentages(texts: Sequence[str]) -> dict[str, float]:
    """Return the numbers of texts such as `frequency=5`; InputError for any other text."""
    found = {}
    for text in texts:
        name, _, value = text.partition("=")
        try:
            found[name] = float(value)
        except ValueError:
            raise InputError(f"--dispersion {text}: must be WHAT=PERCENT, for example frequency=5") from None
    return found
