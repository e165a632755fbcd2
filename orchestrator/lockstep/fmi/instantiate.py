"""Make a running instance of an FMU, whatever its version of FMI."""

from pathlib import Path

from lockstep.fmi.fmi1 import Fmi1Slave
from lockstep.fmi.fmi2 import Fmi2Slave
from lockstep.fmi.fmi3 import Fmi3Slave
from lockstep.fmi.log_callbacks import Log
from lockstep.fmi.model_description import Description
from lockstep.fmi.slave import Slave
from lockstep.system.component import Component


def instantiate(component: Component, description: Description, folder: Path, log: Log) -> Slave:
    """Unpack the FMU of a component into a folder, load and instantiate it, or raise RunError."""
    match description.version:
        case "1.0":
            return Fmi1Slave(component, description, folder, log)
        case "3.0":
            return Fmi3Slave(component, description, folder, log)
    return Fmi2Slave(component, description, folder, log)
