"""Time of a bundle in a C program over that of the master; or the fuzzer on a bundle of four cells.

    python tests/bench/bundle.py SYSTEM.ssd [SECONDS]
    python tests/bench/bundle.py --fuzz [SEQUENCES] [VERSION OF FMI] [THAT OF WHAT IS INSIDE]

The bundle has what the system records as outputs, and steps of the recording's period; the master records the same in
memory. Times are those of the processor, after 0.1 s of simulated time. Nothing passes or fails here but the fuzzer.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
import time
from dataclasses import replace
from pathlib import Path

import fmpy

sys.path.insert(0, str(Path(__file__).parents[1]))

from fmus.bundle_fuzz.fuzz_bundle import CHOICE, as_fmi3, build_fuzzer, run_fuzzer
from fmus.bundle_host import MS, Choice, bundled
from fmus.c_fmu import HEADERS
from fmus.cell.cell_fmu import cell_fmu
from fmus.cell.four_cells import four_cells
from lockstep import Component, load_system, simulate
from lockstep.fmi.model_description import read_description

BEFORE = 0.1  # [s] simulated


def master(system, seconds, tick):
    """Return the time of a tick of the master [us]."""
    spent = []
    for stop in (BEFORE, BEFORE, BEFORE + seconds):  # the first time libraries are loaded, and perhaps compiled
        begun = time.process_time()
        simulate(system, stop_time=stop, tick=tick)
        spent.append(time.process_time() - begun)
    return (spent[2] - spent[1]) / (seconds * 1e9 / system.tick) * 1e6


def in_c(system, seconds, folder):
    """Return the time of a tick of the bundle in a C program that gets all outputs after each step [us]."""
    step = system.record_period or system.tick
    choice = Choice(inputs=("none",), outputs=tuple(system.record), parameters=("none",))
    path = bundled(system, folder / "bundle.fmu", choice, step=step)
    unpacked = Path(fmpy.extract(str(path), str(folder / "unpacked")))
    description = read_description(Component(name="it", source=path, period=step))
    program = folder / "bundle_loop"
    source = Path(__file__).with_name("bundle_loop.c")
    subprocess.run(["gcc", "-O2", f"-I{HEADERS}", source, "-o", program, "-ldl"], check=True)
    library = unpacked / "binaries" / "linux64" / f"{description.identifier}.so"
    steps = int(seconds * 1e9 / step)
    reals = [v.reference for v in description.variables.values() if v.type == "Real"]
    command = [program, library, (unpacked / "resources").as_uri(), description.guid, steps, step / 1e9, *reals]
    done = subprocess.run(list(map(str, command)), capture_output=True, text=True, check=True)
    return float(done.stdout) / (steps * step / system.tick) * 1e6


def fuzz(sequences, version, inside, folder):
    """Run the fuzzer, and print what came of it."""
    cells = four_cells(cell_fmu(folder))
    path = bundled(as_fmi3(cells, folder) if inside == "3.0" else cells, folder / "four.fmu", CHOICE, version=version)
    unpacked = Path(fmpy.extract(str(path), str(folder / "unpacked")))
    guid = read_description(Component(name="it", source=path, period=MS)).guid
    program = build_fuzzer(folder / "build", version)
    print(run_fuzzer(program, unpacked / "resources", guid, sequences, version=version), end="")


def main() -> int:
    """Print a line for each."""
    with tempfile.TemporaryDirectory(prefix="lockstep_bundle_") as name:
        if sys.argv[1] == "--fuzz":
            given = dict(enumerate(sys.argv[2:]))
            fuzz(int(given.get(0, "100000")), given.get(1, "2.0"), given.get(2, "2.0"), Path(name))
            return 0
        seconds = float((*sys.argv[2:], "5")[0])
        system = load_system(sys.argv[1])
        system = replace(system, components=tuple(replace(c, isolated=False) for c in system.components))
        for tick in ("python", "c"):
            print(f"master, tick in {tick:7s} {master(system, seconds, tick):8.2f} us a tick", flush=True)
        print(f"bundle in a C program  {in_c(system, seconds, Path(name)):8.2f} us a tick")
    return 0


if __name__ == "__main__":
    sys.exit(main())
