"""Export the controller of a built FMU as C for flight software: the design that flies in simulation."""

from __future__ import annotations

import io
import zipfile
from pathlib import Path

from flexsat.controller_weights import ControllerDesign
from flexsat.fmu.embedded.export import HEADER, controller_files
from flexsat.fmu.embedded.header import Precision
from flexsat.fmu.python.load_matrices import MODEL_FILE, load_matrices
from flexsat.parameters import ConfigurationName
from flexsat.runtime.controller_parameters import ControllerMatrices
from flexsat.variants import OF_DESIGN
from lockstep.errors import InputError
from lockstep.whole_file import write_whole


def export_controller(
    fmus: Path, configuration: ConfigurationName, design: ControllerDesign, precision: Precision, folder: Path
) -> int:
    """Write the files into a folder, new or of an earlier export, and return how many there are.

    Raises
    ------
    InputError
        If there is no FMU of the controller, it carries no matrices, or the folder holds other files.
    """
    matrices = _matrices(fmus / configuration / "controller.fmu", design)
    files = controller_files(matrices, configuration, design, precision)
    if folder.is_dir() and any(folder.iterdir()) and not (folder / HEADER).is_file():
        raise InputError(f"{folder}: holds files that are no exported controller; name a new or an empty folder")
    for name, content in files.items():
        write_whole(folder / name, content)
    return len(files)


def _matrices(fmu: Path, design: ControllerDesign) -> ControllerMatrices:
    try:
        with zipfile.ZipFile(fmu) as archive:
            content = archive.read(f"resources/{MODEL_FILE}")
        return load_matrices(io.BytesIO(content), ControllerMatrices, OF_DESIGN[design])
    except FileNotFoundError:
        raise InputError(f"{fmu}: no such file; `flexsat build` makes the FMUs that are exported") from None
    except (KeyError, ValueError, EOFError, zipfile.BadZipFile) as error:
        raise InputError(f"{fmu}: no controller of flexsat ({error}); `flexsat build` makes one") from None
