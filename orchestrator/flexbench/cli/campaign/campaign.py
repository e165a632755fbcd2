"""The command `flexsat campaign`."""

from __future__ import annotations

import sys
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import click

from lockstep.cli.command import command
from lockstep.cli.options import jobs_option, out_option, record_option
from lockstep.errors import InputError

if TYPE_CHECKING:
    from ...campaign.campaign import MakePool
    from ...engine.pools import Pool
    from ...engine.tasks import Settings

RERUN = "rerun"
_EXAMPLES = """
exit code: 0 all runs are there, also failed ones; 1 a disk is full or a cluster lost; 2 bad input;
130, 143 ended by Ctrl-C, SIGTERM. The same command goes on where it ended, whatever ended it.

examples:
  {program} campaign examples/campaigns/short.toml --out results/short
  {program} campaign examples/campaigns/layouts.toml --out results/layouts-1000 --scheduler tcp://127.0.0.1:8786
  {program} campaign rerun results/short 17                # with full recording, into results/short/runs/17
"""


@command("campaign", _EXAMPLES)
@click.argument("what", nargs=-1, required=True, metavar="CAMPAIGN.toml | rerun DIR NUMBER",
                help="campaign file; or `rerun`, the folder of a campaign and the number of a run")  # fmt: skip
@out_option("folder of the campaign (default: results/NAME of the file); of a repeated run (default: DIR/runs/NUMBER)")
@click.option("--scheduler", metavar="ADDRESS", help="Dask scheduler, tcp://HOST:PORT, instead of processes here")
@jobs_option
@record_option
def campaign(
    what: tuple[str, ...], out: Path | None, scheduler: str | None, jobs: int | None, record: tuple[str, ...] | None
) -> int:
    """Simulate thousands of runs over dispersed inputs, or repeat one of them."""
    if what[0] == RERUN:
        if scheduler is not None or jobs is not None:
            raise InputError("--scheduler, --jobs: have no effect on `rerun`; leave them out")
        return _rerun(what[1:], out, record or ())
    if len(what) > 1:
        raise InputError(f"{what[1]}: give one campaign file, or rerun DIR NUMBER")
    if record:
        raise InputError("--record: has an effect with `rerun` only; a campaign's file says what is recorded")
    if scheduler is not None and jobs is not None:
        raise InputError("--jobs: has no effect with --scheduler; the cluster's workers say how many run at once")
    return _run(Path(what[0]), out, _pool(scheduler, jobs))


def _pool(scheduler: str | None, jobs: int | None) -> MakePool:
    def make(settings: Settings) -> Pool:
        from ...engine.pools import DaskPool, LocalPool

        return LocalPool(settings, jobs) if scheduler is None else DaskPool(scheduler, settings)

    return make


def _run(path: Path, out: Path | None, make_pool: MakePool) -> int:
    from ...campaign.campaign import run_campaign

    folder = out or Path("results", path.stem)
    try:
        done = run_campaign(path, folder, make_pool, partial(print, flush=True))
    except KeyboardInterrupt:
        print(f"{folder}: what is finished is kept; the same command goes on", file=sys.stderr)
        raise
    failed = int((~done.results.completed).sum())
    print(f"{len(done.results.numbers)} runs, {failed} failed: {folder}")
    return 0


def _rerun(given: tuple[str, ...], out: Path | None, record: tuple[str, ...]) -> int:
    from ...campaign.rerun import rerun

    if len(given) != 2 or not given[1].isdecimal():
        raise InputError("rerun: give the folder of a campaign and the number of a run: rerun results/short 17")
    found = rerun(Path(given[0]), int(given[1]), out, record)
    for name, value in found.inputs.items():
        print(f"{name} = {value}")
    for name, number in found.metrics.items():
        print(f"{name}: {'none' if number is None else f'{number:.6g}'}")
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
