"""Pointing with the exported controller in doubles and in floats: `python tests/bench/embedded_precision.py`.

The native plant and sensors fly in closed loop with the C code of `flexsat export-c controller`, compiled here: both
layouts, fine pointing and the slew of the paper, all modes, noise as flown. In doubles the torque has to be that of the
native FMU of the controller, which gets the same inputs, bit for bit at every step. Printed are, from the settled time
on, RMS of pointing error, rate error, deformation and torque, and the largest error while slewing.
"""

from __future__ import annotations

import argparse
import ctypes
import io
import os
import sys
import tempfile
import zipfile
from itertools import product
from pathlib import Path
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
sys.path.insert(0, str(Path(__file__).parents[1]))

import numpy as np
from native import PERIODS, setup

from flexbench.loop.scenarios import scalar_overrides, scenario_parameters
from flexsat.description.built_in import CONFIGURATIONS
from flexsat.fmu.embedded.export import HEADER, controller_files
from flexsat.fmu.python.load_matrices import load_matrices
from flexsat.parameters import ARCSECOND
from flexsat.ports.controller import ports
from flexsat.ports.table import PortTable
from flexsat.runtime.controller_parameters import ControllerMatrices
from fmus.native.exported import Exported, compile_export
from lockstep import load_system

TURN = 2.0 * np.pi
SCENARIOS = ("fine_pointing", "slew")
MEASURED = ("gyro.rate", "accelerometer.acceleration", "encoder.speed", "encoder.angle", "star_tracker.mrp")
SETTLED = 150.0  # s, from which RMS are made; a shorter run: its last quarter
KINDS = {"real": ("Real", ctypes.c_double), "integer": ("Integer", ctypes.c_int), "boolean": ("Boolean", ctypes.c_int)}


class Fmu:
    """A native FMU by its C functions: lists of values in, arrays out."""

    def __init__(self, head: list[str], starts: list[list[str]]) -> None:
        _, self.name, library, resources, guid, _ = head
        self.library = ctypes.CDLL(library)
        self._callbacks = (ctypes.c_void_p * 5)(*map(_address, ("printf", "calloc", "free")), None, None)
        self.library.fmi2Instantiate.restype = ctypes.c_void_p
        name, text, at = self.name.encode(), guid.encode(), resources.encode()
        self.instance = ctypes.c_void_p(self.library.fmi2Instantiate(name, 1, text, at, self._callbacks, 0, 0))
        for kind, reference, value in starts:
            self.set(np.array([int(reference)], np.uint32), np.array([float(value)]), kind)
        zero = ctypes.c_double(0.0)
        self._check(self.library.fmi2SetupExperiment(self.instance, 0, zero, zero, 0, zero))
        self._check(self.library.fmi2EnterInitializationMode(self.instance))

    def _check(self, status: int) -> None:
        if status:
            raise RuntimeError(f"{self.name}: status {status}")

    def leave(self) -> None:
        """End the initialisation."""
        self._check(self.library.fmi2ExitInitializationMode(self.instance))

    def set(self, references: np.ndarray, values: np.ndarray, kind: str = "real") -> None:
        """Set values."""
        word, number = KINDS[kind]
        given = np.ascontiguousarray(values, number)
        call = getattr(self.library, f"fmi2Set{word}")
        size = ctypes.c_size_t(len(references))
        self._check(call(self.instance, references.ctypes.data_as(ctypes.c_void_p), size,
                         given.ctypes.data_as(ctypes.c_void_p)))  # fmt: skip

    def get(self, references: np.ndarray, kind: str = "real") -> np.ndarray:
        """Return values."""
        word, number = KINDS[kind]
        values = np.empty(len(references), number)
        call = getattr(self.library, f"fmi2Get{word}")
        size = ctypes.c_size_t(len(references))
        self._check(call(self.instance, references.ctypes.data_as(ctypes.c_void_p), size,
                         values.ctypes.data_as(ctypes.c_void_p)))  # fmt: skip
        return values

    def step(self, tick: int, ticks: int) -> None:
        """Make a step from a tick on [ms]."""
        time, length = ctypes.c_double(tick * 1_000_000 / 1e9), ctypes.c_double(ticks * 1_000_000 / 1e9)
        self._check(self.library.fmi2DoStep(self.instance, time, length, 1))


def _address(name: str) -> int | None:
    return ctypes.cast(getattr(ctypes.CDLL(None), name), ctypes.c_void_p).value


class Loop:
    """The wired FMUs of one run."""

    def __init__(self, path: Path) -> None:
        self.fmus: list[Fmu] = []
        blocks: list[list[list[str]]] = []
        for line in path.read_text(encoding="utf-8").splitlines()[1:]:
            words = line.split()
            if words[0] == "fmu":
                blocks.append([])
            blocks[-1].append(words)
        self.wires: list[list[tuple[str, int, np.ndarray, np.ndarray]]] = []
        for block in blocks:
            self.fmus.append(Fmu(block[0], [words for words in block[1:] if words[0] in KINDS]))
            ends: dict[tuple[str, int], list[tuple[int, int]]] = {}
            for words in block:
                if words[0] in ("wire", "flag"):
                    kind = "real" if words[0] == "wire" else "boolean"
                    ends.setdefault((kind, int(words[2])), []).append((int(words[1]), int(words[3])))
            self.wires.append([(kind, source, *(np.array(side, np.uint32) for side in zip(*pairs, strict=True)))
                               for (kind, source), pairs in ends.items()])  # fmt: skip
        for k in reversed(range(len(self.fmus))):
            self.transfer(k)
            self.fmus[k].leave()

    def transfer(self, k: int) -> None:
        """Give an FMU its inputs."""
        for kind, source, targets, sources in self.wires[k]:
            self.fmus[k].set(targets, self.fmus[source].get(sources, kind), kind)


def references(folder: Path, component: str, names: tuple[str, ...]) -> list[np.ndarray]:
    """Return the value references of ports of an unpacked FMU."""
    from xml.etree import ElementTree

    found: dict[str, list[int]] = {name: [] for name in names}
    for variable in ElementTree.parse(folder / component / "modelDescription.xml").getroot().iter("ScalarVariable"):
        name = variable.attrib["name"].partition("[")[0]
        if name in found:
            found[name].append(int(variable.attrib["valueReference"]))
    return [np.array(found[name], np.uint32) for name in names]


def fly(path: Path, controller: Exported, parameters: dict[str, Any], duration: float, bitwise: bool) -> np.ndarray:
    """Return rows each 5 ms: time, pointing errors (3), rates (3), deformation, torques, and reference MRP (3)."""
    loop, folder = Loop(path), path.parent
    sensors, flown, plant = loop.fmus
    measured = references(folder, "sensors", MEASURED)
    (valid,) = references(folder, "sensors", ("star_tracker.valid",))
    seen = np.concatenate(references(folder, "plant", ("attitude.mrp", "rate", "rms_deformation")))
    (torque,) = references(folder, "plant", ("wheel.torque",))
    (commanded,) = references(folder, "controller", ("wheel.torque",))
    controller.set("command.rotation", parameters["command.rotation"])
    controller.set("command.start_time", parameters["command.start_time"])
    assert controller.init() == "ok", controller.reason
    from_sensors = [(kind, source, targets, sources) for kind, source, targets, sources in loop.wires[2] if source == 0]
    rows = []
    for tick in range(round(1e3 * duration)):
        loop.transfer(0)
        sensors.step(tick, 1)
        if tick % PERIODS["controller"] == 0:
            for name, group in zip(MEASURED, measured, strict=True):
                values = sensors.get(group)
                controller.set(name, values % TURN if name == "encoder.angle" and not bitwise else values)
            controller.set("star_tracker.valid", int(sensors.get(valid, "boolean")[0]))
            assert controller.step() == "ok", controller.reason
            given = np.array(controller.outputs.wheel_torque, np.float64)
            if bitwise:
                loop.transfer(1)
                flown.step(tick, PERIODS["controller"])
                assert flown.get(commanded).tobytes() == given.tobytes(), f"another torque at {tick} ms"
            rows.append(np.concatenate([[tick / 1e3], plant.get(seen), given, controller.outputs.reference[:3]]))
            plant.set(torque, given)
        for kind, source, targets, sources in from_sensors:
            plant.set(targets, loop.fmus[source].get(sources, kind), kind)
        plant.step(tick, 1)
    return np.array(rows)


def figures(rows: np.ndarray, parameters: dict[str, Any]) -> list[float]:
    """Return RMS of pointing error [arcsec], rate [arcsec/s], deformation [um], torque [N.m]; the largest error."""
    time, mrp, rate, deformation = rows[:, 0], rows[:, 1:4], rows[:, 4:7], rows[:, 7]
    torque, reference = rows[:, 8:-3], rows[:, -3:]
    late = time >= min(SETTLED, 0.75 * time[-1])
    target = 0.25 * np.array(parameters["command.rotation"])  # an MRP but for 1e-5 of itself
    half = np.linalg.norm(target)
    target = np.tan(half) / half * target if half > 0.0 else target
    error = 4.0 * (mrp - target) / (1.0 + half**2)
    errors = 4.0 * (mrp - reference) / (1.0 + half**2)
    return [
        _rms(error[late]) / ARCSECOND,
        _rms(rate[late]) / ARCSECOND,
        float(np.sqrt(np.mean(deformation[late] ** 2))) * 1e6,
        _rms(torque[late]),
        float(np.linalg.norm(errors[time > 2.0], axis=1).max()) / ARCSECOND,
    ]


def _rms(vectors: np.ndarray) -> float:
    return float(np.sqrt(np.mean(np.sum(vectors**2, axis=1))))


def main() -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--fmus", type=Path, default=Path("fmus"), help="folder that `flexsat build` filled")
    parser.add_argument("--duration", type=float, default=300.0, help="of each run [s]")
    parser.add_argument("--layout", choices=CONFIGURATIONS, action="append", help="default: both")
    parser.add_argument("--scenario", choices=SCENARIOS, action="append", help="default: both")
    chosen = parser.parse_args()
    print(f"{'':50s}{'pointing':>12s}{'rate':>12s}{'deformation':>12s}{'torque':>12s}{'largest':>12s}")
    print(f"{'':50s}{'arcsec':>12s}{'arcsec/s':>12s}{'um':>12s}{'N.m':>12s}{'arcsec':>12s}")
    for name, scenario in product(chosen.layout or CONFIGURATIONS, chosen.scenario or SCENARIOS):
        with tempfile.TemporaryDirectory(prefix="flexsat_bench_") as temporary:
            folder = Path(temporary)
            system = load_system(chosen.fmus / name / f"{scenario}.ssd")
            parameters = scenario_parameters(scenario, seed=1)  # type: ignore[arg-type]
            overrides = scalar_overrides(parameters)
            with zipfile.ZipFile(chosen.fmus / name / "controller.fmu") as archive:
                content = archive.read("resources/model.npz")
            matrices = load_matrices(io.BytesIO(content), ControllerMatrices)
            table = PortTable(ports(matrices))
            flags = {key.replace(".", "_"): int(value) for key, value in parameters["controller"].items()
                     if isinstance(value, bool) and key != "as_published"}  # fmt: skip
            for precision in ("double", "float"):
                files = controller_files(matrices, name, "robust", precision)  # type: ignore[arg-type]
                library = compile_export(files, folder / precision)
                controller = Exported(library, table, files[HEADER], **flags)
                path = setup(system, chosen.fmus / name, overrides, folder / f"{precision}-fmus")
                rows = fly(path, controller, parameters["controller"], chosen.duration, precision == "double")
                what = f"{name}, {scenario}, {precision}"
                found = figures(rows, parameters["controller"])
                print(f"{what:50s}" + "".join(f"{value:12.5g}" for value in found), flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
