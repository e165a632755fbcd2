"""Cost of a tick with native FMUs and with those in Python: `python tests/bench/native.py --fmus FMUS [--rounds 3]`.

Fine pointing of each layout with all modes and with 25: the native FMUs in a bare loop in C, the same through the
master, the FMUs in Python through the master, and the Python steppers in one loop without FMI. All take turns in one
run, on one core; times are those of the processor, the least of the rounds, per tick of 1 ms. What a short run takes is
subtracted, so that starting costs nothing. Printed too is what a step of each component takes by the clock: median,
99.9 % and longest, of which the last is what other programs on the machine do to it.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import zipfile
from collections.abc import Callable
from pathlib import Path
from time import process_time
from xml.etree import ElementTree

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import fmpy

from flexbench.loop.native_fmus import with_native_fmus
from flexbench.loop.scenarios import scalar_overrides, scenario_parameters
from flexsat.closed_loop import ClosedLoop
from flexsat.description.built_in import CONFIGURATIONS
from flexsat.design.chain import build_designs
from lockstep import System, load_system, simulate

HERE = Path(__file__).parent
PERIODS = {"sensors": 1, "controller": 5, "plant": 1}  # ticks, in the order of stepping
AIMS = {("distributed", 0): 10.0, ("distributed", 25): 6.0, ("centralised", 0): 3.0, ("centralised", 25): 2.0}  # us
SHARE = 1.0 / 6.0  # most of the Python steppers' time
SHORT = 1.0  # s, of the run whose time is subtracted
PORTS = ("plant.rate", "controller.wheel.torque")


def compile_loop(folder: Path) -> Path:
    """Compile the bare loop."""
    headers = Path(fmpy.__file__).parent / "c-code"
    command = ["cc", "-std=c99", "-O2", "-Wall", "-Wextra", f"-I{headers}", HERE / "native_loop.c"]
    subprocess.run([*command, "-o", folder / "native_loop", "-ldl"], check=True)
    return folder / "native_loop"


def setup(system: System, fmus: Path, overrides: dict[str, float], folder: Path) -> Path:
    """Write what the loop reads: libraries, start values and wires."""
    folder.mkdir(parents=True)
    variables: dict[str, dict[str, tuple[int, str]]] = {}
    lines = ["run 0 1000000"]
    heads = {}
    for name in PERIODS:
        with zipfile.ZipFile(fmus / "native" / f"{name}.fmu") as archive:
            archive.extractall(folder / name, [n for n in archive.namelist() if n.startswith(("binaries/", "modelD"))])
        root = ElementTree.parse(folder / name / "modelDescription.xml").getroot()
        variables[name] = {
            v.attrib["name"]: (int(v.attrib["valueReference"]), v[0].tag) for v in root.iter("ScalarVariable")
        }
        library = folder / name / "binaries" / "linux64" / f"{root.attrib['modelName']}.so"
        heads[name] = f"fmu {name} {library} {(folder / name).as_uri()} {root.attrib['guid']} {PERIODS[name]}"
    given = {f"{c.name}.{p}": v for c in system.components for p, v in c.parameters.items()} | overrides
    names = list(PERIODS)
    for name in names:
        lines.append(heads[name])
        for parameter, value in given.items():
            component, _, variable = parameter.partition(".")
            if component == name and not isinstance(value, str):
                reference, kind = variables[name][variable]
                lines.append(f"{kind.lower()} {reference} {float(value)!r}")
        for wire in system.connections:
            if wire.to_component == name:
                source, kind = variables[wire.from_component][wire.output]
                word = "flag" if kind == "Boolean" else "wire"
                lines.append(f"{word} {variables[name][wire.input][0]} {names.index(wire.from_component)} {source}")
    (folder / "setup.txt").write_text("\n".join(lines) + "\n", encoding="utf-8")
    return folder / "setup.txt"


def a_tick(fly: Callable[[float], object], duration: float) -> float:
    """Return the processor time of a tick [us]: of a long run less a short one."""
    times = []
    for length in (SHORT, SHORT + duration):
        begun = process_time()
        fly(length)
        times.append(process_time() - begun)
    return 1e3 * (times[1] - times[0]) / duration


def measure(fmus: Path, name: str, modes: int, duration: float, rounds: int, folder: Path) -> None:
    """Print the tables of a layout."""
    system = load_system(fmus / name / "fine_pointing.ssd")
    native = with_native_fmus(system)
    parameters = scenario_parameters("fine_pointing", seed=1)
    parameters["plant"]["modes"] = modes
    overrides = scalar_overrides(parameters)
    loop = compile_loop(folder)
    written = setup(system, fmus / name, overrides, folder / f"{name}-{modes}")
    monolith = ClosedLoop(build_designs(name), parameters)  # type: ignore[arg-type]

    def through_master(flown: System) -> Callable[[float], object]:
        return lambda length: simulate(flown, folder / "run", stop_time=length, overrides=overrides, record=PORTS,
                                       record_period=0.1, overwrite=True)  # fmt: skip

    ways = {
        "native, through the master": through_master(native),
        "Python FMUs, through the master": through_master(system),
        "Python steppers, one loop": lambda length: monolith.run(length, PORTS),
    }
    for fly in ways.values():  # the first run of a kind imports and caches
        fly(0.1)
    least = dict.fromkeys(("native, bare loop in C", *ways), float("inf"))
    steps: dict[str, list[float]] = {}
    for _ in range(rounds):
        shown = subprocess.run([loop, written, str(round(1e3 * duration))], check=True, capture_output=True, text=True)
        found = {line.split()[0]: [float(word) for word in line.split()[1:]] for line in shown.stdout.splitlines()}
        least["native, bare loop in C"] = min(least["native, bare loop in C"], found.pop("loop")[0])
        for part, values in found.items():
            steps[part] = [min(pair) for pair in zip(steps.get(part, values), values, strict=True)]
        for way, fly in ways.items():
            least[way] = min(least[way], a_tick(fly, duration))
    print(f"\n{name}, {modes or 198} modes, {duration:g} s, {rounds} rounds")
    slowest = least["Python steppers, one loop"]
    for way, time in least.items():
        print(f"  {way:34s}{time:8.2f} us a tick{time / slowest:8.3f} of the Python steppers")
    aim = AIMS[name, modes]
    reached = least["native, bare loop in C"]
    print(f"  aim of the bare loop: {aim:g} us and {SHARE:.3f} of the Python steppers; "
          f"{'met' if reached <= aim else f'missed by {reached / aim - 1.0:.0%}'}, "
          f"{'met' if reached <= SHARE * slowest else f'missed by {reached / slowest / SHARE - 1.0:.0%}'}")  # fmt: skip
    for part, (median, late, longest) in steps.items():
        print(f"  a step of {part:12s} median {median:7.2f} us, 99.9 % {late:7.2f} us, longest {longest:8.1f} us, "
              f"{median / PERIODS[part]:6.2f} us a tick", flush=True)  # fmt: skip


def main() -> int:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--fmus", type=Path, default=Path("fmus"), help="folder that `flexsat build` filled")
    parser.add_argument("--duration", type=float, default=30.0, help="of each run [s]")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--layout", choices=CONFIGURATIONS, action="append", help="default: both")
    parser.add_argument("--modes", type=int, choices=(0, 25), action="append", help="0: all; default: both")
    chosen = parser.parse_args()
    for name in chosen.layout or CONFIGURATIONS:
        for modes in chosen.modes or (0, 25):
            with tempfile.TemporaryDirectory(prefix="flexsat_bench_") as folder:
                measure(chosen.fmus, name, modes, chosen.duration, chosen.rounds, Path(folder))
    return 0


if __name__ == "__main__":
    sys.exit(main())
