"""Closed loops in other masters, with each master's delays compensated in the controller: metrics of each run."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from hosting import Bench, Trajectory
from masters import FOREIGN, LOCKSTEP, SLOW, TICK, Lateness, Master, lateness, loop_parameters, references
from numpy.typing import NDArray

from flexbench.loop.systems import RECORD
from flexbench.runs import histories
from flexbench.runs.metrics import root_mean_square

AGREE = 0.15  # of each metric, against the same loop in lockstep
METRICS = ("torque", "pointing", "rate", "deformation")
UNITS = {"torque": ("N.m", 1.0), "pointing": ("arcsec", 180.0 * 3600.0 / np.pi), "rate": ("deg/s", 180.0 / np.pi),
         "deformation": ("um", 1e6)}  # fmt: skip
NOTHING_KNOWN: Mapping[str, Mapping[str, float]] = {}


@dataclass(frozen=True, slots=True, kw_only=True)
class Recorded:
    """A trajectory with its time, as `flexbench.runs.histories` takes signals."""

    time: NDArray[np.float64]
    trajectory: Trajectory

    def __getitem__(self, port: str) -> NDArray[np.float64]:
        """Return a port: (rows,) of a scalar, (rows, elements) of an array."""
        columns = self.trajectory[port]
        return columns[:, 0] if port in self.trajectory.names else columns


@dataclass(frozen=True, slots=True, kw_only=True)
class Loop:
    """A package run for some seconds; the metrics are taken over the last part."""

    configuration: str
    scenario: str
    duration: float  # [s]
    since: float  # [s] from which on the metrics are taken

    def package(self, bench: Bench) -> Path:
        """Return the .ssp."""
        return bench.package(self.scenario, self.configuration)

    def metrics(
        self, bench: Bench, master: Master, parameters: Mapping[str, Mapping[str, float]]
    ) -> Mapping[str, float]:
        """Run in a master with these parameters; return RMS values in SI."""
        ports = references(bench, self.configuration, RECORD)
        found = master.run(bench, self.package(bench), ports, self.duration, parameters)
        return self.measured(found)

    def in_lockstep(
        self, bench: Bench, late: Lateness | None = None, one_rate: int | None = None
    ) -> Mapping[str, float]:
        """Run in lockstep: without delays, or with those of another."""
        ports = references(bench, self.configuration, RECORD)
        setup = {"package": str(self.package(bench)), "tick": TICK, "ticks": round(self.duration * 1e9) // TICK,
                 "every": SLOW // TICK, "references": ports, "parameters": {}}  # fmt: skip
        if late is not None:
            tick = one_rate or TICK
            setup |= {"tick": tick, "ticks": round(self.duration * 1e9) // tick, "every": SLOW // tick}
            setup |= {"delays": contracts(late, tick), "one_rate": one_rate}
            settings = {} if one_rate is None else {"sensors": {"step_size": one_rate / 1e9}}
            setup["parameters"] = settings | {name: dict(values) for name, values in late.known.items()}
        return self.measured(bench.run("run_package.py", setup))

    def measured(self, found: Trajectory) -> Mapping[str, float]:
        """Return RMS values in SI of the last part of a trajectory."""
        assert np.isfinite(found.values).all()
        time = SLOW / 1e9 * np.arange(1, len(found.values) + 1)
        signals, late = Recorded(time=time, trajectory=found), time > self.since
        measured = {
            "torque": histories.torque_norm(signals),
            "pointing": histories.pointing_error(signals),
            "rate": histories.rate_error(signals),
            "deformation": histories.deformation(signals),
        }
        return {name: root_mean_square(values[late]) for name, values in measured.items()}


def contracts(late: Lateness, tick: int) -> dict[str, int]:
    """Return a master's delays as those of connections in lockstep [ticks]; the plant's outputs are true a tick on."""
    to_fast, to_slow = round(late.to_fast * 1e9) // tick, round(late.to_slow * 1e9) // tick
    return {"plant sensors": 1, "sensors plant": 1, "sensors controller": to_slow, "controller plant": to_fast}


def worst(one: Mapping[str, float], other: Mapping[str, float], names: tuple[str, ...] = METRICS) -> float:
    """Return the largest relative difference of some metrics."""
    return max(abs(one[name] / other[name] - 1.0) for name in names)


def lateness_rows(bench: Bench) -> list[str]:
    """Return the table of what every master makes of 1 kHz against 200 Hz, in Markdown."""
    lines = ["| master | 1 kHz to 200 Hz | 200 Hz to 1 kHz | held until | `delay.measurement` | `delay.actuation` |",
             "|---|---:|---:|---:|---:|---:|"]  # fmt: skip
    for master in (LOCKSTEP, *FOREIGN):
        if master.missing():
            lines.append(f"| {master.name} | not run: {master.missing()} | | | | |")
            continue
        late = lateness(bench, master)
        known = late.known["controller"]
        rate = ", all at 200 Hz" if master.one_rate else ""
        times = (late.to_slow, late.to_fast, late.to_fast_at_most, known["delay.measurement"], known["delay.actuation"])
        lines.append(f"| {master.name}{rate} | " + " | ".join(f"{1e3 * time:g} ms" for time in times) + " |")
    return lines


def loop_rows(bench: Bench, loop: Loop) -> Iterator[str]:
    """Yield lines of a loop's table, in Markdown: metrics in each master, and their distance from those in lockstep."""
    none = loop.in_lockstep(bench)
    yield _line(loop, "lockstep, no delay", none, "")
    for master in FOREIGN:
        if master.missing():
            continue
        late = lateness(bench, master)
        found = loop.metrics(bench, master, loop_parameters(master, late.known))
        same = loop.in_lockstep(bench, late, master.one_rate)
        apart = f"{100 * worst(found, same):.2g} % | " + ", ".join(
            f"{100 * (found[name] / none[name] - 1):+.0f}" for name in METRICS
        )
        yield _line(loop, master.name, found, apart)


def loop_head() -> list[str]:
    """Return the head of the table of loops."""
    units = " | ".join(f"{name} [{UNITS[name][0]}]" for name in METRICS)
    return [f"| system | master | {units} | from lockstep with its delays, at most | from no delay [%] |",
            "|---|---|" + "---:|" * len(METRICS) + "---:|---|"]  # fmt: skip


def _line(loop: Loop, master: str, found: Mapping[str, float], apart: str) -> str:
    values = " | ".join(f"{found[name] * UNITS[name][1]:.3g}" for name in METRICS)
    return f"| {loop.configuration} {loop.scenario} | {master} | {values} | {apart or ' | '} |"
