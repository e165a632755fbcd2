"""Carry out one branch of a run in a worker process: follow other runs from saved states, then with new noise."""

from __future__ import annotations

import pickle
from collections import OrderedDict
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

import lockstep
from flexsat.arrays import Array
from lockstep.fmi.temporary_folder import temporary_folder
from lockstep.processes.cpu_affinity import own_thread
from lockstep.system.clock import SAME_TIME

from ...engine.content import File
from ..flight import Flown, options_of
from ..measure import rows_digest
from ..order import Order
from ..statistics.splitting import Path as RisingPath
from ..statistics.splitting import path_of

Lineage = tuple[tuple[int, int], ...]  # tick and seed of each run that is followed, the first from tick 0; itself last
MOST = 200_000_000  # bytes of saved states in a process


@dataclass(frozen=True, slots=True, kw_only=True)
class BranchOrder:
    """A branch, as it travels to a worker."""

    order: Order  # of the first run of its lineage
    lineage: Lineage
    seeds: tuple[str, ...]  # component.parameter that get the seeds
    metric: str  # of whose signal the largest or smallest value counts
    sign: float  # 1: the largest; -1: the smallest


class _States:
    """Saved states of this process, the longest unused ones dropped: without one, the run is simulated from before."""

    def __init__(self, most: int) -> None:
        self._most, self._size = most, 0
        self._states: OrderedDict[Any, bytes] = OrderedDict()

    def keep(self, key: Any, state: lockstep.Snapshot) -> None:
        if key not in self._states:
            self._states[key] = pickle.dumps(state)
            self._size += len(self._states[key])
        while self._size > self._most:
            self._size -= len(self._states.popitem(last=False)[1])

    def get(self, key: Any) -> lockstep.Snapshot | None:
        if key not in self._states:
            return None
        self._states.move_to_end(key)
        state: lockstep.Snapshot = pickle.loads(self._states[key])
        return state


_states = _States(MOST)


def fly_branch(branch: BranchOrder, paths: Mapping[File, Path]) -> Flown:
    """Simulate a branch from the state in which it leaves the run that it follows, to the stop time.

    Raises
    ------
    RunError, InputError
        If the run fails, or its parameters are refused.
    """
    order, lineage = branch.order, branch.lineage
    source = order.wanted.sources[branch.metric]
    first = {**order.overrides, **dict.fromkeys(branch.seeds, lineage[0][1])}
    order = replace(order, overrides=first, wanted=replace(order.wanted, record=(source.of,)))
    run_of = repr((order.system, sorted(order.overrides.items()), sorted(order.delays.items()), order.faults,
                   order.commands))  # fmt: skip
    with ExitStack() as stack:
        temporary = stack.enter_context(temporary_folder("campaign"))
        stack.enter_context(own_thread())
        system, options = options_of(order, paths, temporary)
        run = stack.enter_context(lockstep.open(system, None, options))
        begin = run.time
        _follow(run, run_of, lineage, branch.seeds)
        run.run_until(run.stop_time)
        signals = run.signals
    ticks = np.rint((signals.time - begin) / run.tick).astype(np.int64)
    rows = ticks >= lineage[-1][0]
    if not isinstance(source.window, str):
        rows &= (signals.time >= source.window[0] - SAME_TIME) & (signals.time < source.window[1] + SAME_TIME)
    values = np.asarray(signals[source.of], dtype=float)
    values = values if values.ndim == 1 else np.linalg.norm(values, axis=1)
    path = path_of(ticks[rows], branch.sign * values[rows])
    return Flown(
        metrics={branch.metric: branch.sign * path.largest if path.values else None},
        simulated_time=float(run.stop_time - begin - lineage[-1][0] * run.tick),
        rows_sha256=rows_digest(signals, list(signals.columns), signals.time[ticks >= lineage[-1][0]]),
        rises=packed_rises(path),
    )


def _follow(run: lockstep.Run, run_of: str, lineage: Lineage, seeds: Sequence[str]) -> None:
    """Bring a run to where the last noise of a lineage begins, from the latest state of it that is known here."""
    begin, now = 1, 0
    for depth in range(len(lineage) - 1, 0, -1):
        state = _states.get((run_of, lineage[:depth], lineage[depth][0]))
        if state is not None:
            run.restore(state)
            begin, now = depth, lineage[depth][0]
            break
    for depth in range(begin, len(lineage)):
        tick, seed = lineage[depth]
        if tick > now:
            run.step(tick - now)
            now = tick
            _states.keep((run_of, lineage[:depth], tick), run.snapshot())
        for name in seeds:
            run.set(name, seed)


def packed_rises(path: RisingPath) -> bytes:
    """Return a path as bytes: ticks, then values."""
    return np.array(path.ticks, dtype="<i8").tobytes() + np.array(path.values, dtype="<f8").tobytes()


def unpacked_rises(content: bytes) -> RisingPath:
    """Return the path of `packed_rises`."""
    half = len(content) // 2
    values: Array = np.frombuffer(content[half:], dtype="<f8")
    return RisingPath(ticks=tuple(np.frombuffer(content[:half], dtype="<i8").tolist()), values=tuple(values.tolist()))
