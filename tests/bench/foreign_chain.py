"""Cost of a chain of 50 light foreign FMUs: by default, in the master's process, one process each, and in libcosim.

`python tests/bench/foreign_chain.py [--rounds N] [--count N] [--fmu FMU INPUT OUTPUT]`. By default each FMU passes its
input on, halved and plus 1; what it does is next to nothing. Another one is given with its ports, such as
Feedthrough.fmu of the Reference-FMUs with Float64_continuous_input and Float64_continuous_output. The output of the
last one is recorded, by libcosim in a time series; a second row is libcosim without any observer. The ways take turns.
Printed is the time of a tick for each FMU, in the quickest tenth of a second on the clock, which what else the machine
does disturbs least, and in brackets the processor time of all processes on average. The memory of the workers is what
they occupy alone, their guards included (`uss`); `starting` is what a run does before its first tick and after its
last. The aim is 3 times libcosim's time by default. Nothing passes or fails here.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import zipfile
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from time import perf_counter

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import psutil
from scaling import TICK, wide_fmu

from lockstep import Component, Connection, System, load_system, simulate, write_ssd
from lockstep.fmi.model_description import read_description
from lockstep.processes.cpu_affinity import own_thread
from lockstep.ssp.package_members import package_entries

AIM, TICKS = 3.0, 2000
WAYS: dict[str, bool | None] = {"default": None, "in one process": False, "one process each": True}

LIBCOSIM = """
import os, sys
from time import perf_counter, process_time
from libcosimpy.CosimEnums import CosimVariableType
from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimLogging import CosimLogLevel, log_output_level
from libcosimpy.CosimObserver import CosimObserver
log_output_level(CosimLogLevel.ERROR)
execution = CosimExecution.from_ssp_file(ssp_path=sys.argv[1], step_size=1_000_000)
if sys.argv[3]:
    observer = CosimObserver.create_time_series(buffer_size=10**6)
    execution.add_observer(observer)
    slave = execution.slave_index_from_instance_name(sys.argv[3])
    output = int(sys.argv[4])
    observer.start_time_series(slave_index=slave, value_reference=output, variable_type=CosimVariableType.REAL)
execution.step()  # initialises, which is not counted
quickest, worked, ticks = 1e9, process_time(), int(sys.argv[2])
for _ in range(ticks // 100):
    started = perf_counter()
    for _ in range(100):
        assert execution.step()
    quickest = min(quickest, (perf_counter() - started) / 100)
print(quickest, (process_time() - worked) / ticks)
sys.stdout.flush()
os._exit(0)  # libcosim frees the FMUs after the interpreter is gone
"""

Row = tuple[float, float, float, float]  # clock and processor [s], memory of workers [MB], starting [s]


@dataclass(frozen=True, slots=True, kw_only=True)
class Link:
    """What the chain is made of: an FMU, and the ports that its neighbours are connected to."""

    fmu: Path
    input: str
    output: str

    @property
    def reference(self) -> int:
        """Value reference of the output."""
        part = Component(name="one", source=self.fmu, period=TICK)
        return read_description(part).variables[self.output].reference


def write_chain(folder: Path, link: Link, count: int) -> Path:
    """Write a chain of so many components as a .ssp."""
    names = [f"c{k}" for k in range(count)]
    system = System(
        name="chain",
        tick=TICK,
        components=tuple(Component(name=name, source=link.fmu, period=TICK) for name in names),
        connections=tuple(
            Connection(from_component=a, output=link.output, to_component=b, input=link.input, delay=1)
            for a, b in pairwise(names)
        ),
        record=(f"{names[-1]}.{link.output}",),
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
    if len(marks) < 8:  # every 0.1 s there is one, and one at the end
        return in_lockstep(package, isolated, 4 * ticks)
    first, last = marks[0], [each for each in marks[:-1] if each[2]][-1]
    quickest = min((b[1] - a[1]) / (b[0] - a[0]) for a, b in pairwise(marks[:-1]) if b[0] > a[0])
    return quickest * TICK / 1e9, (last[2] - first[2]) / (last[0] - first[0]) * TICK / 1e9, memory[0], starting


def in_libcosim(package: Path, ticks: int, count: int, reference: int, *, record: bool) -> Row:
    """Measure a run of libcosim, which has no workers."""
    command = [sys.executable, "-c", LIBCOSIM, str(package), str(ticks), f"c{count - 1}" if record else "",
               str(reference)]  # fmt: skip
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    clock, work = map(float, done.stdout.split()[-2:])
    return clock, work, 0.0, 0.0


def main(rounds: int, count: int, given: list[str] | None) -> None:
    """Measure and print the table."""
    with tempfile.TemporaryDirectory(prefix="flexsat_bench_") as folder:
        fmu, entry, output = given or (wide_fmu(Path(folder), 1), "u[1]", "y[1]")
        link = Link(fmu=Path(fmu).absolute(), input=entry, output=output)
        package, reference = write_chain(Path(folder), link, count), link.reference
        others = {"libcosim": True, "libcosim, not recording": False}
        rows: dict[str, list[Row]] = {name: [] for name in (*WAYS, *others)}
        for _ in range(rounds):
            for name, isolated in WAYS.items():
                rows[name].append(in_lockstep(package, isolated, TICKS))
            for name, record in others.items():
                rows[name].append(in_libcosim(package, TICKS, count, reference, record=record))
    print(
        f"{count} light FMUs in a chain{'us a step each':>33}{'of libcosim':>20}{'workers, MB':>14}{'starting, s':>14}"
    )
    best = {name: tuple(map(min, zip(*found, strict=True))) for name, found in rows.items()}
    for name, (clock, work, memory, starting) in best.items():
        cell = f"{clock / count * 1e6:.2f} ({work / count * 1e6:.2f})"
        ratio = f"{clock / best['libcosim'][0]:.2f} ({work / best['libcosim'][1]:.2f})"
        print(f"{name:26}{cell:>31}{ratio:>20}{memory:14.1f}{starting:14.2f}")
    print(f"aim: by default at most {AIM:g} of libcosim")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--count", type=int, default=50)
    parser.add_argument("--fmu", nargs=3, metavar=("FMU", "INPUT", "OUTPUT"))
    chosen = parser.parse_args()
    main(chosen.rounds, chosen.count, chosen.fmu)
