"""Run several branches of one checkpoint in parallel, each with values of its own."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from itertools import product
from pathlib import Path
from typing import Any

from lockstep import InputError
from lockstep.checkpoint.file import read_checkpoint
from lockstep.checkpoint.rebuild_system import system_of
from lockstep.checkpoint.restart import Restart

from .jobs import Finished, Job, run_jobs

_MOST = 1000  # runs; more is a typing error


def run_branches(
    checkpoint: Path,
    runs: Mapping[str, Mapping[str, Any]],
    folder: Path,
    *,
    stop_time: float | None = None,
    reinitialised: Sequence[str] = (),
    record: Sequence[str] | None = None,
    processes: int | None = None,
) -> list[Finished]:
    """Run branches of one checkpoint in parallel processes, each into a folder of its own.

    Parameters
    ----------
    checkpoint : file that a run with checkpoints left
    runs : what to change, by the name of the folder: unconnected inputs, tunable parameters, and any
        parameter of a reinitialised component, as `component.name`
    folder : to hold the folders of the runs
    stop_time : [s]; None: that of the checkpointed run
    reinitialised : components that do not take their state from the checkpoint
    record : as in `lockstep.simulation`
    processes : at once; None: one a core

    Raises
    ------
    InputError
        If a run cannot start from the checkpoint. None has started then.
    RunError
        If one fails. The others are stopped, and what they simulated stays readable.
    """
    restart = Restart(checkpoint=read_checkpoint(checkpoint), reinitialised=tuple(reinitialised))
    system = system_of(restart.checkpoint.run)
    for name, values in runs.items():
        try:
            restart.check(restart.plan(system, stop_time, values, record)[0])
        except InputError as error:
            raise InputError(f"{name}: {error}") from None
    jobs = [
        Job(
            system=None,
            folder=folder / name,
            overrides=values,
            stop_time=stop_time,
            record=record,
            metrics=False,
            checkpoint=checkpoint,
            reinitialised=tuple(reinitialised),
        )
        for name, values in runs.items()
    ]
    return run_jobs(jobs, processes)


def varied(texts: Sequence[Sequence[str]], sets: Mapping[str, str]) -> dict[str, dict[str, str]]:
    """Return the parameters of all combinations of values, by a folder name that contains them.

    Parameters
    ----------
    texts : each a parameter and its values
    sets : values that all runs have

    Raises
    ------
    InputError
        If a parameter has no values or comes twice, or there are too many combinations.
    """
    for key, *values in texts:
        if not values or "=" in key:
            raise InputError(f"--vary {' '.join([key, *values])}: write COMPONENT.PARAMETER VALUE VALUE ...")
        if key in sets or [other for other, *_ in texts].count(key) > 1:
            raise InputError(f"--vary {key}: is given twice; give its values once")
    names = [text[0] for text in texts]
    runs: dict[str, dict[str, str]] = {}
    for combination in product(*(dict.fromkeys(text[1:]) for text in texts)):
        chosen = dict(zip(names, combination, strict=True))
        runs[",".join(f"{_short(key)}={_short(value)}" for key, value in chosen.items())] = {**sets, **chosen}
        if len(runs) > _MOST:
            raise InputError(f"--vary: more than {_MOST} combinations; choose fewer values")
    return runs


def _short(text: str) -> str:
    return re.sub(r"[^\w.+-]", "_", re.sub(r"\[(\d+)\]", r".\1", text))
