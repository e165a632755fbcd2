"""Time of 300,000 steps from Python over that of one call, for two small FMUs and, with --loop, for flexsat's loop.

`python tests/bench/stepped.py [STEPS] [--loop SYSTEM.ssd]`. One call is `run.step(n)`, steps are `run.step()`; they
take turns on runs of the same system in memory, part by part, and the quickest part counts: a shared machine disturbs
both alike. Then what a step costs with a value read and set, and what a snapshot and its restoring take. Nothing passes
or fails here.
"""

from __future__ import annotations

import argparse
import os
import sys
import tempfile
from contextlib import suppress
from pathlib import Path
from time import perf_counter

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import lockstep
from lockstep import Component, Connection, InputError, System

sys.path[:0] = [str(Path(__file__).parent), str(Path(__file__).parents[1])]
from scaling import wide_fmu  # noqa: E402

PARTS = 300  # of the run, between which the ways of running take turns; the quickest of each counts
MS = 1_000_000  # [ns]


def pair(folder: Path) -> System:
    """Return two small FMUs that exchange ten signals, recorded every fifth tick."""
    fmu = wide_fmu(folder, 5)
    part = {"source": fmu, "period": MS, "kind": "sampled", "isolated": False}
    return System(
        name="pair",
        tick=MS,
        components=(Component(name="a", **part), Component(name="b", **part)),  # type: ignore[arg-type]
        connections=tuple(
            Connection(from_component=one, output=f"y[{k}]", to_component=other, input=f"u[{k}]", delay=1)
            for one, other in (("a", "b"), ("b", "a"))
            for k in range(1, 5)
        ),
        record_period=5 * MS,
    )


def measure(system: System, steps: int, read: str, write: str, tick: str) -> None:
    """Print the times of a system."""
    part = steps // PARTS
    stop = PARTS * part * system.tick / 1e9
    times: dict[str, list[float]] = {"one call": [], "step()": [], "step(), one value read and set": []}
    state = 0.0
    with (
        lockstep.open(system, stop_time=stop, tick=tick) as one,
        lockstep.open(system, stop_time=stop, tick=tick) as stepped,
        lockstep.open(system, stop_time=stop, tick=tick) as used,
    ):
        for number in range(1, PARTS + 1):
            marks = [perf_counter()]
            one.step(part)
            marks.append(perf_counter())
            for _ in range(part):
                stepped.step()
            marks.append(perf_counter())
            for _ in range(part // 10):
                used.step()
                used.set(write, used[read])
            marks.append(perf_counter())
            for name, begin, end, count in zip(times, marks[:-1], marks[1:], (part, part, part // 10), strict=True):
                times[name].append((end - begin) / count)
            if number == 1:
                with suppress(InputError):  # of FMUs without states
                    for _ in range(10):
                        started = perf_counter()
                        one.restore(one.snapshot())
                        state = min(state or 1.0, perf_counter() - started)
    print(f"{system.name}, tick in {tick}: {PARTS * part} ticks")
    best = {name: min(found) for name, found in times.items()}
    for name, each in best.items():
        print(f"  {name:32}{each * 1e6:9.3f} us a tick{each / best['one call']:8.2f} x one call")
    if state:
        print(f"  {'snapshot and restore':32}{state * 1e3:9.3f} ms")


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("steps", nargs="?", type=int, default=300_000)
    parser.add_argument("--loop", type=Path, help="a system file of flexsat, for a tenth of the steps")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="flexsat_bench_") as temporary:
        for tick in ("c", "python"):
            measure(pair(Path(temporary)), given.steps, "a.y[1]", "a.u[5]", tick)
    if given.loop is not None:
        measure(lockstep.load_system(given.loop), given.steps // 10, "plant.rate", "plant.external.torque", "c")


if __name__ == "__main__":
    main()
