"""The command `flexsat paper`."""

from __future__ import annotations

import sys
from pathlib import Path
from time import perf_counter

import click

from flexsat.parameters import RUN_DURATION
from lockstep.cli.command import command
from lockstep.cli.options import DISTINGUISHED, jobs_option, out_option, stop_time_option
from lockstep.cli.outcome import remark, show_table, wrote
from lockstep.errors import InputError

from .options import fmus_option, seeds, seeds_option

_EXAMPLES = """
exit code: 0 success, 1 a failed run, or native FMUs that differ from those in Python, 2 bad input

example:
  {program} paper --seeds 6 --corrected
"""


@command("paper", _EXAMPLES, then="open {path} in a browser", tables=True)
@click.option("--as-published", is_flag=True, help="only with the errors of the published release")
@click.option("--corrected", is_flag=True, help="only without them (default: both)")
@seeds_option(1)
@stop_time_option(RUN_DURATION)
@out_option(f"results folder (default: results/paper{DISTINGUISHED})")
@fmus_option
@jobs_option
@click.option("--margins", is_flag=True,
              help="also determine margins and spillover of each loop, for table and page (1 min)")  # fmt: skip
@click.option("--python", is_flag=True, help="omit the same runs through the FMUs in C")
def paper(
    as_published: bool,
    corrected: bool,
    seed_count: int,
    stop_time: float,
    out: Path | None,
    fmus: Path,
    jobs: int | None,
    margins: bool,
    python: bool,
) -> int:
    """Build the FMUs, simulate the paper's six runs, and compare the results with its table, and with native FMUs."""
    from flexsat.description.built_in import CONFIGURATIONS

    from ..loop.build import build_all
    from ..loop.build_options import ONLY_PYTHON, STANDARD
    from ..report.paper_pages import draw_paper, report_paper
    from ..runs.metrics import SETTLED_FROM
    from ..runs.study_folder import study_folder
    from ..studies.paper import design_margins, native_table, table
    from ..studies.paper.native import FILE, run_natively
    from ..studies.paper.native_table import objections
    from ..studies.paper.paper import failures_text, run_paper
    from ..studies.paper.published import JUDGED, VARIANTS

    wanted = [one for one in VARIANTS if (as_published if one == JUDGED else corrected)]
    chosen = wanted or list(VARIANTS)
    if not stop_time > SETTLED_FROM:
        raise InputError(f"--stop-time {stop_time:g}: the table refers to t > {SETTLED_FROM:g} s; simulate longer")
    started = perf_counter()
    with study_folder(out, "paper") as folder:
        (folder / FILE).unlink(missing_ok=True)  # of an earlier study
        lacking: list[str] = []
        without_margins: list[str] = []
        compared = None
        written: list[str] = []

        def show(line: str) -> None:
            written.append(line)
            if ".fmu " in line:  # what takes the time; `flexsat build` shows all
                print(line, flush=True)

        build_all(
            CONFIGURATIONS, fmus, show, options=ONLY_PYTHON if python else STANDARD, without_native=lacking.append
        )
        print(f"built in {perf_counter() - started:.1f} s: {len(written)} files in {fmus}")
        numbers = seeds(seed_count)
        results = run_paper(fmus, folder, chosen, numbers, stop_time, jobs)
        failed = [one.folder for one in results.failed]
        for name in CONFIGURATIONS:
            show_table(table.header(results), table.lines(results, name), table.title(name))
        remark(*table.footnotes(results))
        if lacking:
            print(f"no runs through native FMUs, as these cannot be built here: {lacking[0]}")
        elif not python:
            compared = run_natively(fmus, folder, chosen, numbers[0], stop_time, jobs, failed)
            show_table(native_table.RUN_HEADER, native_table.run_rows(compared), native_table.TITLE)
            if ports := native_table.port_rows(compared):
                show_table(native_table.PORT_HEADER, ports)
            remark(*native_table.remarks(compared))
        if not margins:
            design_margins.forget(folder)  # of an earlier study
        else:
            without_margins = design_margins.find_margins(fmus, folder, chosen, numbers[0], jobs)
            loops = design_margins.read_margins(folder)
            show_table(design_margins.HEADER, design_margins.rows(loops), design_margins.TITLE)
            remark(design_margins.EXPLANATION)
        print("\n".join(str(path) for path in draw_paper(folder, chosen, numbers[0], failed)))
        page = report_paper(folder, chosen, numbers[0], results.failed)
        if page is not None:
            wrote(page)
        files = ["table.txt", "table.md", "table.csv", "table.json", *([FILE] if compared else [])]
        print(f"{', '.join(files)} and every run: {folder}")
    wrong = [*failures_text(results), *without_margins, *(objections(compared) if compared else [])]
    for line in wrong:
        print(f"flexsat: {line}", file=sys.stderr)
    return 1 if wrong else 0
