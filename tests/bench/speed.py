"""Ratios of speed, each of two things in one run: co-simulation, monolith, libcosim; memory over duration.

`make bench`, or `python tests/bench/speed.py [SECONDS]`. Each ratio is the median over rounds in which both took turns,
so that a shared machine disturbs both alike. Nothing here passes or fails: the table is the result.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from statistics import median
from time import perf_counter

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

ROUNDS = 3
CONFIGURATION, SCENARIO, SEED = "distributed", "fine_pointing", 1
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
from time import perf_counter
from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimLogging import CosimLogLevel, log_output_level
log_output_level(CosimLogLevel.ERROR)
execution = CosimExecution.from_ssp_file(ssp_path=sys.argv[1], step_size=1_000_000)
execution.step()  # initialises, which is not counted
started = perf_counter()
assert execution.simulate_until(int(float(sys.argv[2]) * 1e9))
print(perf_counter() - started)
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


def python(script: str, *arguments: object) -> float:
    """Run a script in a fresh process and return the number on its last line."""
    done = subprocess.run(
        [sys.executable, "-c", script, *map(str, arguments)], capture_output=True, text=True, check=True
    )
    return float(done.stdout.split()[-1])


def main(duration: float) -> None:
    """Measure and print the table."""
    from flexbench.loop.build import build_all
    from flexbench.loop.scenarios import scalar_overrides, scenario_parameters
    from flexsat.closed_loop import ClosedLoop
    from flexsat.design.chain import build_designs
    from lockstep import load_system, simulate

    with tempfile.TemporaryDirectory(prefix="flexsat_bench_") as temporary:
        folder = Path(temporary)
        build_all((CONFIGURATION,), folder / "fmus")
        path = folder / "fmus" / CONFIGURATION / f"{SCENARIO}.ssd"
        package = folder / "ssp"
        shutil.copytree(path.parent, package)
        shutil.copy(path, package / "SystemStructure.ssd")
        parameters = scenario_parameters(SCENARIO, seed=SEED)
        designs = build_designs(CONFIGURATION)
        times: dict[str, list[float]] = {"co-simulation": [], "monolith": [], "libcosim": []}
        for _ in range(ROUNDS):
            summary = simulate(
                load_system(path),
                folder / "run",
                stop_time=duration,
                overrides=scalar_overrides(parameters),
                overwrite=True,
            )
            times["co-simulation"].append(summary.wall_time)
            monolith = ClosedLoop(designs, parameters)
            started = perf_counter()
            monolith.run(duration, PORTS)
            times["monolith"].append(perf_counter() - started)
            short = min(duration, 5.0)
            times["libcosim"].append(python(LIBCOSIM, package, short) * duration / short)
        print(f"\n{CONFIGURATION} {SCENARIO}, {duration:g} s simulated, {ROUNDS} rounds, one core a process")
        print(f"{'':24}{'us a tick':>12}{'x real time':>14}")
        for name, seconds in times.items():
            print(f"{name:24}{median(seconds) / duration * 1e3:12.1f}{duration / median(seconds):14.2f}")
        for other, aim in (("monolith", 1.6), ("libcosim", 0.5)):
            ratio = median(a / b for a, b in zip(times["co-simulation"], times[other], strict=True))
            print(f"co-simulation / {other:20}{ratio:8.3f}   (aim: at most {aim})")
        peaks = {seconds: python(PEAK, path, folder / "memory", seconds) for seconds in (30, 300)}
        print(f"peak memory: {peaks[30]:.0f} MB in 30 s, {peaks[300]:.0f} MB in 300 s")


if __name__ == "__main__":
    main(float(sys.argv[1]) if len(sys.argv) > 1 else 20.0)
