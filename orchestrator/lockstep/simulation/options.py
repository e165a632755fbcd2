"""What a run is to do: options by name or as one object."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from typing import TypedDict

from lockstep.checkpoint.restart import Restart
from lockstep.checkpoint.schedule import CheckpointSchedule
from lockstep.faults.scenario import Scenario
from lockstep.fmi.kept_fmus import KeptFmus
from lockstep.plan.input_files import Paths
from lockstep.plan.overrides import Override
from lockstep.plan.plan import Plan
from lockstep.results.monitor import Watch
from lockstep.run.real_time_pacing import Pacer
from lockstep.shadow.component import Tolerances

Progress = Callable[[float, float], None]


@dataclass(frozen=True, slots=True, kw_only=True, repr=False)
class RunOptions:
    """What a run is to do. All may be left out."""

    stop_time: float | str | None = None  # [s]; None: the system file's
    overrides: Mapping[str, Override] = field(default_factory=dict)  # by `component.parameter`, or an array's name
    record: Sequence[str] | None = None  # patterns on `component.variable`, or `all`; None: the system file's
    record_period: float | str | None = None  # [s]; None: the system file's, or every tick
    progress: Progress | None = None  # called with simulated and final time [s], at most ten times in a second
    overwrite: bool = False  # replace the folder of an earlier run, once the new one has started
    step_limit: float | str | None = None  # wall time of one call of an isolated FMU [s]; None: 60
    faults: Sequence[Scenario] = ()  # to inject: `lockstep.faults`
    pace: float | str | Pacer | None = None  # most times real time; None or 0: as fast as possible
    realtime_priority: int | str | None = None  # SCHED_FIFO of the thread that steps, where that is permitted
    core: int | str | None = None  # that it is kept on, where that is possible
    profile: bool = False  # measure where the wall time goes in Python too, where that makes short ticks slower
    checkpoints: CheckpointSchedule = field(default_factory=CheckpointSchedule)  # when to save, in the results folder
    restart: Restart | None = None  # checkpoint to start from, instead of the start time
    tolerance: Tolerances | None = None  # of the FMUs' integration, for all or by component; None: what they declare
    strict_inputs: bool = (
        False  # refuse inputs that have neither a connection nor a value, which else keep their start values
    )
    inputs: Paths | None = None  # CSV or Parquet files that feed inputs: `lockstep.plan.input_files`
    strict: bool = False  # refuse system files and model descriptions with offences that are else amended
    watch: Watch | None = None  # returns what looks at the recorded rows: `lockstep.results.monitor`
    check: Callable[[Plan], None] | None = None  # called before any FMU is started; it may raise InputError
    tick: str = "auto"  # what executes ticks: "python", "c", or C where it can be had; the results are equal
    threads: int | str | None = None  # that step FMUs beside each other, at most; None or "auto": where that is quicker
    kept: KeptFmus | None = None  # instances from earlier runs in this process, and for later ones
    scratch: bool = False  # the folder is read once and removed: signals stay an uncompressed stream, of longer blocks

    def __repr__(self) -> str:
        """Show what is given."""
        unset = RunOptions()
        given = {f.name: getattr(self, f.name) for f in fields(self)}
        shown = (f"{name}={value!r}" for name, value in given.items() if value != getattr(unset, name))
        return f"RunOptions({', '.join(shown)})"


class NamedOptions(TypedDict, total=False):
    """The fields of `RunOptions`, as keyword arguments."""

    stop_time: float | str | None
    overrides: Mapping[str, Override]
    record: Sequence[str] | None
    record_period: float | str | None
    progress: Progress | None
    overwrite: bool
    step_limit: float | str | None
    faults: Sequence[Scenario]
    pace: float | str | Pacer | None
    realtime_priority: int | str | None
    core: int | str | None
    profile: bool
    checkpoints: CheckpointSchedule
    restart: Restart | None
    tolerance: Tolerances | None
    strict_inputs: bool
    inputs: Paths | None
    strict: bool
    watch: Watch | None
    check: Callable[[Plan], None] | None
    tick: str
    threads: int | str | None
    kept: KeptFmus | None
    scratch: bool


def chosen_options(options: RunOptions | None, named: NamedOptions) -> RunOptions:
    """Return the options with those given by name in place of their fields; None there means none of them."""
    given = {k: v for k, v in named.items() if v is not None or k not in ("overrides", "faults", "checkpoints")}
    return replace(options or RunOptions(), **given)  # type: ignore[arg-type]
