"""Ratios of speed, each of two things in one run: co-simulation, monolith, libcosim; native FMUs against real time.

`make bench`, or `python tests/bench/speed.py [SECONDS] [--fmus FMUS]`. Each ratio is the median over rounds in which
both took turns, so that a shared machine disturbs both alike; in brackets that of the least processor times, with what
a run does before its first tick. Native FMUs fly fine pointing for 300 s on one core, recorded as by default; the
quickest round counts, on the clock and, in brackets, by the processor time of all threads.
Printed too is the memory over the duration. Nothing here passes or fails: the tables are the result.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
from pathlib import Path
from statistics import median
from time import perf_counter, process_time

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from flexbench.loop.build import build_all
from flexbench.loop.native_fmus import with_native_fmus
from flexbench.loop.scenarios import scalar_overrides, scenario_parameters
from flexsat.closed_loop import ClosedLoop
from flexsat.description.built_in import CONFIGURATIONS
from flexsat.design.chain import build_designs
from lockstep import load_system, simulate

ROUNDS = 3
CONFIGURATION, SCENARIO, SEED = "distributed", "fine_pointing", 1
AIMS = {"monolith": 1.15, "libcosim": 0.3}  # of the co-simulation's time to that of the other
NATIVE_AIMS = {("distributed", 25): 100, ("distributed", 0): 60, ("centralised", 25): 200, ("centralised", 0): 120}
NATIVE_DURATION = 300.0  # [s]
PORTS = (
    "plant.attitude.mrp",
    "plant.rate",
    "plant.modal.displacement",
    "plant.modal.velocity",
    "plant.wheel.speed",
    "plant.rms_deformation",
    "controller.wheel.torque",
    "controller.reference.mrp",
    "controller.reference.rate",
    "controller.reference.modal.displacement",
    "controller.reference.modal.velocity",
    "controller.reference.wheel.speed",
    "controller.reference.torque",
)

LIBCOSIM = """
import sys
from time import perf_counter, process_time
from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimLogging import CosimLogLevel, log_output_level
log_output_level(CosimLogLevel.ERROR)
execution = CosimExecution.from_ssp_file(ssp_path=sys.argv[1], step_size=1_000_000)
execution.step()  # initialises, which is not counted
started, worked = perf_counter(), process_time()
assert execution.simulate_until(int(float(sys.argv[2]) * 1e9))
print(perf_counter() - started, process_time() - worked)
sys.stdout.flush()
import os
os._exit(0)  # libcosim frees the FMUs after the interpreter is gone
"""

PEAK = """
import resource, sys
from flexbench.loop.scenarios import scalar_overrides, scenario_parameters
from lockstep import load_system, simulate
simulate(load_system(sys.argv[1]), sys.argv[2], stop_time=float(sys.argv[3]), overwrite=True,
         overrides=scalar_overrides(scenario_parameters("fine_pointing", seed=1)))
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0)
"""


def python(script: str, *arguments: object) -> list[float]:
    """Run a script in a fresh process and return the numbers on its last line."""
    done = subprocess.run(
        [sys.executable, "-c", script, *map(str, arguments)], capture_output=True, text=True, check=True
    )
    return [float(word) for word in done.stdout.splitlines()[-1].split()]


def python_fmus(fmus: Path, duration: float, folder: Path) -> None:
    """Print the table of the FMUs in Python."""
    path = fmus / CONFIGURATION / f"{SCENARIO}.ssd"
    package = path.parent / "closed" / f"{SCENARIO}.ssp"  # libcosim refuses connectors to the outside
    parameters = scenario_parameters(SCENARIO, seed=SEED)
    designs = build_designs(CONFIGURATION)
    # on the clock, and of the processor [s]
    times: dict[str, list[tuple[float, float]]] = {"co-simulation": [], "monolith": [], "libcosim": []}
    for _ in range(ROUNDS):
        worked = process_time()
        summary = simulate(
            load_system(path),
            folder / "run",
            stop_time=duration,
            overrides=scalar_overrides(parameters),
            overwrite=True,
        )
        times["co-simulation"].append((summary.wall_time, process_time() - worked))
        monolith = ClosedLoop(designs, parameters)
        started, worked = perf_counter(), process_time()
        monolith.run(duration, PORTS)
        times["monolith"].append((perf_counter() - started, process_time() - worked))
        short = min(duration, 5.0)
        clock, work = python(LIBCOSIM, package, short)
        times["libcosim"].append((clock * duration / short, work * duration / short))
    print(f"\n{CONFIGURATION} {SCENARIO}, {duration:g} s simulated, {ROUNDS} rounds, one core a process")
    print(f"{'':24}{'us a tick':>12}{'x real time':>14}")
    for name, found in times.items():
        seconds = median(clock for clock, _ in found)
        print(f"{name:24}{seconds / duration * 1e3:12.1f}{duration / seconds:14.2f}")
    for other, aim in AIMS.items():
        ratio = median(a / b for (a, _), (b, _) in zip(times["co-simulation"], times[other], strict=True))
        least = {name: min(work for _, work in times[name]) for name in ("co-simulation", other)}
        work = least["co-simulation"] / least[other]
        print(f"co-simulation / {other:20}{ratio:8.3f} ({work:.3f})   (aim: at most {aim})", flush=True)
    peaks = {seconds: python(PEAK, path, folder / "memory", seconds)[0] for seconds in (30, 300)}
    print(f"peak memory: {peaks[30]:.0f} MB in 30 s, {peaks[300]:.0f} MB in 300 s", flush=True)


def native_fmus(fmus: Path, folder: Path) -> None:
    """Print the table of native FMUs."""
    print(f"\nnative FMUs, {SCENARIO}, {NATIVE_DURATION:g} s recorded as by default, {ROUNDS} rounds, on one core")
    print(f"{'':24}{'us a tick':>18}{'x real time':>22}{'aim':>8}")
    allowed = os.sched_getaffinity(0)
    os.sched_setaffinity(0, {min(allowed)})
    for (layout, modes), aim in NATIVE_AIMS.items():
        system = with_native_fmus(load_system(fmus / layout / f"{SCENARIO}.ssd"))
        parameters = scenario_parameters(SCENARIO, seed=SEED)
        parameters["plant"]["modes"] = modes
        found = []
        for _ in range(ROUNDS):
            worked = process_time()
            summary = simulate(system, folder / "native", stop_time=NATIVE_DURATION, overwrite=True,
                               overrides=scalar_overrides(parameters))  # fmt: skip
            found.append((summary.wall_time, process_time() - worked))
        clock, work = (min(times) for times in zip(*found, strict=True))
        ticks = f"{clock / NATIVE_DURATION * 1e3:.1f} ({work / NATIVE_DURATION * 1e3:.1f})"
        factors = f"{NATIVE_DURATION / clock:.0f} ({NATIVE_DURATION / work:.0f})"
        print(f"{f'{layout}, {modes or 198} modes':24}{ticks:>18}{factors:>22}{aim:8}", flush=True)
    os.sched_setaffinity(0, allowed)


def main() -> None:
    """Measure and print the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("seconds", type=float, nargs="?", default=20.0, help="simulated with FMUs in Python")
    parser.add_argument("--fmus", type=Path, help="folder that `flexsat build` filled; default: built anew")
    parser.add_argument("--native-only", action="store_true", help="leave the FMUs in Python out")
    chosen = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="flexsat_bench_") as temporary:
        folder = Path(temporary)
        if chosen.fmus is None:
            build_all(CONFIGURATIONS, folder / "fmus")
        fmus = chosen.fmus or folder / "fmus"
        native_fmus(fmus, folder)
        if not chosen.native_only:
            python_fmus(fmus, chosen.seconds, folder)


if __name__ == "__main__":
    main()
