"""Cost of isolation: us a step and component, with the FMUs in processes of their own against in the master's process.

`python tests/bench/isolation.py [STEPS]`. All inputs are set and all outputs fetched at each step. Both ways take turns
in short blocks. Of the single steps the quickest tenth, the median and the slowest tenth are printed, which shows what
else the machine does. The aim is below 60 us more. Nothing passes or fails here. First each component is isolated
alone, then all of a system, stepped in turn; then two isolated ones, one after the other and side by side: plants,
whose steps are shorter than waking a core takes, and two in C with longer ones; whole runs with all components
isolated and none; at last small compiled FMUs with both ticks.
"""

from __future__ import annotations

import os
import sys
import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from time import perf_counter

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np

from lockstep.fmi.instantiate import instantiate
from lockstep.fmi.model_description import Description, read_description
from lockstep.fmi.slave import DTYPES, SCALARS, Slave
from lockstep.processes.remote_slave import RemoteSlave
from lockstep.system.component import Component
from lockstep.system.system import System

CONFIGURATION, SCENARIO, AIM = "distributed", "fine_pointing", 60.0  # [us]
DURATION, ROUNDS = 30.0, 3  # [s] of whole runs
BLOCK, LONG_BLOCK = 100, 1000  # steps; in a long one the master finds out what pays

Parts = tuple[Callable[[int], None], Callable[[], None]]  # called with the number of the step


def bound(slave: Slave, description: Description, period: float) -> Parts:
    """Initialise a slave; return a call that sets all inputs and begins a step, and one that fetches all outputs."""
    slave.setup_experiment(0.0, 1e6)
    slave.enter_initialization()
    puts, gets = [], []
    for scalar in SCALARS:
        for causality, calls in (("input", puts), ("output", gets)):
            named = [v for v in description.variables.values() if (v.type, v.causality) == (scalar, causality)]
            references = np.array([v.reference for v in named], np.uint32)
            buffer = np.zeros(len(named), DTYPES[scalar])
            if named:
                slave.getter(scalar, references, buffer)()  # inputs keep their start values
                calls.append((slave.setter if causality == "input" else slave.getter)(scalar, references, buffer))
    slave.exit_initialization()
    do_step = slave.do_step

    def begin(number: int) -> None:
        for put in puts:
            put()
        do_step(number * period, period, 1)

    def finish() -> None:
        for get in gets:
            get()

    return begin, finish


def side_by_side(parts: list[Parts], first: int, count: int) -> list[float]:
    """Return what each step of a block takes [us]: all begin, then all are finished."""
    found = []
    for k in range(first, first + count):
        started = perf_counter()
        for begin, _ in parts:
            begin(k)
        for _, finish in parts:
            finish()
        found.append((perf_counter() - started) * 1e6)
    return found


def in_turn(parts: list[Parts], first: int, count: int = BLOCK) -> list[float]:
    """Return what each round of a block takes [us]: one after the other begins and is finished."""
    found = []
    for k in range(first, first + count):
        started = perf_counter()
        for begin, finish in parts:
            begin(k)
            finish()
        found.append((perf_counter() - started) * 1e6)
    return found


@contextmanager
def opened(kind: Callable[..., Slave], components: Sequence[Component]) -> Iterator[list[Parts]]:
    """Open components, all initialised; close them at the end."""
    slaves: list[Slave] = []
    with tempfile.TemporaryDirectory(prefix="flexsat_bench_") as folder:
        try:
            parts = []
            for component in components:
                description = read_description(component)
                slave = kind(component, description, Path(folder, str(len(slaves))), lambda *_: None)
                slaves.append(slave)
                parts.append(bound(slave, description, component.period / 1e9))
            yield parts
        finally:
            for slave in slaves:
                slave.close()


def print_row(name: str, one: list[float], two: list[float], steps: int) -> None:
    """Print a row: both ways at the three shares, and the difference for each of so many steps."""
    (low, middle, high), (low_two, middle_two, high_two) = (np.percentile(way, (10, 50, 90)) for way in (one, two))
    more = ((low_two - low) / steps, (middle_two - middle) / steps, (high_two - high) / steps)
    print(f"{name:12}{low:8.1f}{middle:8.1f}{high:8.1f}  {low_two:8.1f}{middle_two:8.1f}{high_two:8.1f}  "
          + "".join(f"{value:8.1f}" for value in more), flush=True)  # fmt: skip


def main(steps: int) -> None:
    """Measure and print the tables."""
    from flexbench.loop.build import build_all
    from flexbench.loop.build_options import ONLY_PYTHON
    from lockstep import load_system

    with tempfile.TemporaryDirectory(prefix="flexsat_bench_") as folder:
        build_all((CONFIGURATION,), Path(folder), options=ONLY_PYTHON)
        components = load_system(Path(folder, CONFIGURATION, f"{SCENARIO}.ssd")).components
        print(f"\n{CONFIGURATION}, us a step: the quickest tenth, the median and the slowest tenth of {steps} steps")
        print(f"{'component':12}{'shared':>16}{'':8}  {'isolated':>16}{'':8}  {'more':>16}   (aim: below {AIM:g} more)")
        for name, chosen in [*((c.name, [c]) for c in components), ("all in turn", list(components))]:
            ways: list[list[float]] = [[], []]
            with opened(instantiate, chosen) as shared, opened(RemoteSlave, chosen) as isolated:
                for first in range(0, steps, BLOCK):
                    for way, parts in zip(ways, (shared, isolated), strict=True):
                        way += in_turn(parts, first)
            print_row(name, *ways, len(chosen))
        pairs(next(component for component in components if component.kind == "continuous"), steps)
        working = Component(
            name="those that work 500 us",
            source=working_fmu(Path(folder, "working")),
            period=10_000_000,
            kind="sampled",
        )
        pairs(working, steps)
        runs(load_system(Path(folder, CONFIGURATION, f"{SCENARIO}.ssd")), Path(folder, "run"))
        small_steps(Path(folder))


def pairs(component: Component, steps: int) -> None:
    """Print what a step of two isolated ones takes [us], one after the other and side by side."""
    ways: list[list[float]] = [[], []]
    with opened(RemoteSlave, [component, component]) as pair:
        for first in range(0, 2 * steps, 2 * LONG_BLOCK):
            ways[0] += in_turn(pair, first, LONG_BLOCK)
            ways[1] += side_by_side(pair, first + LONG_BLOCK, LONG_BLOCK)
    print(f"two of {component.name}, one after the other and side by side")
    for words, at in (("quickest tenth", 10), ("median", 50)):
        after, beside = (float(np.percentile(way, at)) for way in ways)
        print(f"{words:16}{after:9.1f}{beside:10.1f}{after / beside:8.2f} x", flush=True)


def working_fmu(folder: Path) -> Path:
    """Compile the FMU whose steps are worth a core of their own."""
    sys.path.append(str(Path(__file__).parents[1]))
    from fmus.bad.bad_fmus import bad_fmu

    return bad_fmu(folder, "WORKS_LONG")


def runs(system: System, out: Path) -> None:
    """Print what whole runs take [s], none and all isolated in turn, and the difference for each step."""
    from lockstep import simulate

    alone = replace(system, components=tuple(replace(part, isolated=True) for part in system.components))
    count = sum(round(DURATION * 1e9) // part.period for part in system.components)
    for _ in range(ROUNDS):
        times = [simulate(way, out, stop_time=DURATION, overwrite=True).wall_time for way in (system, alone)]
        print(f"a run of {DURATION:g} s with {count} steps: {times[0]:.2f} s, all isolated {times[1]:.2f} s, "
              f"{(times[1] - times[0]) / count * 1e6:.1f} us more a step", flush=True)  # fmt: skip


def small_steps(folder: Path) -> None:
    """Print what a tick of small compiled FMUs takes, in the process, in their own and in one, with both ticks."""
    from scaling import TICK, WIDTH, write_ring

    from lockstep import load_system, simulate

    print("a tick of small compiled FMUs, us with the tick in Python and in C")
    for count in (2, 6):
        ring = load_system(write_ring(folder / f"ring{count}", count, WIDTH))
        for words, isolated in (("in the process", False), ("in their own", True), ("in one, if > 4", None)):
            chosen = replace(ring, components=tuple(replace(c, isolated=isolated) for c in ring.components))
            stop = (4000 if isolated is not False else 20_000) * TICK / 1e9
            found = []
            for tick in ("python", "c"):
                done = [simulate(chosen, folder / "small", stop_time=stop, overwrite=True, tick=tick) for _ in range(3)]
                found.append(min(one.wall_time / one.ticks for one in done) * 1e6)
            print(f"{count:4} {words:16}" + "".join(f"{time:9.1f}" for time in found), flush=True)


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 3000)
