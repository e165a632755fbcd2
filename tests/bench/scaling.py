"""Time of a tick over the number of signals and of components, of our master, libcosim and ecos on the same systems.

`make bench`, or `python tests/bench/scaling.py [TICKS]`. The components are rings of small compiled FMUs, whose own
cost is next to nothing: two of them that exchange 10 to 10,000 signals, and 2 to 100 that give ten each to the next
one. The masters take turns on each system, and the quickest of three rounds counts, so that what else the machine does
disturbs little. Below each table stands a line through the sizes, at which each counts alike, and the exponent by which
the time grows over the larger sizes: 1 is linear. One signal is recorded. `setup` is all that a run of ours does before
its first tick and after its last. nan: the master did not get that far within half a minute and 6 GB. Nothing passes or
fails here.
"""

from __future__ import annotations

import math
import os
import resource
import shutil
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path
from time import perf_counter

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import fmpy
import numpy as np

from lockstep import Component, Connection, System, load_system, simulate, write_ssd
from lockstep.ssp_package import package_entries

HERE = Path(__file__).parent
GUID = "{5d2c1f0a-7d0e-4f5c-9a55-2a3d2f7b6c11}"
FLAGS = ("-std=gnu11", "-Wall", "-Wextra", "-Werror", "-O2", "-shared", "-fPIC")
TICK = 1_000_000  # [ns]
SIGNALS = (10, 100, 1000, 3000, 10_000)  # of two components together
COMPONENTS = (2, 5, 10, 20, 50, 100)
WIDTH = 10  # signals from each component to the next, where the number of components varies
ROUNDS = 3
LONGEST, MEMORY = 30, 6 * 2**30  # [s], bytes for another master

OTHERS = {
    "libcosim": """
import os, sys
from time import perf_counter
from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimLogging import CosimLogLevel, log_output_level
log_output_level(CosimLogLevel.ERROR)
execution = CosimExecution.from_ssp_file(ssp_path=sys.argv[1], step_size=1_000_000)
execution.step()  # initialises, which is not counted
started = perf_counter()
for _ in range(int(sys.argv[2])):
    assert execution.step()
print(perf_counter() - started)
sys.stdout.flush()
os._exit(0)  # libcosim frees the FMUs after the interpreter is gone
""",
    "ecos": """
import sys
from time import perf_counter
from ecospy.EcosSimulation import EcosSimulation
with EcosSimulation(step_size=1e-3, ssp_path=sys.argv[1]) as simulation:
    assert simulation.init()
    started = perf_counter()
    for _ in range(int(sys.argv[2])):
        simulation.step()
    told = perf_counter() - started
    simulation.terminate()
print(told)
""",
}


def wide_fmu(folder: Path, width: int) -> Path:
    """Compile and zip the FMU with so many inputs and outputs."""
    library, path = folder / f"wide{width}.so", folder / f"wide{width}.fmu"
    headers = Path(fmpy.__file__).parent / "c-code"
    definitions = (f'-DGUID="{GUID}"', f"-DWIDTH={width}")
    subprocess.run(["gcc", *FLAGS, *definitions, f"-I{headers}", "-o", library, HERE / "wide.c"], check=True)
    ports = [("u", "input", ' start="0"')] * width + [("y", "output", "")] * width
    variables = "".join(
        f'<ScalarVariable name="{name}[{k % width + 1}]" valueReference="{k}" causality="{causality}">'
        f"<Real{start}/></ScalarVariable>\n"
        for k, (name, causality, start) in enumerate(ports)
    )
    unknowns = "".join(f'<Unknown index="{width + k + 1}"/>' for k in range(width))
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.write(library, f"binaries/linux64/wide{width}.so")
        archive.writestr(
            "modelDescription.xml",
            f'<?xml version="1.0" encoding="UTF-8"?>\n<fmiModelDescription fmiVersion="2.0" modelName="wide" '
            f'guid="{GUID}"><CoSimulation modelIdentifier="wide{width}"/><ModelVariables>\n{variables}</ModelVariables>'
            f"<ModelStructure><Outputs>{unknowns}</Outputs><InitialUnknowns>{unknowns}</InitialUnknowns>"
            "</ModelStructure></fmiModelDescription>\n",
        )
    return path


def write_ring(folder: Path, count: int, width: int) -> Path:
    """Write a ring of so many components, each with so many signals to the next one, as a .ssp."""
    folder.mkdir()
    fmu = wide_fmu(folder, width)
    names = [f"c{k}" for k in range(count)]
    system = System(
        name="ring",
        tick=TICK,
        components=tuple(Component(name=name, source=fmu, period=TICK, isolated=False) for name in names),
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


def ours(package: Path, ticks: int) -> tuple[float, float]:
    """Return what a tick takes, and all the rest of a run [s]."""
    started = perf_counter()
    summary = simulate(load_system(package), package.parent / "run", stop_time=ticks * TICK / 1e9, overwrite=True)
    return summary.wall_time / ticks, perf_counter() - started - summary.wall_time


def other(name: str, package: Path, ticks: int) -> float:
    """Return what a tick takes in another master [s], NaN if it cannot run the system within the limits."""
    command = [sys.executable, "-c", OTHERS[name], str(package), str(ticks)]
    try:
        done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=LONGEST, preexec_fn=_limit)
    except subprocess.TimeoutExpired:
        return math.nan
    return float(done.stdout.split()[-1]) / ticks if done.returncode == 0 else math.nan


def _limit() -> None:
    """Before libcosim takes all memory of the machine: for 10,000 signals it wants 19 GB."""
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))


def measured(package: Path, ticks: int) -> dict[str, float]:
    """Return the quickest round of each master [s]."""
    times: dict[str, list[float]] = {"setup": [], "lockstep": [], **{name: [] for name in OTHERS}}
    for _ in range(ROUNDS):
        tick, setup = ours(package, ticks)
        times["lockstep"].append(tick)
        times["setup"].append(setup)
        for name in OTHERS:
            gone = times[name] and math.isnan(times[name][-1])
            times[name].append(math.nan if gone else other(name, package, ticks))
    return {name: min(found) for name, found in times.items()}


def table(title: str, sizes: tuple[int, ...], found: list[dict[str, float]]) -> None:
    """Print one series, and how it grows."""
    masters = ("lockstep", *OTHERS)
    print(f"\n{title}")
    print(
        f"{'':>10}" + "".join(f"{name:>12}" for name in masters) + f"{'of libcosim':>14}{'of ecos':>10}{'setup, s':>11}"
    )
    for size, row in zip(sizes, found, strict=True):
        ratios = [row["lockstep"] / row[name] for name in OTHERS]
        print(f"{size:10}" + "".join(f"{row[name] * 1e6:12.1f}" for name in masters)
              + f"{ratios[0]:14.3f}{ratios[1]:10.3f}{row['setup']:11.2f}", flush=True)  # fmt: skip
    for name in (*masters, "setup"):
        y = np.array([row[name] for row in found])
        there = np.isfinite(y)
        x, y = np.array(sizes, float)[there], y[there]
        if len(y) < 3:
            continue
        (base, slope), *_ = np.linalg.lstsq(np.column_stack([1.0 / y, x / y]), np.ones(len(y)), rcond=None)
        off = np.max(np.abs((base + slope * x) / y - 1.0))
        exponent = np.log(y[-1] / y[-3]) / np.log(x[-1] / x[-3])
        print(f"{name:9}{base * 1e6:12.3g} us + {slope * 1e6:9.3g} us each, at most {off:.0%} off; "
              f"from {x[-3]:.0f} to {x[-1]:.0f} with exponent {exponent:.2f}")  # fmt: skip


def main(ticks: int) -> None:
    """Measure and print the tables."""
    with tempfile.TemporaryDirectory(prefix="flexsat_bench_") as temporary:
        series = {
            "signals of two components together, us a tick": (SIGNALS, [(2, size // 2) for size in SIGNALS]),
            f"components in a ring, {WIDTH} signals each, us a tick": (COMPONENTS, [(n, WIDTH) for n in COMPONENTS]),
        }
        for title, (sizes, rings) in series.items():
            found = []
            for count, width in rings:
                folder = Path(temporary, f"{count}x{width}")
                fewer = min(ticks, max(100, 10**6 // (count * width)))  # of the widest: ecos takes 50 ms each
                found.append(measured(write_ring(folder, count, width), fewer))
                shutil.rmtree(folder)
            table(title, sizes, found)


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 1000)
