"""What the hosts share: built FMUs, runs in fresh processes, the reference, and the rows of the table.

A trajectory is what every real output is after each tick: of sensors and controller what they put out in that tick, of
the plant what is true at its end.
"""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
from numpy.typing import NDArray

HERE = Path(__file__).parent
FLEXSAT = Path(sys.executable).with_name("flexsat")
TICK = 1_000_000  # [ns]
COMPONENTS = ("sensors", "controller", "plant")  # in the order of a tick
# BLAS with one thread adds in one order: only so can two hosts agree to the last bit
ENVIRONMENT = os.environ | {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}


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


def agreement(ours: Trajectory, theirs: Trajectory) -> str:
    """Return `bitwise`, or the largest difference in a port over the largest value in that port."""
    assert ours.names == theirs.names
    assert ours.values.shape == theirs.values.shape
    assert np.ptp(ours.values, axis=0).any(), "nothing moves, so that nothing is compared"
    if np.array_equal(ours.values, theirs.values):
        return "bitwise"
    ports = sorted({_port(name) for name in ours.names})
    return f"{max(distance(port, ours, theirs) for port in ports if ours[port].any() or theirs[port].any()):.0e}"


def distance(port: str, ours: Trajectory, theirs: Trajectory) -> float:
    """Return the largest difference in a port over the largest value of it."""
    return float(np.abs(ours[port] - theirs[port]).max() / max(np.abs(ours[port]).max(), np.abs(theirs[port]).max()))


def _port(name: str) -> str:
    return re.sub(r"\[\d+\]$", "", name)


class Bench:
    """The built FMUs, and trajectories that several hosts are compared with."""

    def __init__(self, folder: Path, configurations: Sequence[str] = ("distributed",)) -> None:
        self.folder, self.work = folder / "fmus", folder / "work"
        self.work.mkdir(parents=True)
        options = [option for name in configurations for option in ("--configuration", name)]
        self.configurations = tuple(configurations)
        command = [FLEXSAT, "build", *options, "--out", self.folder]
        subprocess.run(command, check=True, capture_output=True, env=ENVIRONMENT)
        self._references: dict[str, Trajectory] = {}
        self._descriptions: dict[Path, Any] = {}
        self._runs = 0

    def fmu(self, component: str, configuration: str = "distributed") -> Path:
        """Return where an FMU is."""
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

    def references(self, configuration: str = "distributed") -> dict[str, dict[str, int]]:
        """Return the value references of the real outputs by component and name."""
        return {component: self.outputs(component, configuration) for component in COMPONENTS}

    def package(self, scenario: str, configuration: str = "distributed") -> Path:
        """Return where a system is, as a receiver gets it."""
        return self.folder / configuration / f"{scenario}.ssp"

    def path(self, name: str) -> Path:
        """Return a new place for a file."""
        self._runs += 1
        return self.work / f"{self._runs:03d}_{name}"

    def run(self, script: str, setup: Mapping[str, Any]) -> Trajectory:
        """Run a script beside this file in a fresh process with its setup; return what it saved."""
        given, saved = self.path(f"{script}.json"), self.path(f"{script}.npz")
        given.write_text(json.dumps(setup), encoding="utf-8")
        done = subprocess.run(
            [sys.executable, HERE / script, given, saved],
            capture_output=True,
            text=True,
            check=False,
            timeout=300,
            env=ENVIRONMENT,
        )
        assert done.returncode == 0, f"{script}: exit code {done.returncode}\n{done.stdout}\n{done.stderr}"
        return load(saved)

    def reference(
        self,
        ticks: int,
        delays: Mapping[tuple[str, str], int] | None = None,
        scenario: str = "fine_pointing",
        period: int | None = None,
        signals: Sequence[str] = ("all",),
    ) -> Trajectory:
        """Run our own master.

        Parameters
        ----------
        ticks : how many
        delays : of each connection by its two components, in ticks; None for the system file's
        scenario : name of a system file
        period : [ns] of all components alike, which is then the tick too; None for their own
        signals : patterns of what to return
        """
        setup = {
            "system": str(self.folder / "distributed" / f"{scenario}.ssd"),
            "ticks": ticks,
            "delays": None if delays is None else {" ".join(ends): delay for ends, delay in delays.items()},
            "period": period,
            "signals": list(signals),
        }
        key = json.dumps(setup, sort_keys=True)
        if key not in self._references:
            found = self.run("run_lockstep.py", setup)
            reals = {f"{component}.{name}" for component, names in self.references().items() for name in names}
            kept = [i for i, name in enumerate(found.names) if name in reals]
            self._references[key] = Trajectory(names=tuple(found.names[i] for i in kept), values=found.values[:, kept])
        return self._references[key]


def save(path: Path | str, names: Sequence[str], values: Any) -> None:
    """Save a trajectory."""
    with Path(path).open("wb") as stream:
        np.savez(stream, names=np.array(names), values=np.array(values, np.float64))


def load(path: Path) -> Trajectory:
    """Load a trajectory, its columns in the order of their names."""
    with np.load(path) as file:
        names, values = [str(name) for name in file["names"]], file["values"]
    order = sorted(range(len(names)), key=names.__getitem__)
    return Trajectory(names=tuple(names[i] for i in order), values=values[:, order])
