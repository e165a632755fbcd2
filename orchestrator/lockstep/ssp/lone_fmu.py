"""Make a system of one FMU alone: its inputs keep their start values or are set, its outputs are recorded."""

from pathlib import Path

from lockstep.errors import InputError
from lockstep.fmi.model_description import Description, read_description
from lockstep.ssp.annotations import DeclaredSteps
from lockstep.ssp.step_times import Timing
from lockstep.system.clock import Time, nanoseconds
from lockstep.system.component import Component
from lockstep.system.system import System
from lockstep.whole_file import file_digest


def _stop_time(description: Description, start: Time, tick: Time) -> Time | None:
    """Return the stop time of the FMU's experiment [ns], in whole ticks from its start, or None."""
    if description.stop_time is None:
        return None
    try:
        stop = nanoseconds(description.stop_time, "stop time")
    except InputError:
        return None
    return start + (stop - start) // tick * tick if stop - start >= tick else None


def lone_fmu(path: Path, timing: Timing) -> System:
    """Return the system of an FMU, with its file name as the name of the component. Raises InputError."""
    path = path.absolute()
    name = path.stem.replace(".", "_")
    component = Component(name=name, source=path, period=1)
    description = read_description(component)
    warnings: list[str] = []
    period = timing.periods_of({name: (DeclaredSteps(), description)}, warnings)[name]
    component = Component(name=name, source=path, period=period, kind=timing.kind_of(name, DeclaredSteps()))
    tick = timing.tick_of(None, [period])
    start = nanoseconds(description.start_time or 0, f"{name}: the FMU's start time")
    system = System(
        name=name,
        tick=tick,
        start_time=start,
        stop_time=_stop_time(description, start, tick),
        components=(component,),
        path=path,
        sha256=file_digest(path),
        warnings=tuple(warnings),
    )
    timing.check_names(system)
    return system
