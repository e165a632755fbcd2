"""Hosts from PyPI: how each closes the loop, and the way of lockstep that it has to equal."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from typing import Any

from availability import HOSTS_PYTHON, hosts_python_lacks, lacks
from hosting import COMPONENTS, Bench, Trajectory, ordered

from lockstep import load_system

STEP = 5_000_000  # [ns] of the rows, and of a host with one step
TICKS = 24  # rows: .12 s, with two samples of the star tracker
LATE = {"plant sensors": 1, "sensors plant": 1, "sensors controller": 1, "controller plant": 1}
KNOWN = {"delay.measurement": STEP / 1e9, "delay.actuation": STEP / 1e9}

Values = Mapping[str, Mapping[str, Any]]


@dataclass(frozen=True, slots=True, kw_only=True)
class Scheme:
    """A way to step the loop, and what the components have to be set to for it."""

    text: str
    period: int | None = None  # [ns] of all components and of the tick; None for their own
    delays: Mapping[str, int] = field(default_factory=dict)  # [ticks] beside those of the system file
    values: Values = field(default_factory=dict)


SCHEMES = {
    "late": Scheme(
        text="all at 5 ms, every value a step late",
        period=STEP,
        delays=LATE,
        values={"controller": KNOWN},
    ),
    "in order": Scheme(text="all at 5 ms, in the order of a tick", period=STEP),
    "own rates": Scheme(text="own rates, in the order of a tick"),
    "torque late": Scheme(
        text="own rates, torque 5 ms late",
        delays={"controller plant": 5},
        values={"controller": {"delay.actuation": KNOWN["delay.actuation"]}},
    ),
    "measurement late": Scheme(
        text="own rates, measurement 5 ms late",
        delays={"sensors controller": 1},  # held over five ticks, so that a sample a tick late is one of 5 ms ago
        values={"controller": {"delay.measurement": KNOWN["delay.measurement"]}},
    ),
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Package:
    """A host, as it is run here."""

    name: str
    script: str
    scheme: str
    missing: str
    remark: str
    options: Mapping[str, Any] = field(default_factory=dict)
    own_environment: bool = False

    def run(self, bench: Bench, configurations: Sequence[str], ticks: int = TICKS) -> dict[str, Trajectory]:
        """Return the real outputs of each configuration after each step of 5 ms, all run in one process."""
        setups = [self._setup(bench, configuration, ticks) for configuration in configurations]
        python = {"python": HOSTS_PYTHON} if self.own_environment else {}
        found = bench.run_each(f"pypi/{self.script}", setups, **python)
        return dict(zip(configurations, found, strict=True))

    def _setup(self, bench: Bench, configuration: str, ticks: int) -> dict[str, Any]:
        system = load_system(bench.folder / configuration / "fine_pointing.ssd")
        values = {c.name: dict(c.parameters) for c in system.components}
        for name, settings in SCHEMES[self.scheme].values.items():
            values[name] |= settings
        return {
            "fmus": {name: str(bench.fmu(name, configuration)) for name in COMPONENTS},
            "values": values,
            "connections": [(c.from_component, c.output, c.to_component, c.input) for c in system.connections],
            "outputs": {name: list(bench.outputs(name, configuration)) for name in COMPONENTS},
            "step": STEP / 1e9,
            "ticks": ticks,
            "options": dict(self.options),
        }


TOOLBOX = lacks("fmu_manipulation_toolbox", "fmu-manipulation-toolbox")
PACKAGES = (
    Package(
        name="fmu-manipulation-toolbox, `-sequential`",
        script="run_toolbox.py",
        scheme="in order",
        missing=TOOLBOX,
        options={"nested": False, "sequential": True},
        remark="order of the file: sensors, controller, plant; first inputs as start values; no delay to set",
    ),
    Package(
        name="fmu-manipulation-toolbox, nested containers",
        script="run_toolbox.py",
        scheme="torque late",
        missing=TOOLBOX,
        options={"nested": True},
        remark="sensors and plant in a container of 1 ms, the controller beside it; first inputs as start values; "
        "`delay.actuation` 5 ms",
    ),
    Package(
        name="pathsim-fmi",
        script="run_pathsim.py",
        scheme="own rates",
        missing=lacks("pathsim_fmi", "pathsim-fmi"),
        options={"periods": {"sensors": 1e-3, "controller": 5e-3, "plant": 1e-3}},
        remark="blocks in the order sensors, controller, plant; a wrapper for Booleans, which it sets as Reals; "
        "start values of unconnected inputs as `Constant`; no delay to set",
    ),
    Package(
        name="CoFMuPy (Jacobi)",
        script="run_cofmupy.py",
        scheme="late",
        missing=hosts_python_lacks(),
        own_environment=True,
        options={"method": "jacobi"},
        remark="any order (in its Gauss-Seidel the order changes from run to run); a wrapper for Booleans, which it "
        "sets as Reals; `initialization` of all inputs, else 0; both delays 5 ms",
    ),
    Package(
        name="gemseo-fmu, `MDAGaussSeidel`",
        script="run_gemseo.py",
        scheme="in order",
        missing=hosts_python_lacks(),
        own_environment=True,
        options={"mda": "MDAGaussSeidel", "mda_options": {}},
        remark="disciplines in the order sensors, controller, plant; Booleans and parameters set by a subclass; "
        "first inputs as defaults; no delay to set (`MDAJacobi`: both 5 ms)",
    ),
    Package(
        name="sofirpy",
        script="run_sofirpy.py",
        scheme="late",
        missing=lacks("sofirpy", "sofirpy"),
        remark="connections of the sensors before those of the plant; it logs the plant's accelerations with the next "
        "torque; first inputs as start values; both delays 5 ms",
    ),
    Package(
        name="FMUGym",
        script="run_fmugym.py",
        scheme="measurement late",
        missing=lacks("fmugym", "fmugym") or TOOLBOX,
        remark="environment: a container of sensors and plant; agent: the controller; measurements by `info` "
        "(observations have 32 bits); `delay.measurement` 5 ms; simulation and action steps equal",
    ),
)
# ways that a host knows beside the one of its row
OTHERS = (
    Package(
        name="fmu-manipulation-toolbox",
        script="run_toolbox.py",
        scheme="late",
        missing=TOOLBOX,
        options={"nested": False, "sequential": False},
        remark="any order; first inputs as start values; both delays 5 ms",
    ),
    Package(
        name="fmu-manipulation-toolbox, `-sequential` at 1 ms",
        script="run_toolbox.py",
        scheme="own rates",
        missing=TOOLBOX,
        options={"nested": False, "sequential": True, "container_step": 1e-3},
        remark="the controller holds its outputs between its samples; order and first inputs as above; no delay to set",
    ),
    Package(
        name="gemseo-fmu, `MDAJacobi`",
        script="run_gemseo.py",
        scheme="late",
        missing=hosts_python_lacks(),
        own_environment=True,
        options={"mda": "MDAJacobi", "mda_options": {"n_processes": 1}},
        remark="as above, both delays 5 ms",
    ),
)


def references(bench: Bench, configuration: str, ticks: int = TICKS) -> dict[str, Trajectory]:
    """Return what lockstep gives in each way."""
    found = bench.run(
        "pypi/run_references.py",
        {
            "system": str(bench.folder / configuration / "fine_pointing.ssd"),
            "schemes": {name: asdict(scheme) for name, scheme in SCHEMES.items()},
            "step": STEP,
            "ticks": ticks,
        },
    )
    reals = [f"{component}.{name}" for component in COMPONENTS for name in bench.outputs(component, configuration)]
    columns = {name: [found.names.index(f"{name}|{real}") for real in reals] for name in SCHEMES}
    return {name: ordered(reals, found.values[:, chosen]) for name, chosen in columns.items()}
