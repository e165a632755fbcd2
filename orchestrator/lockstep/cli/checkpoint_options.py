"""Options of checkpoints: when to save a run, where to restart, what to reinitialise, and what to resume."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import click

from lockstep.cli.given_options import given_options, only_words, refuse_given
from lockstep.cli.options import option_group, reinitialise_option
from lockstep.cli.parameter_types import PATH
from lockstep.cli.usage_errors import option_name
from lockstep.errors import InputError
from lockstep.tick import IMPLEMENTATIONS

if TYPE_CHECKING:
    from lockstep.checkpoint.restart import Restart
    from lockstep.checkpoint.schedule import CheckpointSchedule
    from lockstep.results.monitor import Watch
    from lockstep.simulation import RunSummary
    from lockstep.system.system import System

_WITH_RESUME = {
    "resume",
    "pace",
    "realtime_priority",
    "core",
    "threads",
    "profile",
    "step_limit",
    "traceback",
}  # all else is as it was

_READS_A_FILE = {"within", "tick", "continuous", "sampled"}


@dataclass(frozen=True, slots=True, kw_only=True)
class CheckpointOptions:
    """When to save, where to restart, what to resume."""

    checkpoint: tuple[str, ...]
    checkpoint_every: str | None
    checkpoint_without: tuple[str, ...]
    resume: Path | None
    restart_from: Path | None
    reinitialise: tuple[str, ...]

    def schedule(self) -> CheckpointSchedule:
        """Return when to save."""
        from lockstep.checkpoint.schedule import CheckpointSchedule

        if self.checkpoint_without and not self.checkpoint and self.checkpoint_every is None:
            what = f"--checkpoint-without {self.checkpoint_without[0]}"
            raise InputError(f"{what}: needs --checkpoint S or --checkpoint-every S as well")
        return CheckpointSchedule(times=self.checkpoint, every=self.checkpoint_every, without=self.checkpoint_without)

    def restart(self) -> Restart | None:
        """Return the checkpoint to restart from, None for a run from the start; or raise InputError."""
        from lockstep.checkpoint.file import read_checkpoint
        from lockstep.checkpoint.restart import Restart

        if self.restart_from is None:
            if self.reinitialise:
                raise InputError(f"--reinitialise {self.reinitialise[0]}: needs --restart-from CHECKPOINT as well")
            return None
        return Restart(checkpoint=read_checkpoint(self.restart_from), reinitialised=self.reinitialise)

    def system(self, path: Path | None, load: Callable[[Path], System]) -> System:
        """Return the system that a path names, or else that of the checkpoint; or raise InputError."""
        from lockstep.checkpoint.file import read_checkpoint
        from lockstep.checkpoint.rebuild_system import system_of

        if path is not None:
            return load(path)
        if self.restart_from is None:
            raise InputError("name a system file; or give --restart-from CHECKPOINT, or --resume RESULTS; see --help")
        names = _READS_A_FILE - ({"tick"} if only_words("tick", IMPLEMENTATIONS) else set())
        refuse_given(names, "counts where a system file is read; name SYSTEM as well, or leave it out")
        return system_of(read_checkpoint(self.restart_from).run)


checkpoint_options = option_group(
    "checkpoints",
    CheckpointOptions,
    click.option("--checkpoint", multiple=True, metavar="S",
                 help="save the whole state at this time, as checkpoints/t=S.ckpt in the results folder"),
    click.option("--checkpoint-every", metavar="S", help="save also every S seconds of simulated time"),
    click.option("--checkpoint-without", multiple=True, metavar="C",
                 help="leave out component C, which cannot save its state"),
    click.option("--resume", type=PATH, metavar="RESULTS",
                 help="continue an interrupted run from its newest checkpoint; without SYSTEM"),
    click.option("--restart-from", type=PATH, metavar="CHECKPOINT",
                 help="start at a checkpoint, with results of its own; SYSTEM may be left out, faults are those "
                      "given here"),
    reinitialise_option,
)  # fmt: skip


def resume_run(
    folder: Path,
    *,
    pace: str | None,
    step_limit: str | None,
    realtime_priority: int | None = None,
    core: int | None = None,
    tick: str = "auto",
    threads: str | None = None,
    profile: bool = False,
    finish: Callable[[Path], None] = lambda _: None,
    watch: Watch | None = None,
) -> RunSummary:
    """Resume a run and print its summary; refuse options that would make it another run.

    `finish` is called with the folder at the end, while no other run can use that; `watch` as in `RunOptions`.
    """
    from lockstep.checkpoint.resume import resumable
    from lockstep.cli.progress import print_summary, print_warnings, show_progress
    from lockstep.results.results_folder import claim_earlier
    from lockstep.run.real_time_pacing import pacer_given
    from lockstep.simulation import resume
    from lockstep.system.clock import seconds

    for parameter in given_options():
        if parameter.name not in _WITH_RESUME and not (
            parameter.name == "tick" and only_words("tick", IMPLEMENTATIONS)
        ):
            remedy = "leave it out, or branch with --restart-from"
            raise InputError(f"{option_name(parameter)}: a resumed run continues unchanged; {remedy}")
    pacer = pacer_given(pace)
    with claim_earlier(folder) as claimed:
        checkpoint = resumable(folder)
        title, time = str(checkpoint.run["system"]["name"]), seconds(checkpoint.time)
        with show_progress(title, begin=time, pacer=pacer) as progress:
            summary = resume(
                claimed,
                progress=progress,
                step_limit=step_limit,
                pace=pacer,
                watch=watch,
                realtime_priority=realtime_priority,
                core=core,
                tick=tick,
                threads=threads,
                profile=profile,
            )
        print_warnings(summary.warnings)
        print_summary(summary, profile=profile)
        finish(claimed.path)
    return summary
