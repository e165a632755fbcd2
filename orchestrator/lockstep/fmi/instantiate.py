"""Make a running instance of an FMU, whatever its version of FMI."""

from collections.abc import Iterable
from pathlib import Path

from lockstep.fmi.fmi1 import Fmi1Slave
from lockstep.fmi.fmi2 import Fmi2Slave
from lockstep.fmi.fmi3 import Fmi3Slave
from lockstep.fmi.instance import Hooks
from lockstep.fmi.library import UnpackedFmu, unpack_fmu
from lockstep.fmi.log_callbacks import Log
from lockstep.fmi.model_description import Description, Variable
from lockstep.system.component import Component


def instantiate(
    component: Component, description: Description, folder: Path, log: Log, *, alone: bool = False
) -> Fmi1Slave | Fmi2Slave | Fmi3Slave:
    """Unpack the FMU of a component into a folder, load and instantiate it, or raise RunError.

    `alone` says that this process is for this FMU only: its working directory may change.
    """
    unpack_fmu(component, folder)
    fmu = UnpackedFmu(
        name=component.name,
        folder=folder,
        identifier=description.identifier,
        guid=description.guid,
        alone=alone,
        tolerance=description.tolerance_of(component),
        native=not description.needs_tool and not any(Path(folder, "resources").glob("*.py")),
    )
    return instantiate_unpacked(fmu, description.version, description.variables.values(), Hooks(log=log))


def instantiate_unpacked(
    fmu: UnpackedFmu, version: str, variables: Iterable[Variable], hooks: Hooks
) -> Fmi1Slave | Fmi2Slave | Fmi3Slave:
    """Load and instantiate an unpacked FMU; FMI 3.0 needs the variables that it declares."""
    match version:
        case "1.0":
            return Fmi1Slave(fmu, hooks)
        case "3.0":
            return Fmi3Slave(fmu, variables, hooks)
    return Fmi2Slave(fmu, hooks)
