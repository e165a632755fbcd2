"""Cost of a chain of 50 light foreign FMUs: by default, in the master's process, one process each, and in libcosim.

`python tests/bench/foreign_chain.py [ROUNDS [COUNT]]`. Each FMU passes its input on, halved and plus 1; what it does
is next to nothing. The ways take turns, and the quickest round counts: the time of a tick for each FMU on the clock,
in brackets of the processor in all processes together. The memory of the workers is what they occupy alone, their
guards included (`uss`); `starting` is what a run does before its first tick and after its last. One signal is recorded.
The aim is 3 times libcosim's time by default. Nothing passes or fails here.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import zipfile
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from time import perf_counter

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import psutil
from scaling import OTHERS, TICK, wide_fmu

from lockstep import Component, Connection, System, load_system, simulate, write_ssd
from lockstep.processes.cpu_affinity import own_thread
from lockstep.ssp.package_members import package_entries

AIM, TICKS = 3.0, 2000
WAYS: dict[str, bool | None] = {"default": None, "in one process": False, "one process each": True}

Row = tuple[float, float, float, float]  # clock and processor [s], memory of workers [MB], starting [s]


def write_chain(folder: Path, count: int) -> Path:
    """Write a chain of so many components as a .ssp."""
    fmu = wide_fmu(folder, 1)
    names = [f"c{k}" for k in range(count)]
    system = System(
        name="chain",
        tick=TICK,
        components=tuple(Component(name=name, source=fmu, period=TICK) for name in names),
        connections=tuple(
            Connection(from_component=a, output="y[1]", to_component=b, input="u[1]", delay=1)
            for a, b in pairwise(names)
        ),
        record=(f"{names[-1]}.y[1]",),
    )
    write_ssd(system, folder / "chain.ssd")
    with zipfile.ZipFile(folder / "chain.ssp", "w", zipfile.ZIP_STORED) as archive:
        for name, content in package_entries(folder / "chain.ssd").items():
            archive.writestr(name, content)
    return folder / "chain.ssp"


def _worked() -> float:
    """Return the processor time of this process and all below it that run [s]."""
    own = psutil.Process()
    return sum(sum(one.cpu_times()[:2]) for one in (own, *own.children(recursive=True)))


def in_lockstep(package: Path, isolated: bool | None, ticks: int) -> Row:
    """Measure a run."""
    marks: list[tuple[float, float, float]] = []
    memory: list[float] = []

    def mark(time: float, stop: float) -> None:
        marks.append((time, perf_counter(), _worked() if len(marks) == 0 or time >= 0.8 * stop else 0.0))
        if len(marks) == 2:
            memory.append(sum(one.memory_full_info().uss for one in psutil.Process().children(recursive=True)) / 1e6)

    system = load_system(package)
    system = replace(system, components=tuple(replace(part, isolated=isolated) for part in system.components))
    started = perf_counter()
    with own_thread():
        summary = simulate(system, package.parent / "run", stop_time=ticks * TICK / 1e9, overwrite=True, progress=mark)
    starting = perf_counter() - started - summary.wall_time
    first, last = marks[0], [each for each in marks if each[2] and each[0] < ticks * TICK / 1e9][-1]
    done = (last[0] - first[0]) / TICK * 1e9
    if len(marks) < 6:  # every 0.1 s there is one, and one at the end
        return in_lockstep(package, isolated, 4 * ticks)
    return (last[1] - first[1]) / done, (last[2] - first[2]) / done, memory[0], starting


def in_libcosim(package: Path, ticks: int) -> Row:
    """Measure a run of libcosim, which has no workers."""
    command = [sys.executable, "-c", OTHERS["libcosim"], str(package), str(ticks)]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    clock, work = done.stdout.split()[-2:]
    return float(clock) / ticks, float(work) / ticks, 0.0, 0.0


def main(rounds: int, count: int) -> None:
    """Measure and print the table."""
    with tempfile.TemporaryDirectory(prefix="flexsat_bench_") as folder:
        package = write_chain(Path(folder), count)
        rows: dict[str, list[Row]] = {name: [] for name in (*WAYS, "libcosim")}
        for _ in range(rounds):
            for name, isolated in WAYS.items():
                rows[name].append(in_lockstep(package, isolated, TICKS))
            rows["libcosim"].append(in_libcosim(package, TICKS))
    print(
        f"{count} light FMUs in a chain{'us a step each':>33}{'of libcosim':>14}{'workers, MB':>14}{'starting, s':>14}"
    )
    best = {name: tuple(map(min, zip(*found, strict=True))) for name, found in rows.items()}
    for name, (clock, work, memory, starting) in best.items():
        cell = f"{clock / count * 1e6:.2f} ({work / count * 1e6:.2f})"
        ratio = clock / best["libcosim"][0]
        print(f"{name:26}{cell:>31}{ratio:14.2f}{memory:14.1f}{starting:14.2f}")
    print(f"aim: by default at most {AIM:g} of libcosim")


if __name__ == "__main__":
    main(*(int(text) for text in sys.argv[1:]), *(3, 50)[len(sys.argv) - 1 :])
