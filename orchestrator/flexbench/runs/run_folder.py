"""Read the results folder of a run of a flexsat system: its configuration, scenario, seed, signals and metrics."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from flexsat.description.built_in import CONFIGURATIONS, built_in
from flexsat.description.spacecraft_file import SpacecraftFile
from flexsat.design.chain import Design, Designs, build_designs
from flexsat.parameters import ConfigurationName
from flexsat.variants import CORRECTED, Variant, chosen_by
from lockstep import InputError, Signals
from lockstep.results.lazy_columns import LazyColumns
from lockstep.results.read import PARQUET, open_signals
from lockstep.results.read_run_record import read_run_record
from lockstep.results.run_record import EVENTS, RUN
from lockstep.results.stream import STREAM

from ..loop.spacecraft import designs_for, spacecraft_of
from .commands import Command, command_of, number_of
from .flown_design import FILE as DESIGN
from .flown_design import FlownDesign, planned_slew, read_flown, refuse_other_design
from .histories import pointing_error
from .loop_names import plant_model
from .loop_numbers import settling_band
from .loop_signals import read_loop
from .metrics import SETTLED_FROM, Windows, check_length, compute_metrics
from .slews import slews_of
from .windows import steady_since

METRICS = "metrics.json"
_OWN = (RUN, EVENTS, PARQUET, STREAM, METRICS, DESIGN)  # files of a run


@dataclass(frozen=True, slots=True, kw_only=True)
class Run:
    """A run of a flexsat system, as recorded in its results folder."""

    folder: Path
    configuration: ConfigurationName
    slew: bool
    seed: int
    variant: Variant = CORRECTED
    open_loop: bool = False

    @property
    def flown(self) -> FlownDesign:
        """The design of the FMUs that flew, as far as recorded signals need it; InputError if it is lost."""
        return read_flown(self.folder)

    @property
    def command(self) -> Command | None:
        """What the run commanded its controller at the start; None: nothing."""
        record, _ = read_run_record(self.folder)
        return command_of(record, "controller")

    @property
    def design(self) -> Design:
        """The whole design that the run's FMUs were built from; InputError if it is not that of this version."""
        return self.designs.variant(self.variant)

    @property
    def designs(self) -> Designs:
        """All designs of its configuration; InputError if the run flew another plant."""
        name = self.configuration
        designs = build_designs(name) if name in CONFIGURATIONS else designs_for(name, self._plant())
        refuse_other_design(self.flown, designs.variant(self.variant), self.folder)
        return designs

    @property
    def spacecraft(self) -> SpacecraftFile:
        """The description of its spacecraft; InputError if that is neither built in nor with the FMUs that flew."""
        name = self.configuration
        return built_in(name) if name in CONFIGURATIONS else spacecraft_of(name, self._plant())

    def _plant(self) -> Path:
        record, _ = read_run_record(self.folder)
        return Path(next(one["source"] for one in record["component"] if one["name"] == "plant"))

    def signals(self) -> Signals:
        """Return the recorded signals, each read when it is used first."""
        return open_signals(self.folder)

    def samples(self) -> Signals:
        """Return the recorded signals without the row at the stop time, where no interval begins: for sums and means.

        Runs of earlier versions have no such row.
        """
        signals = self.signals()
        record, _ = read_run_record(self.folder)
        end = float(record.get("simulated_time", 0.0))
        if len(signals.time) < 2 or not signals.time[-1] >= end > 0.0:
            return signals
        columns = LazyColumns(list(signals), partial(_without_last_row, signals))
        return replace(signals, time=signals.time[:-1], columns=columns)

    def loop(self) -> Signals:
        """Return the signals of the loop without the row at the stop time; a missing reference is the command."""
        loop = read_loop(self.folder)
        if loop is None:
            raise InputError(
                f"{self.folder}: not a run of a flexsat system, whose plant is called plant_<configuration>"
            )
        return loop.signals

    def steady_since(self, signals: Signals) -> float | None:
        """Return from when on a run with slews is steady [s], None for one without; InputError if it ends in one."""
        slews = slews_of(signals)
        if not slews:
            return None
        record, _ = read_run_record(self.folder)
        error = pointing_error(signals)
        since = steady_since(signals.time, error, slews, settling_band(record))
        if since is None:
            raise InputError(f"{self.folder}: ends in a slew, and nothing is steady; run longer, or give --from")
        return since

    def metrics(self) -> Mapping[str, float]:
        """Return the run's metrics, in SI; raise InputError if it is too short or lacks a signal."""
        signals = self.samples()
        check_length(signals)
        design, command, slews = self.flown, self.command, slews_of(signals)
        if slews and not (slews[-1].end is not None and slews[-1].end <= SETTLED_FROM):
            raise InputError(f"metrics of the paper: refer to t > {SETTLED_FROM:g} s, and a slew ends later")
        end = None if command is None else planned_slew(design, command).end
        return compute_metrics(signals, design, Windows(slew_end=end, variant=self.variant))


def _without_last_row(signals: Signals, names: Sequence[str]) -> Mapping[str, NDArray[np.float64]]:
    """Return columns of signals without their last row."""
    if isinstance(signals.columns, LazyColumns):
        signals.columns.load(names)
    return {name: signals.columns[name][:-1] for name in names}


def read_run(folder: Path) -> Run:
    """Read a results folder.

    Raises
    ------
    InputError
        If it is not a run of a flexsat system: components plant, sensors and controller as `flexsat build` makes them.
    """
    record, _ = read_run_record(folder)
    components = {component["name"]: component for component in record["component"]}
    match = plant_model(components.get("plant", {}))
    if match is None or match[2] is not None or "controller" not in components:
        raise InputError(f"{folder}: not a run of a flexsat system, whose plant is called plant_<configuration>")
    plant, controller = (components[part].get("parameters", {}) for part in ("plant", "controller"))
    return Run(
        folder=folder,
        configuration=match[1],
        variant=chosen_by(plant.get, controller.get("design")),
        slew=command_of(record, "controller") is not None,
        seed=int(number_of(plant, "seed")),
        open_loop=bool(controller.get("open_loop", False)),
    )


def refuse_own_file(out: Path) -> None:
    """Raise InputError if a file to write is one that a run has recorded."""
    if out.name in _OWN and (out.parent / RUN).exists():
        raise InputError(f"{out}: is the run's own record; choose another file")
