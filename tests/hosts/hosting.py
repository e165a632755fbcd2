"""What the hosts share: built FMUs, runs in fresh processes, the reference, and the rows of the table.

A trajectory is what every real output is after each tick: of sensors and controller what they put out in that tick, of
the plant what is true at its end.
"""

from __future__ import annotations

import atexit
import io
import json
import os
import re
import subprocess
import sys
import zipfile
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import fmpy
import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from copied_process import Copies

HERE = Path(__file__).parent
FLEXSAT = Path(sys.executable).with_name("flexsat")
TICK = 1_000_000  # [ns]
CONFIGURATIONS = ("centralised", "distributed", "distributed/flat", "centralised/native", "distributed/native")
COMPONENTS = ("sensors", "controller", "plant")  # in the order of a tick
# BLAS with one thread adds in one order: only so can two hosts agree to the last bit
# what they import takes a second
COPIED = ("run_fmpy.py", "run_lockstep.py", "run_package.py", "run_simulate_ssp.py", "pypi/run_references.py")
IMPORTED = ("numpy", "fmpy.fmi2", "fmpy.ssp.simulation", "lockstep.simulation", "lockstep.results.read")
ENVIRONMENT = os.environ | {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
# packages of another environment are installed without compiled files: it takes less time to compile what is imported
COMPILING = {"PYTHONDONTWRITEBYTECODE": ""}


@dataclass(frozen=True, slots=True, kw_only=True)
class Row:
    """One line of the table: an FMU kind in a host."""

    kind: str
    host: str
    ran: str
    agreement: str
    remark: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Trajectory:
    """Outputs by name, after each tick."""

    names: tuple[str, ...]
    values: NDArray[np.float64]  # (ticks, names)

    def __getitem__(self, port: str) -> NDArray[np.float64]:
        """Return the columns of a port: (ticks, elements)."""
        return self.values[:, [_port(name) == port for name in self.names]]


def agreement(reference: Trajectory, found: Trajectory) -> str:
    """Return `bitwise`, or the largest difference in a port over the largest value in that port."""
    assert reference.names == found.names
    assert reference.values.shape == found.values.shape
    assert np.ptp(reference.values, axis=0).any(), "nothing moves, so that nothing is compared"
    if np.array_equal(reference.values, found.values):
        return "bitwise"
    ports = sorted({_port(name) for name in reference.names})
    return (
        f"{max(distance(port, reference, found) for port in ports if reference[port].any() or found[port].any()):.0e}"
    )


def joined(rows: Mapping[str, Row]) -> Row:
    """Return one row for runs that differ in their configuration only."""
    first = next(iter(rows.values()))
    agreements = dict.fromkeys(row.agreement for row in rows.values())
    return replace(first, ran=f"{', '.join(rows)}: {first.ran}", agreement=", ".join(agreements))


def arcseconds_apart(reference: Trajectory, found: Trajectory) -> float:
    """Return the largest difference of attitude [arcsec]; a small rotation vector is four times its MRP."""
    mrp = reference["plant.attitude.mrp"] - found["plant.attitude.mrp"]
    return float(4.0 * np.linalg.norm(mrp, axis=1).max() * 180.0 * 3600.0 / np.pi)


def distance(port: str, reference: Trajectory, found: Trajectory) -> float:
    """Return the largest difference in a port over the largest value of it."""
    return float(
        np.abs(reference[port] - found[port]).max() / max(np.abs(reference[port]).max(), np.abs(found[port]).max())
    )


def _port(name: str) -> str:
    return re.sub(r"(\[\d+\]|_\d+)$", "", name)  # of a flat name too


@cache
def _copies() -> Copies:
    """Return the process whose copies run scripts, which import this module but not that one."""
    from copied_process import Copies

    started = Copies(IMPORTED, ENVIRONMENT)
    atexit.register(started.close)
    return started


def build(folder: Path) -> None:
    """Build the FMUs and systems of both configurations, native ones too, and of one those with flat names."""
    for options in (["centralised"], ["distributed", "--flat"]):
        command = [FLEXSAT, "build", "--out", folder, "--configuration", *options]
        done = subprocess.run(command, check=False, capture_output=True, text=True, env=os.environ | ENVIRONMENT)
        assert done.returncode == 0, done.stderr


class Bench:
    """The built FMUs, and trajectories that several hosts are compared with."""

    def __init__(self, fmus: Path, work: Path) -> None:
        self.folder, self.work = fmus, work
        self._references: dict[str, Trajectory] = {}
        self._descriptions: dict[Path, Any] = {}
        self._runs = 0

    def fmu(self, component: str, configuration: str = "distributed") -> Path:
        """Return where an FMU is; configuration `distributed/flat` has flat names, `distributed/native` those in C."""
        return self.folder / configuration / f"{component}.fmu"

    def description(self, fmu: Path) -> Any:
        """Return what FMPy reads of an FMU."""
        if fmu not in self._descriptions:
            self._descriptions[fmu] = fmpy.read_model_description(str(fmu))
        return self._descriptions[fmu]

    def outputs(self, component: str, configuration: str = "distributed") -> dict[str, int]:
        """Return the value references of the real outputs by name."""
        variables = self.description(self.fmu(component, configuration)).modelVariables
        return {v.name: v.valueReference for v in variables if v.causality == "output" and v.type == "Real"}

    def parameter_references(self, package: Path, component: str, names: Iterable[str]) -> dict[str, int]:
        """Return value references of parameters, of an FMU inside a package."""
        with zipfile.ZipFile(package) as archive:
            fmu = io.BytesIO(archive.read(f"resources/{component}.fmu"))
        known = {v.name: v.valueReference for v in fmpy.read_model_description(fmu).modelVariables}
        return {name: known[name] for name in names}

    def references(self, configuration: str = "distributed") -> dict[str, dict[str, int]]:
        """Return the value references of the real outputs by component and name."""
        return {component: self.outputs(component, configuration) for component in COMPONENTS}

    def low_level(self, component: str, configuration: str, **setup: Any) -> Trajectory:
        """Return what FMPy's low-level calls give: of a variant with flat names, the one with structured names."""
        structured = configuration.removesuffix("/flat")
        outputs = self.outputs(component, structured)
        setup |= {"fmu": str(self.fmu(component, structured)), "way": "low-level", "outputs": outputs}
        key = json.dumps(setup, sort_keys=True)
        if key not in self._references:  # a variant with flat names has the same
            self._references[key] = self.run("run_fmpy.py", setup)
        found = self._references[key]
        names = dict(zip(outputs, self.outputs(component, configuration), strict=True))  # in one order in both
        return ordered([names[name] for name in found.names], found.values)

    def moving(self, component: str, configuration: str) -> list[tuple[int, float]]:
        """Return value reference and start value of the inputs to move; a command that moves would be refused."""
        return [
            (v.valueReference, float(v.start))
            for v in self.description(self.fmu(component, configuration)).modelVariables
            if v.causality == "input" and v.type == "Real" and not v.name.startswith("command")
        ]

    def package(self, scenario: str, configuration: str = "distributed") -> Path:
        """Return where a system is, as OSP's hosts take it: without connectors to the outside."""
        return self.folder / configuration / "closed" / f"{scenario}.ssp"

    def path(self, name: str) -> Path:
        """Return a new place for a file."""
        self._runs += 1
        return self.work / f"{self._runs:03d}_{name}"

    def run(self, script: str, setup: Mapping[str, Any], python: Path = Path(sys.executable)) -> Trajectory:
        """Run a script beside this file in a process of its own with its setup; return what it saved."""
        return self.run_each(script, [setup], python)[0]

    def run_each(
        self, script: str, setups: Sequence[Mapping[str, Any]], python: Path = Path(sys.executable)
    ) -> list[Trajectory]:
        """Run a script with one setup after another, all in one process; return what it saved of each."""
        name = Path(script).name
        command, limit = [str(HERE / script)], 300.0  # s of wall time, also where many share the machine
        for setup in setups:
            given, saved = self.path(f"{name}.json"), self.path(f"{name}.npz")
            given.write_text(json.dumps(setup), encoding="utf-8")
            command += [str(given), str(saved)]
            limit += 0.01 * setup.get("ticks", 0)
        if script in COPIED and str(python) == sys.executable:
            done = _copies().run(command, timeout=limit)
        else:
            own = ENVIRONMENT if str(python) == sys.executable else ENVIRONMENT | COMPILING
            done = subprocess.run(
                [python, *command], capture_output=True, text=True, check=False, timeout=limit, env=own
            )
        assert done.returncode == 0, f"{script}: exit code {done.returncode}\n{done.stdout}\n{done.stderr}"
        return [load(Path(path)) for path in command[2::2]]

    def reference(
        self,
        ticks: int,
        delays: Mapping[tuple[str, str], int] | None = None,
        scenario: str = "fine_pointing",
        period: int | None = None,
        signals: Sequence[str] = ("all",),
        configuration: str = "distributed",
    ) -> Trajectory:
        """Run lockstep as `under_delays` does, under these."""
        (found,) = self.under_delays(ticks, [delays], scenario, period, signals, configuration)
        return found

    def under_delays(
        self,
        ticks: int,
        cases: Sequence[Mapping[tuple[str, str], int] | None],
        scenario: str = "fine_pointing",
        period: int | None = None,
        signals: Sequence[str] = ("all",),
        configuration: str = "distributed",
    ) -> list[Trajectory]:
        """Run lockstep under one set of delays after another, all in one process.

        Parameters
        ----------
        ticks : how many
        cases : delays of each connection by its two components, in ticks; None for the system file's
        scenario : name of a system file
        period : [ns] of all components alike, which is then the tick too; None for their own
        signals : patterns of what to return
        configuration : `distributed`, or `distributed/native` for the FMUs in C
        """
        setups = [
            {
                "system": str(self.folder / configuration / f"{scenario}.ssd"),
                "ticks": ticks,
                "delays": None if delays is None else {" ".join(ends): delay for ends, delay in delays.items()},
                "period": period,
                "signals": list(signals),
            }
            for delays in cases
        ]
        keys = [json.dumps(setup, sort_keys=True) for setup in setups]
        new = {key: setup for key, setup in zip(keys, setups, strict=True) if key not in self._references}
        reals = {f"{component}.{name}" for component, names in self.references().items() for name in names}
        for key, found in zip(new, self.run_each("run_lockstep.py", list(new.values())) if new else (), strict=True):
            kept = [i for i, name in enumerate(found.names) if name in reals]
            self._references[key] = Trajectory(names=tuple(found.names[i] for i in kept), values=found.values[:, kept])
        return [self._references[key] for key in keys]


class NativeBench(Bench):
    """The same bench with the native FMUs; its references are runs of those in Python."""

    def fmu(self, component: str, configuration: str = "distributed") -> Path:
        """Return where a native FMU is."""
        return self.folder / configuration / "native" / f"{component}.fmu"

    def package(self, scenario: str, configuration: str = "distributed") -> Path:
        """Return where the package of a system of the native FMUs is."""
        return self.folder / configuration / "native" / "closed" / f"{scenario}.ssp"


def save(path: Path | str, names: Sequence[str], values: Any) -> None:
    """Save a trajectory."""
    with Path(path).open("wb") as stream:
        np.savez(stream, names=np.array(names), values=np.array(values, np.float64))


def load(path: Path) -> Trajectory:
    """Load a trajectory."""
    with np.load(path) as file:
        return ordered([str(name) for name in file["names"]], file["values"])


def ordered(names: Sequence[str], values: NDArray[np.float64]) -> Trajectory:
    """Return a trajectory with its columns in the order of their names."""
    order = sorted(range(len(names)), key=names.__getitem__)
    return Trajectory(names=tuple(names[i] for i in order), values=values[:, order])
