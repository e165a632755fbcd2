"""Time of a tick over the number of signals and of components, in lockstep and in other masters on the same systems.

`make bench`, or `python tests/bench/scaling.py [ROUNDS]`. The components are rings of small compiled FMUs, whose own
cost is next to nothing: two of them that exchange 10 to 10,000 signals, and 2 to 100 that give ten each to the next
one. The masters take turns on each system, and the quickest round counts. Printed are the time on the clock in the
quickest part of a run and, in brackets, the processor time of all threads on average, which what else the machine does
disturbs less. In lockstep one signal is recorded at each tick, 50 at each fifth, or none; the others record nothing.
Ratios are of both times: lockstep's with one signal to the quicker of libcosim and ecos, and without recording
to the runner of fmu-manipulation-toolbox. Below each table stands a line through the processor times, at which each
size counts alike, and the exponent by which they grow over the larger sizes: 1 is linear. `setup` is what a run in
lockstep does before its first tick and after its last. nan: the master did not get that far within half a minute and
6 GB. Nothing passes or fails here.
"""

from __future__ import annotations

import argparse
import math
import os
import shutil
import sys
import tempfile
import zipfile
from itertools import pairwise
from pathlib import Path
from time import perf_counter, process_time
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
from other_masters import SCRIPTS, TOOLBOX, in_other

from lockstep import Component, Connection, System, load_system, simulate, write_ssd
from lockstep.ssp.package_members import package_entries

HERE = Path(__file__).parent
sys.path.append(str(HERE.parent))
from fmus.c_fmu import compile_library, pack_fmu, quoted  # noqa: E402

GUID = "{5d2c1f0a-7d0e-4f5c-9a55-2a3d2f7b6c11}"
TICK = 1_000_000  # [ns]
SIGNALS = (10, 100, 1000, 3000, 10_000)  # of two components together
COMPONENTS = (2, 5, 10, 20, 50, 100)
WIDTH = 10  # signals from each component to the next, where the number of components varies
WAYS: dict[str, dict[str, Any]] = {  # in lockstep
    "lockstep": {},
    "50 each fifth": {"record_period": 5e-3},
    "none recorded": {"record": ()},
}
AIM, RUNNER_AIM = 0.5, 2.0  # of libcosim's and ecos' time, of the toolbox' runner's


def wide_fmu(folder: Path, width: int) -> Path:
    """Compile and zip the FMU with so many inputs and outputs."""
    library, path = folder / f"wide{width}.so", folder / f"wide{width}.fmu"
    compile_library(library, [HERE / "wide.c"], defines=[quoted("GUID", GUID), f"WIDTH={width}"], options=["-O2"])
    ports = [("u", "input", ' start="0"')] * width + [("y", "output", "")] * width
    variables = "".join(
        f'<ScalarVariable name="{name}[{k % width + 1}]" valueReference="{k}" causality="{causality}">'
        f"<Real{start}/></ScalarVariable>\n"
        for k, (name, causality, start) in enumerate(ports)
    )
    unknowns = "".join(f'<Unknown index="{width + k + 1}"/>' for k in range(width))
    description = (
        f'<?xml version="1.0" encoding="UTF-8"?>\n<fmiModelDescription fmiVersion="2.0" modelName="wide" '
        f'guid="{GUID}"><CoSimulation modelIdentifier="wide{width}"/><ModelVariables>\n{variables}</ModelVariables>'
        f"<ModelStructure><Outputs>{unknowns}</Outputs><InitialUnknowns>{unknowns}</InitialUnknowns>"
        "</ModelStructure></fmiModelDescription>\n"
    )
    return pack_fmu(path, description, library)


def write_ring(folder: Path, count: int, width: int) -> Path:
    """Write a ring of so many components, each with so many signals to the next one, as a .ssp."""
    folder.mkdir()
    fmu = wide_fmu(folder, width)
    names = [f"c{k}" for k in range(count)]
    system = System(
        name="ring",
        tick=TICK,
        components=tuple(
            Component(name=name, source=fmu, period=TICK, kind="sampled", isolated=False) for name in names
        ),
        connections=tuple(
            Connection(from_component=a, output=f"y[{k + 1}]", to_component=b, input=f"u[{k + 1}]", delay=1)
            for a, b in zip(names, names[1:] + names[:1], strict=True)
            for k in range(width)
        ),
        record=("c0.y[1]",),
    )
    write_ssd(system, folder / "ring.ssd")
    with zipfile.ZipFile(folder / "ring.ssp", "w", zipfile.ZIP_STORED) as archive:
        for name, content in package_entries(folder / "ring.ssd").items():
            archive.writestr(name, content)
    return folder / "ring.ssp"


def in_lockstep(package: Path, ticks: int, way: str) -> tuple[float, float, float]:
    """Return what a tick takes on the clock and of the processor, and all the rest of a run on the clock [s]."""
    marks: list[tuple[float, float, float]] = []

    def mark(time: float, _stop: float) -> None:
        marks.append((time, perf_counter(), process_time()))

    started, system = perf_counter(), load_system(package)
    options = dict(WAYS[way])
    if "record_period" in options:
        options["record"] = [f"{wire.from_component}.{wire.output}" for wire in system.connections[:50]]
    summary = simulate(system, package.parent / "run", stop_time=ticks * TICK / 1e9, overwrite=True, progress=mark,
                       **options)  # fmt: skip
    rest = perf_counter() - started - summary.wall_time
    if len(marks) < 6:  # every 0.1 s there is one, and one at the end
        return in_lockstep(package, 4 * ticks, way)
    quickest = min((b[1] - a[1]) / (b[0] - a[0]) for a, b in pairwise(marks[:-1]) if b[0] > a[0])
    (first, _, work), (last, _, work_last) = marks[0], marks[-2]
    return quickest * TICK / 1e9, (work_last - work) / (last - first) * TICK / 1e9, rest


def measured(package: Path, ticks: int, rounds: int) -> dict[str, tuple[float, float]]:
    """Return the quickest round of each master: on the clock and of the processor [s]."""
    times: dict[str, list[tuple[float, float]]] = {name: [] for name in ("setup", *WAYS, *SCRIPTS)}
    for _ in range(rounds):
        for way in WAYS:
            clock, work, setup = in_lockstep(package, ticks, way)
            times[way].append((clock, work))
            times["setup"].append((setup, setup))
        for name in SCRIPTS:
            gone = times[name] and math.isnan(times[name][-1][0])
            fewer = ticks if name == TOOLBOX else max(100, ticks // 10)
            times[name].append((math.nan, math.nan) if gone else in_other(name, package, fewer))
    return {name: (min(clock for clock, _ in found), min(work for _, work in found)) for name, found in times.items()}


def table(title: str, sizes: tuple[int, ...], found: list[dict[str, tuple[float, float]]]) -> None:
    """Print one series, and how it grows."""
    masters = (*WAYS, *SCRIPTS)
    print(f"\n{title}, us a tick")
    heads = "".join(f"{name:>18}" for name in masters)
    print(f"{'':>8}{heads}{'of the quicker':>18}{'of the runner':>18}{'setup, s':>10}")
    for size, row in zip(sizes, found, strict=True):
        others = [row[name] for name in SCRIPTS if name != TOOLBOX and math.isfinite(row[name][0])]
        quicker = [row["lockstep"][k] / min(times[k] for times in others) if others else math.nan for k in (0, 1)]
        runner = [row["none recorded"][k] / row[TOOLBOX][k] for k in (0, 1)]
        cells = [f"{row[name][0] * 1e6:.2f} ({row[name][1] * 1e6:.2f})" for name in masters]
        cells += [f"{clock:.2f} ({work:.2f})" for clock, work in (quicker, runner)]
        print(f"{size:8}" + "".join(f"{cell:>18}" for cell in cells) + f"{row['setup'][0]:10.2f}")
    print(
        f"aims: at most {AIM:g} of the quicker of libcosim and ecos, {RUNNER_AIM:g} of the runner from 10 components on"
    )
    for name in (*masters, "setup"):
        y = np.array([row[name][1] for row in found])
        there = np.isfinite(y)
        x, y = np.array(sizes, float)[there], y[there]
        if len(y) < 3:
            continue
        (base, slope), *_ = np.linalg.lstsq(np.column_stack([1.0 / y, x / y]), np.ones(len(y)), rcond=None)
        off = np.max(np.abs((base + slope * x) / y - 1.0))
        exponent = np.log(y[-1] / y[-3]) / np.log(x[-1] / x[-3])
        print(f"{name:9}{base * 1e6:12.3g} us + {slope * 1e6:9.3g} us each, at most {off:.0%} off; "
              f"from {x[-3]:.0f} to {x[-1]:.0f} with exponent {exponent:.2f}", flush=True)  # fmt: skip


SERIES = {
    "signals": ("signals of two components together", SIGNALS, [(2, size // 2) for size in SIGNALS]),
    "components": (f"components in a ring, {WIDTH} signals each", COMPONENTS, [(n, WIDTH) for n in COMPONENTS]),
}


def main(rounds: int, only: str | None) -> None:
    """Measure and print the tables."""
    with tempfile.TemporaryDirectory(prefix="flexsat_bench_") as temporary:
        for name in [only] if only else SERIES:
            title, sizes, rings = SERIES[name]
            found = []
            for count, width in rings:
                folder = Path(temporary, f"{count}x{width}")
                ticks = max(1000, 10**6 // (count * (width + 50)))
                found.append(measured(write_ring(folder, count, width), ticks, rounds))
                shutil.rmtree(folder)
            table(title, sizes, found)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("rounds", type=int, nargs="?", default=3)
    parser.add_argument("--only", choices=SERIES, help="default: both series")
    chosen = parser.parse_args()
    main(chosen.rounds, chosen.only)
