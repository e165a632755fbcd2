"""The options of a run that save it, go on from what was saved, and hold it to the wall clock."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path

from lockstep.checkpoint.file import read_checkpoint
from lockstep.checkpoint.rebuild_system import system_of
from lockstep.checkpoint.restart import Restart
from lockstep.checkpoint.resume import resumable, resume
from lockstep.checkpoint.schedule import CheckpointSchedule
from lockstep.cli.progress import show_progress
from lockstep.errors import InputError
from lockstep.run.real_time_pacing import pacer_given
from lockstep.simulation import RunSummary
from lockstep.system.clock import seconds
from lockstep.system.system import System

_WITH_RESUME = {"command", "call", "resume", "pace", "step_limit"}  # all else is as it was


def add_checkpoint_options(parser: argparse.ArgumentParser) -> None:
    """Add them."""
    parser.add_argument("--checkpoint", action="append", default=[], metavar="S",
                        help="save everything at this time, in the results folder: checkpoints/t=S.ckpt")  # fmt: skip
    parser.add_argument("--checkpoint-every", metavar="S", help="and every so many seconds of simulated time")
    parser.add_argument("--checkpoint-without", action="append", default=[], metavar="C",
                        help="leave out component C, which cannot save its state")  # fmt: skip
    parser.add_argument("--resume", type=Path, metavar="RESULTS",
                        help="go on with a run that was killed, from its newest checkpoint; no SYSTEM")  # fmt: skip
    parser.add_argument("--from", dest="begin", type=Path, metavar="CHECKPOINT",
                        help="begin at a checkpoint, with results of its own; SYSTEM may be left out, "
                             "faults are those given here")  # fmt: skip
    parser.add_argument("--fresh", action="append", default=[], metavar="C",
                        help="let component C begin anew there: another FMU, or other fixed parameters")  # fmt: skip
    parser.add_argument("--pace", metavar="X", help="not faster than X times real time (default: as fast as possible)")


def checkpoints_told(options: argparse.Namespace) -> CheckpointSchedule:
    """Return when to save."""
    return CheckpointSchedule(
        times=options.checkpoint, every=options.checkpoint_every, without=tuple(options.checkpoint_without)
    )


def begin_told(options: argparse.Namespace) -> Restart | None:
    """Return where to begin, or raise InputError."""
    if options.begin is None:
        if options.fresh:
            raise InputError(f"--fresh {options.fresh[0]}: needs --from CHECKPOINT beside it")
        return None
    return Restart(checkpoint=read_checkpoint(options.begin), reinitialised=tuple(options.fresh))


def system_told(options: argparse.Namespace, load: Callable[[Path], System]) -> System:
    """Return the system that is named, or that of the checkpoint to begin at; or raise InputError."""
    if options.system is not None:
        return load(options.system)
    if options.begin is None:
        raise InputError("name a system file; or give --from CHECKPOINT, or --resume RESULTS; see --help")
    return system_of(read_checkpoint(options.begin).run)


def resume_as_told(options: argparse.Namespace) -> RunSummary:
    """Resume a run and print how it went; InputError if it is told to be another one."""
    for name, value in vars(options).items():
        if value and name not in _WITH_RESUME:
            option = "SYSTEM" if name == "system" else "--" + {"begin": "from"}.get(name, name).replace("_", "-")
            raise InputError(f"{option}: a resumed run goes on as it was; leave it out, or branch with --from")
    pacer = pacer_given(options.pace)
    checkpoint = resumable(options.resume)
    title, time = str(checkpoint.run["system"]["name"]), seconds(checkpoint.time)
    with show_progress(title, begin=time, pacer=pacer) as progress:
        summary = resume(options.resume, progress=progress, step_limit=options.step_limit, pace=pacer)
    print_summary(summary)
    return summary


def print_summary(summary: RunSummary) -> None:
    """Print how a run went."""
    simulated = summary.simulated_time - summary.start_time
    speed = simulated / max(summary.wall_time, 1e-9)
    begun = f", from {summary.start_time:g} s on" if summary.start_time else ""
    took = f"{simulated:g} s simulated{begun} in {summary.wall_time:.1f} s ({speed:.1f} x real time)"
    print(f"{took}: {summary.folder}")
    if summary.pacer is not None:
        print(summary.pacer)
