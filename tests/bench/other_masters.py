"""Time a tick of a packed system in other masters: each in a process of its own, as a user would run it.

None of them records. A script prints the time on the clock of a tick in its quickest part, and the processor time of
one on average, in seconds. The runner of fmu-manipulation-toolbox is the FMU that it makes of a system, which is
stepped in one call for many ticks; its connections are given by their names, as it does not read SSP.
"""

from __future__ import annotations

import json
import math
import resource
import shutil
import subprocess
import sys
from pathlib import Path

from lockstep import load_system

LONGEST, MEMORY = 30, 6 * 2**30  # [s], bytes for another master
TICK = 1_000_000  # [ns]
TOOLBOX = "toolbox"
PARTS = 20  # of a run, of which the quickest counts

MEASURE = f"""
import os, sys
from time import perf_counter, process_time

def measure(advance, ticks):
    part = max(1, ticks // {PARTS})
    quickest, worked = 1e9, process_time()
    for _ in range({PARTS}):
        started = perf_counter()
        advance(part)
        quickest = min(quickest, perf_counter() - started)
    print(quickest / part, (process_time() - worked) / part / {PARTS})
    sys.stdout.flush()
"""
SCRIPTS = {
    "libcosim": """
from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimLogging import CosimLogLevel, log_output_level
log_output_level(CosimLogLevel.ERROR)
execution = CosimExecution.from_ssp_file(ssp_path=sys.argv[1], step_size=1_000_000)
execution.step()  # initialises, which is not counted
def advance(ticks):
    for _ in range(ticks):
        assert execution.step()
measure(advance, int(sys.argv[2]))
os._exit(0)  # libcosim frees the FMUs after the interpreter is gone
""",
    "ecos": """
from ecospy.EcosSimulation import EcosSimulation
def advance(ticks):
    for _ in range(ticks):
        simulation.step()
with EcosSimulation(step_size=1e-3, ssp_path=sys.argv[1]) as simulation:
    assert simulation.init()
    measure(advance, int(sys.argv[2]))
    simulation.terminate()
""",
    TOOLBOX: """
import pathlib
import fmpy
from fmpy.fmi2 import FMU2Slave
from fmu_manipulation_toolbox.assembly import Assembly
os.chdir(os.path.dirname(sys.argv[1]))
Assembly("container.json", fmu_directory=pathlib.Path()).make_fmu()
folder = fmpy.extract("container.fmu", os.path.abspath("container"))
description = fmpy.read_model_description(folder, validate=False)
fmu = FMU2Slave(guid=description.guid, unzipDirectory=folder, instanceName="ring",
                modelIdentifier=description.coSimulation.modelIdentifier)
fmu.instantiate()
fmu.setupExperiment(startTime=0.0)
fmu.enterInitializationMode()
fmu.exitInitializationMode()
done = 0
def advance(ticks):
    global done
    fmu.doStep(done * 1e-3, ticks * 1e-3)
    done += ticks
advance(1)
measure(advance, int(sys.argv[2]))
""",
}


def for_toolbox(package: Path) -> Path:
    """Write what the toolbox makes a container from, in a folder beside the package, and return its file."""
    system, folder = load_system(package.with_suffix(".ssd")), package.parent / "toolbox"
    folder.mkdir(exist_ok=True)
    for component in system.components:
        shutil.copy(component.source, folder / f"{component.name}.fmu")
    description = {
        "name": "container.fmu",
        "step_size": TICK / 1e9,
        "sequential": False,
        "auto_link": False,
        "auto_input": False,
        "auto_output": False,
        "fmu": [f"{component.name}.fmu" for component in system.components],
        "link": [
            [f"{wire.from_component}.fmu", wire.output, f"{wire.to_component}.fmu", wire.input]
            for wire in system.connections
        ],
    }
    (folder / "container.json").write_text(json.dumps(description), encoding="utf-8")
    return folder / "container.json"


def in_other(name: str, package: Path, ticks: int) -> tuple[float, float]:
    """Return the time of a tick on the clock and of the processor [s]; NaN if that takes more than the limits."""
    given = for_toolbox(package) if name == TOOLBOX else package
    command = [sys.executable, "-c", MEASURE + SCRIPTS[name], str(given), str(ticks)]
    try:
        done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=LONGEST, preexec_fn=_limit)
    except subprocess.TimeoutExpired:
        return math.nan, math.nan
    finally:
        shutil.rmtree(package.parent / "toolbox", ignore_errors=True)
    if done.returncode != 0:
        return math.nan, math.nan
    clock, work = done.stdout.split()[-2:]
    return float(clock), float(work)


def _limit() -> None:
    """Before libcosim takes all memory of the machine: for 10,000 signals it wants 19 GB."""
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
