"""Masters that load the .ssp packages of flexsat: how each is run, and its delay from output to input.

The delay of a value is the time from the start of the step that made it to the start of the first step that reads it.
It is measured with an FMU that stamps its steps, not taken from a master's documentation.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from availability import ecos_lacks, libcosim_lacks
from hosting import COMPONENTS, TICK, Bench, Trajectory
from stamps.stamps import OUTPUTS, build_stamps, stamps_package

SLOW = 5 * TICK  # [ns] period of the controller, and of what the sensors sample for it
STAMPS = ("fast", "slow", "slow_reader", "fast_reader")


@dataclass(frozen=True, slots=True, kw_only=True)
class Master:
    """A master, and the settings that the systems need in it."""

    name: str
    script: str
    missing: Callable[[], str] = str
    one_rate: int | None = None  # [ns] at which it steps everything; None: each component at its own
    late: Mapping[str, int] = field(default_factory=dict)  # ticks after which it shows outputs of a slow component

    @property
    def tick(self) -> int:
        """Its base step [ns]."""
        return self.one_rate or TICK

    def run(
        self,
        bench: Bench,
        package: Path,
        references: Mapping[str, Mapping[str, int]],
        duration: float,
        parameters: Mapping[str, Mapping[str, float]] | None = None,
        rows: int = SLOW,
    ) -> Trajectory:
        """Return outputs every `rows` nanoseconds over `duration` seconds.

        Parameters
        ----------
        package : an .ssp, as a receiver gets it
        references : value references of the outputs, by component and name
        parameters : values to set beside those of the package, by component and name
        """
        (found,) = self.run_each(bench, {package: references}, duration, parameters, rows)
        return found

    def run_each(
        self,
        bench: Bench,
        packages: Mapping[Path, Mapping[str, Mapping[str, int]]],
        duration: float,
        parameters: Mapping[str, Mapping[str, float]] | None = None,
        rows: int = SLOW,
    ) -> list[Trajectory]:
        """Run some packages, given with the value references of their outputs, one after another in one process."""
        settings = {name: dict(values) for name, values in (parameters or {}).items()}
        setups = [
            {
                "package": str(package),
                "tick": self.tick,
                "ticks": round(duration * 1e9) // self.tick,
                "every": rows // self.tick,
                "references": references,
                "parameters": settings,
                "parameter_references": {
                    name: bench.parameter_references(package, name, values) for name, values in settings.items()
                },
                "late": self.late,
            }
            for package, references in packages.items()
        ]
        return bench.run_each(self.script, setups)


LOCKSTEP = Master(name="lockstep", script="run_package.py")
LIBCOSIM = Master(
    name="libcosim",
    script="run_libcosim.py",
    missing=libcosim_lacks,
    late={"controller": 4},
)
ECOS = Master(name="ecos", script="run_ecos.py", missing=ecos_lacks)
# one rate for all: the controller's, which does not change, so the sensors step at it too
SIMULATE_SSP = Master(name="FMPy `simulate_ssp`", script="run_simulate_ssp.py", one_rate=SLOW)
FOREIGN = (LIBCOSIM, ECOS, SIMULATE_SSP)


@dataclass(frozen=True, slots=True, kw_only=True)
class Lateness:
    """How old a value is when a step first reads it, and at most while a slow one is held [s]."""

    to_slow: float  # from a component that steps every tick to one that steps every 5 ms
    to_fast: float  # the other way
    to_fast_at_most: float

    @property
    def known(self) -> dict[str, dict[str, float]]:
        """Return the delay parameters that the controller needs.

        The sensors sample every 5 ms, in step with the controller: what arrives a tick late is a sample of 5 ms ago.
        """
        sample = SLOW / 1e9
        measurement = math.ceil(self.to_slow / sample - 1e-6) * sample
        return {"controller": {"delay.measurement": measurement, "delay.actuation": self.to_fast}}


_measured: dict[tuple[Path, str], Lateness] = {}  # by folder of the bench, and master


def lateness(bench: Bench, master: Master, duration: float = 0.5) -> Lateness:
    """Measure a master's lateness with 1 kHz against 200 Hz, once."""
    key = (bench.work, master.name)
    if key not in _measured:
        _measured[key] = _lateness(bench, master, duration)
    return _measured[key]


def _lateness(bench: Bench, master: Master, duration: float) -> Lateness:
    fmu = build_stamps(bench.path("stamps"))
    package = stamps_package(fmu, TICK, SLOW)
    found = master.run(bench, package, dict.fromkeys(STAMPS, OUTPUTS), duration)
    least, largest, count = (
        {reader: float(found[f"{reader}.{output}"][-1, 0]) for reader in ("slow_reader", "fast_reader")}
        for output in ("least", "largest", "count")
    )
    assert all(seen > 10 for seen in count.values()), count
    return Lateness(
        to_slow=_whole(least["slow_reader"]),
        to_fast=_whole(least["fast_reader"]),
        to_fast_at_most=_whole(largest["fast_reader"]),
    )


def _whole(time: float) -> float:
    """Return a time [s] rounded to the microsecond: masters add up their time."""
    return round(time, 6) + 0.0


def loop_parameters(master: Master, known: Mapping[str, Mapping[str, float]]) -> dict[str, dict[str, float]]:
    """Return the parameters of the components in a master whose delays are known."""
    one_rate = {} if master.one_rate is None else {"sensors": {"step_size": master.one_rate / 1e9}}
    return one_rate | {name: dict(values) for name, values in known.items()}


def references(bench: Bench, configuration: str, patterns: tuple[str, ...]) -> dict[str, dict[str, int]]:
    """Return the value references of the outputs `component.port` that begin with one of some patterns."""
    found: dict[str, dict[str, int]] = {}
    for component in COMPONENTS:
        names = {
            name: reference
            for name, reference in bench.outputs(component, configuration).items()
            if any(_matches(f"{component}.{name}", pattern) for pattern in patterns)
        }
        if names:
            found[component] = names
    return found


def _matches(name: str, pattern: str) -> bool:
    port = name.partition("[")[0]
    return port.startswith(pattern[:-1]) if pattern.endswith("*") else port == pattern
