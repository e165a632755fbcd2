"""The command `flexsat run`."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import click

from lockstep.cli.checkpoint_options import resume_run
from lockstep.cli.command import command
from lockstep.cli.options import assignments
from lockstep.cli.outcome import remark, show_table, wrote
from lockstep.cli.parameter_types import PATH, Number
from lockstep.cli.run_options import RunRequest, run_options, run_system
from lockstep.cli.timing_options import implementation
from lockstep.errors import InputError
from lockstep.faults import HELP

from .options import ACCEPT_INFEASIBLE, seed_option, seed_overrides, variant_option

if TYPE_CHECKING:
    from flexsat.variants import Variant
    from lockstep.simulation import RunSummary
    from lockstep.system.component import Value
    from lockstep.system.system import System

    from ..loop.scenarios import ScenarioName

_EXAMPLES = f"""
examples:
  {{program}} run fmus/distributed/slew.ssd --seed 3 --set plant.initial.mrp[1]=1e-6 --stop-time 200
  {{program}} run fmus/distributed/fine_pointing.ssd --faults examples/faults/star_tracker_outage.toml
  {{program}} run fmus/centralised/fine_pointing.ssd --set sensors.star_tracker.noise_fine=0.2arcsec --stop-time 60
  {{program}} run --restart-from results/slew/checkpoints/t=100.ckpt --out results/other
  {{program}} run fmus/distributed/slew.ssd --input examples/commands/three_slews.csv --stop-time 160
  {{program}} run fmus/distributed/slew.ssd --native
  {{program}} run fmus/centralised/missions/mission.ssd --native --mission examples/missions/short_day.toml

--native replaces every FMU; native="true" beside the period of a component in a system file replaces that one.

A row of an input file commands a slew from its time on: command.rotation (rad), from the end of the slew before, begins
at command.start_time, or at once if that has passed. A command that would begin during a slew is refused, or, with
--set controller.command.during_slew=replan, replaces it; one that begins after it waits. controller.keep_out.* keeps
an axis of the body, such as a boresight, outside up to two cones.

{HELP}"""


@command("run", _EXAMPLES, then="{program} report {path}    # a page with its plots", tables=True)
@run_options
@seed_option
@variant_option("with the errors of the published release")
@click.option("--settling-band", type=Number(above=0.0, most=648000.0), metavar="ARCSEC",
              help="settled below this pointing error, in arcsec (default: 5; fine sensor: 0.5)")  # fmt: skip
@click.option(ACCEPT_INFEASIBLE, "accept_infeasible", is_flag=True,
              help="run even if the slew does not fit the time or the wheels")  # fmt: skip
@click.option("--mission", type=PATH, metavar="FILE",
              help="timed commands, for a system with a mission manager: see docs/missions.md")  # fmt: skip
@click.option("--native", is_flag=True, help="use the FMUs in C, in native/ beside the others")
def run(
    request: RunRequest,
    seed: int | None,
    variant: Variant,
    settling_band: float | None,
    accept_infeasible: bool,
    mission: Path | None,
    native: bool,
) -> int:
    """Simulate a system and leave its signals, events and metrics in a results folder."""
    from ..runs.loop_monitor import print_found
    from ..runs.metrics_file import closing_table
    from ..runs.mission_monitor import print_mission, watch_run

    def finish(folder: Path) -> None:
        print_found(folder)
        print_mission(folder)
        header, rows, notes = closing_table(folder, settling_band)
        if rows:
            show_table(header, rows)
        remark(*notes)
        if request.profile:
            _draw_profile(folder)

    resumed = request.checkpoints.resume
    if resumed is not None:
        resume_run(
            resumed,
            pace=request.pace,
            step_limit=request.step_limit,
            realtime_priority=request.realtime_priority,
            core=request.core,
            tick=implementation(request.timing.tick),
            threads=request.threads,
            profile=request.profile,
            finish=finish,
            watch=watch_run,
        )
    else:
        _run_new(request, seed, variant, accept_infeasible, mission, native, finish)
    return 0


def _run_new(
    request: RunRequest,
    seed: int | None,
    variant: Variant,
    accept_infeasible: bool,
    mission: Path | None,
    native: bool,
    finish: Callable[[Path], None],
) -> RunSummary:
    from ..loop.feasibility import check_feasible
    from ..loop.fmu_choice import IN_C, kind_of
    from ..loop.missed_samples import refuse_missed_samples
    from ..loop.native_fmus import with_native_fmus
    from ..runs.mission_monitor import watch_run

    def load(path: Path) -> System:
        from lockstep.ssp.load import load_system

        if not path.exists() and path.suffix == ".ssd":
            raise InputError(f"{path}: no such file; `flexsat build` writes fmus/<configuration>/<scenario>.ssd")
        system = load_system(path, request.timing.timing(), request.within)
        if not native:
            return system
        system = with_native_fmus(system)
        kind = kind_of([system])
        if kind != IN_C:
            print(f"FMUs: {kind}")
        return system

    def overrides(system: System) -> dict[str, Value]:
        values: dict[str, Value] = dict(_settings(system, variant)) if variant.of_release else {}
        if seed is not None or request.checkpoints.restart_from is None:  # a restart keeps the seed of its run
            values |= seed_overrides(system, seed)
        if mission is not None:
            from ..loop.mission_file import mission_values

            values |= mission_values(system, mission)
        refuse_missed_samples(system, {**values, **assignments(request.settings)})
        return values

    if native and request.system is None:
        raise InputError("--native: a restart uses the FMUs of its run; name a system file, or leave --native out")
    marks = ("-native" if native else "") + variant.mark + ("" if seed is None else f"-seed{seed}")
    system = request.checkpoints.system(request.system, load)
    return run_system(request, system, overrides, marks=marks, finish=finish, watch=watch_run,
                      check=partial(check_feasible, accept=accept_infeasible))  # fmt: skip


def _draw_profile(folder: Path) -> None:
    """Draw where the wall time went, into the run's folder."""
    from lockstep.results.read_run_record import read_run_record

    from ..figures.drawing import save_figure
    from ..figures.profile import profile_figure

    for path in save_figure(profile_figure(read_run_record(folder)[0]), folder / "figures", "profile"):
        wrote(path)


def _settings(system: System, variant: Variant) -> Mapping[str, Value]:
    """Return the parameters of a variant for the scenario of a system."""
    from ..loop.scenarios import scalar_overrides, scenario_parameters

    return scalar_overrides(scenario_parameters(_scenario_of(system), variant))


def _scenario_of(system: System) -> ScenarioName:
    from ..loop.scenarios import SCENARIOS

    for scenario in sorted(SCENARIOS, key=len, reverse=True):
        if system.name.endswith(scenario.replace("_", "-")):
            return scenario
    raise InputError(f"--as-published: system {system.name} is none of the paper's; they end in slew, fine-pointing")
