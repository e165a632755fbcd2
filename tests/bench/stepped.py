"""Time of 300,000 steps from Python over that of one call, for two small FMUs and, with --loop, for flexsat's loop.

`python tests/bench/stepped.py [STEPS] [--loop SYSTEM.ssd]`. One call is `run.run_until(t)`, steps are `run.step()`;
both take turns on runs of the same system, in memory, and the quickest of three rounds counts. Then what a step costs
with a value read and one set, and what a snapshot and its restoring take. Nothing passes or fails here.
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

ROUNDS = 3
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


def measure(system: System, steps: int, read: str, write: str | None, tick: str) -> None:
    """Print the times of a system."""
    stop = steps * system.tick / 1e9
    calls, single, used = [], [], []
    for _ in range(ROUNDS):
        with lockstep.open(system, stop_time=stop, tick=tick) as run:
            started = perf_counter()
            run.run_until(stop)
            calls.append(perf_counter() - started)
        with lockstep.open(system, stop_time=stop, tick=tick) as run:
            started = perf_counter()
            for _ in range(steps):
                run.step()
            single.append(perf_counter() - started)
        with lockstep.open(system, stop_time=stop, tick=tick) as run:
            count = steps // 10
            started = perf_counter()
            for _ in range(count):
                run.step()
                value = run[read]
                if write is not None:
                    run.set(write, value)
            used.append((perf_counter() - started) * steps / count)
            state = 0.0
            with suppress(InputError):  # of FMUs without states
                started = perf_counter()
                for _ in range(10):
                    run.restore(run.snapshot())
                state = (perf_counter() - started) / 10
    one, stepped, exchanged = (min(times) for times in (calls, single, used))
    print(f"{system.name}, tick in {tick}: {steps} ticks")
    print(f"  one call          {one / steps * 1e6:8.3f} us a tick")
    print(f"  step()            {stepped / steps * 1e6:8.3f} us a tick   {stepped / one:.2f} x one call")
    what = "a value read" + (" and one set" if write else "")
    print(f"  step(), {what:24}{exchanged / steps * 1e6:8.3f} us a tick")
    if state:
        print(f"  snapshot and restore {state * 1e3:8.3f} ms")


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
