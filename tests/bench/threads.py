"""Two FMUs in threads against the same two in turn: how many times as fast, over the length of their steps.

`python tests/bench/threads.py [ROUNDS]`, on a machine with two cores that are free; `chrt -f 1` before it keeps other
programs off them. Both ways take turns. Of each round the ratio of the two wall times is taken, and its median and the
best are printed. `forced` is `threads=2`, `auto` measures in the first 0.2 s which way is quicker. The aim: two FMUs
of 500 us at least 1.8 times as fast as in turn, and those of few us not slower. Nothing passes or fails here.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path
from statistics import median

sys.path.append(str(Path(__file__).parents[1]))
from fmus.busy_fmu import busy_fmu
from lockstep import Component, System, simulate

TICK = 1_000_000  # [ns]
LENGTHS = (0.0, 5.0, 20.0, 50.0, 100.0, 500.0, 2000.0)  # [us] of a step
DURATION = 0.6  # [s] on the wall clock of the way in turn, about


def system(fmu: Path, work: float) -> System:
    """Return the system of two FMUs without connections."""
    parts = tuple(
        Component(
            name=name, source=fmu, period=TICK, kind="sampled", isolated=False, parameters={"work": work, "gain": gain}
        )
        for name, gain in (("one", 2.0), ("two", 3.0))
    )
    return System(name="two", tick=TICK, components=parts, record=("one.y",))


def main(rounds: int) -> None:
    """Measure and print the table."""
    print(f"{'us a step':>10}{'us a tick in turn':>20}{'forced, median':>16}{'best':>8}{'auto, median':>14}{'best':>8}")
    with tempfile.TemporaryDirectory(prefix="flexsat_bench_") as folder:
        fmu = busy_fmu(Path(folder))
        for work in LENGTHS:
            two, ticks = system(fmu, work), round(DURATION * 1e6 / (2.0 * work + 1.0))
            ratios: dict[object, list[float]] = {2: [], "auto": []}
            times = []
            for _ in range(rounds):
                for threads, found in ratios.items():
                    # twice as long with `auto`, which begins in turn
                    scale = 3 if threads == "auto" else 1
                    turn, beside = (
                        simulate(two, Path(folder, "run"), stop_time=scale * ticks * TICK / 1e9, overwrite=True,
                                 threads=one).wall_time
                        for one in (1, threads)
                    )  # fmt: skip
                    times.append(turn / ticks / scale * 1e6)
                    found.append(turn / beside)
            print(f"{work:10g}{min(times):20.2f}" + "".join(f"{median(found):15.2f}x{max(found):7.2f}x"
                  for found in ratios.values()), flush=True)  # fmt: skip


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 5)
