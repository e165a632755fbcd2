"""Make a system of one FMU alone: its inputs keep their start values or are set, its outputs are recorded."""

import hashlib
from pathlib import Path

from lockstep.fmi.model_description import read_description
from lockstep.ssp.annotations import DeclaredSteps
from lockstep.ssp.step_times import Timing
from lockstep.system.component import Component
from lockstep.system.system import System


def lone_fmu(path: Path, timing: Timing) -> System:
    """Return the system of an FMU, with its file name as the name of the component. Raises InputError."""
    path = path.absolute()
    name = path.stem.replace(".", "_")
    component = Component(name=name, source=path, period=1)
    description = read_description(component)
    warnings: list[str] = []
    period = timing.periods_of({name: (DeclaredSteps(), description)}, warnings)[name]
    component = Component(name=name, source=path, period=period, kind=timing.kind_of(name, DeclaredSteps()))
    system = System(
        name=name,
        tick=timing.tick_of(None, [period]),
        components=(component,),
        path=path,
        sha256=hashlib.sha256(path.read_bytes()).hexdigest(),
        warnings=tuple(warnings),
    )
    for named in timing.names():
        system.component(named)
    return system
