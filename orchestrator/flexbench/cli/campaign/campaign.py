"""The command `flexsat campaign`."""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from lockstep.cli.command import command
from lockstep.cli.options import jobs_option, out_option, record_option
from lockstep.cli.outcome import json_path_option
from lockstep.cli.parameter_types import NETWORK_ADDRESS
from lockstep.errors import InputError

from .evaluation import rare, report, say
from .kept_traceback import kept_traceback

if TYPE_CHECKING:
    from ...campaign.campaign import MakePool
    from ...engine.pools import Pool
    from ...engine.tasks import TaskSettings

RERUN, REPORT, RARE = "rerun", "report", "rare"
_EXAMPLES = """
exit code: 0 all runs are complete, failed ones included; 1 the disk is full or the cluster is lost; 2 bad input;
130, 143 ended by Ctrl-C, SIGTERM. The same command continues an interrupted campaign.

examples:
  {program} campaign examples/campaigns/short.toml --out results/short
  {program} campaign examples/campaigns/short.toml --stop-when "p95(pointing) within 5 %"
  {program} campaign examples/campaigns/layouts.toml --out results/layouts-1000 --scheduler tcp://127.0.0.1:8786
  {program} campaign rerun results/short 17                # with full recording, into results/short/runs/17
  {program} campaign report results/short                   # page and tables again; --json - prints all numbers
  {program} campaign rare examples/campaigns/wheel_speed.toml "speed > 44.841"
"""


@command("campaign", _EXAMPLES)
@click.argument("what", nargs=-1, required=True, metavar="CAMPAIGN.toml | rerun DIR NUMBER | ...",
                help="campaign file; `rerun`, the folder of a campaign and the number of a run; `report` and the"
                " folder; `rare`, a campaign file and an event")  # fmt: skip
@out_option("folder of the campaign (default: results/NAME of the file); of a repeated run (default: DIR/runs/NUMBER)")
@click.option(
    "--scheduler",
    type=NETWORK_ADDRESS,
    metavar="ADDRESS",
    help="Dask scheduler, tcp://HOST:PORT, instead of processes on this machine",
)
@jobs_option
@record_option
@click.option("--stop-when", metavar="RULE",
              help="end once there are enough runs: p95(METRIC) within 5 %, mean(METRIC) within 2 %,"
              " probability(REQUIREMENT) within 1 %, requirement(REQUIREMENT) decided; several with `and`")  # fmt: skip
@json_path_option("also write all numbers as JSON; - prints them instead")
def campaign(
    what: tuple[str, ...],
    out: Path | None,
    scheduler: str | None,
    jobs: int | None,
    record: tuple[str, ...] | None,
    stop_when: str | None,
    json: Path | None,
) -> int:
    """Simulate thousands of runs over dispersed inputs, repeat one, report all, or find how likely an event is."""
    given = {"--scheduler": scheduler, "--jobs": jobs, "--stop-when": stop_when, "--json": json, "--record": record}
    if what[0] == RERUN:
        _refuse(given, RERUN, ("--scheduler", "--jobs", "--stop-when", "--json"))
        return _rerun(what[1:], out, record or ())
    if what[0] == REPORT:
        _refuse(given, REPORT, ("--scheduler", "--jobs", "--stop-when", "--record"))
        return report(what[1:], out, json)
    if what[0] == RARE:
        _refuse(given, RARE, ("--stop-when",))
    elif len(what) > 1:
        raise InputError(
            f"{what[1]}: give one campaign file, or rerun DIR NUMBER, report DIR, rare CAMPAIGN.toml EVENT"
        )
    if record:
        raise InputError("--record: has an effect with `rerun` only; a campaign's file says what is recorded")
    if scheduler is not None and jobs is not None:
        raise InputError("--jobs: has no effect with --scheduler; the cluster's workers say how many run at once")
    if what[0] == RARE:
        return rare(what[1:], out, _pool(scheduler, jobs), json)
    return _run(Path(what[0]), out, _pool(scheduler, jobs), stop_when, json)


def _refuse(given: Mapping[str, object], word: str, names: Sequence[str]) -> None:
    """Raise InputError for options that have no effect."""
    if useless := [name for name in names if given[name]]:
        raise InputError(f"{', '.join(useless)}: no effect on `{word}`; leave it out")


def _pool(scheduler: str | None, jobs: int | None) -> MakePool:
    def make(settings: TaskSettings) -> Pool:
        from ...engine.pools import DaskPool, LocalPool

        return LocalPool(settings, jobs) if scheduler is None else DaskPool(scheduler, settings)

    return make


def _run(path: Path, out: Path | None, make_pool: MakePool, stop_when: str | None, json: Path | None) -> int:
    from ...campaign.campaign import run_campaign
    from ...campaign.campaign_file import read_campaign
    from ...campaign.stop import StopRule

    folder = out or Path("results", path.stem)
    show = say(json)
    rule = None if stop_when is None else StopRule(stop_when, read_campaign(path), show)
    with kept_traceback(folder):
        try:
            done = run_campaign(path, folder, make_pool, show, rule)
        except KeyboardInterrupt:
            print(f"{folder}: finished runs are kept; the same command continues", file=sys.stderr)
            raise
        failed = int((~done.results.completed).sum())
        if done.stopped:
            show(f"ended after {len(done.results.numbers)} runs: {stop_when}")
        show(f"{len(done.results.numbers)} runs, {failed} failed: {folder}")
        return report((str(folder),), None, json)


def _rerun(given: tuple[str, ...], out: Path | None, record: tuple[str, ...]) -> int:
    from ...campaign.rerun import rerun
    from ...campaign.statistics.tables import run_text

    if len(given) != 2 or not given[1].isdecimal():
        raise InputError("rerun: give the folder of a campaign and the number of a run: rerun results/short 17")
    found = rerun(Path(given[0]), int(given[1]), out, record)
    for name, value in found.inputs.items():
        print(f"{name} = {value} {found.units[name]}".rstrip())
    for metric, number in found.metrics.items():
        print(f"{metric.name}: {run_text(number, metric)}")
    if found.failure:
        print(f"run {found.number} fails as in the campaign: {found.failure}", file=sys.stderr)
        return 1
    if found.same is None:
        print(f"{found.folder}: the campaign has not simulated this run yet")
        return 0
    if found.same:
        print(f"{found.folder}: same rows as in the campaign")
        return 0
    reason = "the code of flexsat has changed since" if found.other_code else "that is a bug, or another processor"
    print(f"{found.folder}: its rows differ from those of the campaign: {reason}", file=sys.stderr)
    return 1
