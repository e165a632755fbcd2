"""What isolation costs: us a step a component, of our FMUs in processes of their own against the same in this one.

`python tests/bench/isolation.py [STEPS]`. All inputs are set and all outputs fetched at each step. Both ways take turns
in short blocks, and the median of single steps is told, so that what else the machine does disturbs little. The aim is
below 60 us more. Nothing passes or fails here. Two further rows: two isolated components, stepped one after the other
and side by side.
"""

from __future__ import annotations

import os
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from statistics import median
from time import perf_counter

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np

from lockstep.fmi2 import Fmi2Slave
from lockstep.fmu import Description, read_description
from lockstep.isolated.remote import RemoteSlave
from lockstep.slave import DTYPES, SCALARS, Slave
from lockstep.system import Component

CONFIGURATION, SCENARIO, AIM = "distributed", "fine_pointing", 60.0  # [us]
BLOCK = 100  # steps

Parts = tuple[Callable[[float], None], Callable[[], None]]


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

    def begin(time: float) -> None:
        for put in puts:
            put()
        do_step(time, period, 1)

    def finish() -> None:
        for get in gets:
            get()

    return begin, finish


def timed(parts: list[Parts], period: float, first: int) -> list[float]:
    """Return what each step of a block takes [us]: all begin, then all are finished."""
    found = []
    for k in range(first, first + BLOCK):
        started = perf_counter()
        for begin, _ in parts:
            begin(k * period)
        for _, finish in parts:
            finish()
        found.append((perf_counter() - started) * 1e6)
    return found


def main(steps: int) -> None:
    """Measure and print the table."""
    from flexbench.commands import build
    from lockstep import load_system

    with tempfile.TemporaryDirectory(prefix="flexsat_bench_") as temporary:
        folder = Path(temporary)
        build((CONFIGURATION,), folder / "fmus")
        system = load_system(folder / "fmus" / CONFIGURATION / f"{SCENARIO}.ssd")
        opened: list[Slave] = []

        def open_(kind: type[Fmi2Slave] | type[RemoteSlave], component: Component) -> Parts:
            description = read_description(component)
            slave = kind(component, description, folder / str(len(opened)), lambda *_: None)
            opened.append(slave)
            return bound(slave, description, component.period / 1e9)

        print(f"\n{CONFIGURATION}, us a step, median of {steps} steps")
        print(f"{'component':12}{'shared':>9}{'isolated':>10}{'more':>8}   (aim: below {AIM:g} more)")
        for component in system.components:
            ways: list[list[float]] = [[], []]
            parts = [open_(kind, component) for kind in (Fmi2Slave, RemoteSlave)]
            for first in range(0, steps, BLOCK):
                for way, part in zip(ways, parts, strict=True):
                    way += timed([part], component.period / 1e9, first)
            shared, isolated = map(median, ways)
            print(f"{component.name:12}{shared:9.1f}{isolated:10.1f}{isolated - shared:8.1f}")
        plant = next(component for component in system.components if component.kind == "continuous")
        pair, period = [open_(RemoteSlave, plant) for _ in range(2)], plant.period / 1e9
        ways = [[], []]
        for first in range(0, steps, BLOCK):
            one, two = (timed([part], period, 2 * first) for part in pair)
            ways[0] += [a + b for a, b in zip(one, two, strict=True)]
            ways[1] += timed(pair, period, 2 * first + BLOCK)
        print(f"two of {plant.name}, one after the other and side by side (calm: the quickest tenth)")
        for words, at in (("median", 50), ("calm", 10)):
            after, beside = (float(np.percentile(way, at)) for way in ways)
            print(f"{words:12}{after:9.1f}{beside:10.1f}{after / beside:8.2f} x")
        for slave in opened:
            slave.close()


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 3000)
