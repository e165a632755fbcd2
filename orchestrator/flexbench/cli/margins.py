"""The command `flexsat margins`."""

from __future__ import annotations

import dataclasses
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import click

from lockstep.cli.command import command
from lockstep.cli.given_options import refuse_given
from lockstep.cli.options import (
    DISTINGUISHED,
    adapter_option,
    assignments,
    delay_option,
    option_group,
    out_option,
    replace_option,
    set_option,
    system_argument,
)
from lockstep.cli.outcome import remark, show_table, wrote
from lockstep.cli.parameter_types import COUNT, DURATION, NUMBER, OneOf, Several, WholeNumber
from lockstep.cli.timing_options import with_delays

from .options import python_option, seed_option, seed_overrides

if TYPE_CHECKING:
    from lockstep.system.component import Value

    from ..studies.margins.study import MeasurementSettings

_EXAMPLES = """
exit code: 0 the loop is stable, 1 it is not, 2 bad input

example:
  {program} margins fmus/centralised/fine_pointing.ssd --find-delay
  {program} margins fmus/centralised/fine_pointing.ssd --replace controller=vendor.fmu --adapter vendor.toml
"""


@dataclass(frozen=True, slots=True, kw_only=True)
class MeasurementOptions:
    """How to measure, as the options of the command."""

    noise_free: bool
    band: tuple[float, float] | None
    lines: int | None
    length: float
    periods: int
    settle: int
    zoom: float
    amplitude: float | None

    def settings(self, overrides: dict[str, Value]) -> MeasurementSettings:
        """Return them as the study takes them."""
        from ..studies.margins.study import MeasurementSettings

        return MeasurementSettings(
            band=self.band,
            length=self.length,
            settle=self.settle,
            periods=self.periods,
            lines=self.lines,
            amplitude=self.amplitude,
            quiet=self.noise_free,
            zoom=self.zoom,
            overrides=overrides,
        )


measurement_options = option_group(
    "measurement",
    MeasurementOptions,
    click.option("--noise-free", is_flag=True, help="without sensor noise and jitter"),
    click.option("--band", type=NUMBER, nargs=2, metavar="LOW HIGH", help="frequencies of the test signal in Hz"),
    click.option("--lines", type=COUNT, metavar="N", help="number of frequencies (default: as many as possible)"),
    click.option("--length", type=DURATION, default=20.0, metavar="S", help="period of the test signal (default: 20)"),
    click.option("--periods", type=COUNT, default=4, metavar="N", help="periods to average (default: 4)"),
    click.option("--settle", type=WholeNumber(0, 1_000_000), default=2, metavar="N",
                 help="periods left out at the start (default: 2)"),
    click.option("--zoom", type=NUMBER, default=0.0, metavar="N",
                 help="measure again, with periods N times as long, where lines are too far apart"),
    click.option("--amplitude", type=NUMBER, metavar="A",
                 help="peak of the test signal (default: 40 % of the torque limit)"),
)  # fmt: skip


@command(
    "margins",
    _EXAMPLES,
    then="{program} robustness --vary frequency damping    # the errors of the structure that the loop tolerates",
    tables=True,
)
@system_argument
@replace_option
@adapter_option
@click.option("--analytic-only", is_flag=True, help="only analyse the design, without a run")
@click.option("--find-delay", is_flag=True, help="also find by bisection the delay that makes the loop unstable")
@click.option("--modes", type=Several(COUNT), metavar="N...",
              help="mode counts of the table of stability (default: 25 28 40 60 100 150, and all)")  # fmt: skip
@click.option("--gains", type=Several(NUMBER), metavar="DB...",
              help="gains of the table of stability in dB (default: -12 -6 -3 0 3 6 12)")  # fmt: skip
@seed_option
@set_option
@delay_option
@measurement_options
@click.option("--slow-period", type=DURATION, metavar="S",
              help="period of the slowest sampler in the loop (default: the star tracker's, where known)")  # fmt: skip
@click.option("--directions", type=OneOf(("body", "channels")), default="body", metavar="KIND",
              help="body axes, or channels: each input of the plant alone (default: body where known)")  # fmt: skip
@click.option("--controller", default="controller", metavar="NAME",
              help="component whose output is cut (default: controller)")  # fmt: skip
@click.option("--plant", default="plant", metavar="NAME", help="component that the controller drives (default: plant)")
@python_option
@out_option(f"results folder (default: results/margins-SYSTEM{DISTINGUISHED})")
def margins(
    system: Path,
    replace: tuple[str, ...],
    adapter: tuple[str, ...],
    analytic_only: bool,
    find_delay: bool,
    modes: tuple[int, ...] | None,
    gains: tuple[float, ...] | None,
    seed: int | None,
    settings: tuple[str, ...],
    delay: tuple[str, ...],
    measurement: MeasurementOptions,
    slow_period: float | None,
    directions: str,
    controller: str,
    plant: str,
    python: bool,
    out: Path | None,
) -> int:
    """Determine gain, phase, delay and disk margins of the design, and measure them through the FMUs."""
    from lockstep.adapter.component import replacements, with_replacements
    from lockstep.cli.run_options import folder_name
    from lockstep.plan.overrides import refuse_unknown
    from lockstep.plan.schedule import build_schedule
    from lockstep.ssp.load import load_system

    from ..figures.drawing import save_figure
    from ..figures.margins import margin_figures
    from ..loop.fmu_choice import choose_fmus
    from ..loop.missed_samples import refuse_missed_samples
    from ..runs.study_folder import study_folder
    from ..studies.margins.estimate import COHERENT
    from ..studies.margins.stability_table import GAINS, Grid, grid_header, grid_rows
    from ..studies.margins.study import FILE, read_study, run_study
    from ..studies.margins.system_loop import read_loop, with_controller
    from ..studies.margins.tables import (
        EXACT_HEADER,
        HEADER,
        exact_rows,
        explanation,
        limit_text,
        margin_rows,
        stability_text,
    )

    if analytic_only:
        names = {*MeasurementOptions.__dataclass_fields__, "seed", "python"}
        refuse_given(names, "has no effect on the design, which --analytic-only analyses; leave one of them out")
    grid = Grid(modes=modes, gains=gains or GAINS)
    loaded = with_delays(load_system(system), delay)
    build_schedule(loaded)  # refuses what cannot be stepped
    chosen = choose_fmus([loaded], python)
    loaded = chosen.of(loaded)
    if adapter:
        loaded = with_replacements(loaded, replace, adapter)
    else:
        for name, fmu in replacements(replace, loaded).items():
            loaded = with_controller(loaded, name, fmu)
    overrides = {**seed_overrides(loaded, seed), **assignments(settings)}
    refuse_unknown(overrides, loaded)  # before the analysis, which takes its time
    measured = measurement.settings(overrides)
    refuse_missed_samples(loaded, overrides)
    loop = read_loop(loaded, overrides, controller, plant, directions == "channels")
    if slow_period is not None:
        loop = dataclasses.replace(loop, slow_period=slow_period)
    default = f"margins-{folder_name(loaded.name)}" + ("" if seed is None else f"-seed{seed}")
    with study_folder(out, default) as folder:
        if not analytic_only:
            print(chosen.text, flush=True)
        run_study(loop, folder, measured, analytic_only, find_delay, _report_progress, grid)
        content = read_study(folder)
        unstable = "stability" in content and content["stability"]["growth"] >= 0.0
        if "stability" in content:
            grid = content["stability"]["grid"]
            show_table(grid_header(grid), grid_rows(grid))
            remark(stability_text(content))
        if exact_rows(content):
            show_table(EXACT_HEADER, exact_rows(content))
        if margin_rows(content):
            show_table(HEADER, margin_rows(content))
            remark(explanation(content), limit_text(content))
        for name, figure in margin_figures(content, COHERENT).items():
            save_figure(figure, folder / "figures", name)
        wrote(folder / FILE, folder / "figures")
    if unstable:
        print(f"flexsat: {stability_text(content)}", file=sys.stderr)
    return 1 if unstable else 0


def _report_progress(text: str) -> None:
    print(text, file=sys.stderr)
