"""Find the description of a spacecraft: a built-in one, or the file that its FMUs were built from."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path

from flexsat.description.built_in import CONFIGURATIONS, built_in
from flexsat.description.configuration import check_name
from flexsat.description.spacecraft_file import START, SpacecraftFile, read_spacecraft
from flexsat.design.chain import Designs, build_designs, designs_of
from flexsat.errors import SpacecraftFileError
from flexsat.parameters import ConfigurationName
from lockstep.errors import InputError

FILE = "spacecraft.toml"  # in the folder of the FMUs, as it was when they were built
LEVELS = 4  # folders above an FMU in which the file may be: NAME/flat/native/fmi3


def read_file(path: Path) -> SpacecraftFile:
    """Read a spacecraft's file for a build; raise InputError if it is refused, or has the name of a built-in one."""
    try:
        spacecraft = read_spacecraft(path)
    except SpacecraftFileError as error:
        raise InputError(str(error)) from None
    check_built_in_names(spacecraft, path.name)
    return spacecraft


def check_built_in_names(spacecraft: SpacecraftFile, called: str) -> None:
    """Refuse a spacecraft that has the name of a built-in one, and another design, with InputError."""
    if spacecraft.name in CONFIGURATIONS and spacecraft.configurations != built_in(spacecraft.name).configurations:
        raise InputError(
            f'{called}: name = "{spacecraft.name}": a built-in spacecraft has this name, and another design; choose'
            " another name"
        )


def write_start(path: Path) -> None:
    """Write the file of a spacecraft to start from, named after the file.

    Raises
    ------
    InputError
        If there is such a file, it cannot be written, or its name is none of a spacecraft.
    """
    name = path.stem
    try:
        check_name(name)
    except ValueError as error:
        raise InputError(
            f"{path}: the spacecraft has the name of its file, which {str(error).partition(' ')[2]}"
        ) from None
    if name in CONFIGURATIONS:
        raise InputError(f"{path}: a built-in spacecraft is called {name}; choose another name")
    try:
        with path.open("x", encoding="utf-8") as file:
            file.write(START.read_text(encoding="utf-8").format(name=name))
    except FileExistsError:
        raise InputError(f"{path}: is there already, and is kept; choose another name") from None
    except OSError as error:
        raise InputError(f"{path}: cannot be written ({error.strerror}); choose another folder") from None


def spacecraft_of(name: ConfigurationName, fmu: Path) -> SpacecraftFile:
    """Return the description of the spacecraft that an FMU was built for.

    Raises
    ------
    InputError
        If it is not built in, and there is no file of it with the FMU.
    """
    if name in CONFIGURATIONS:
        return built_in(name)
    return read_file(_file_of(name, fmu))


def _file_of(name: ConfigurationName, fmu: Path) -> Path:
    for folder in fmu.parents[:LEVELS]:
        path = folder / FILE
        if path.is_file() and read_file(path).name == name:
            return path
    raise InputError(
        f"{name}: no built-in spacecraft, and no {FILE} of it with {fmu}; build its FMUs with `flexsat build FILE`"
    )


def designs_for(name: ConfigurationName, fmu: Path) -> Designs:
    """Return the designs of the spacecraft that an FMU was built for; raise InputError if they are not known."""
    if name in CONFIGURATIONS:
        return build_designs(name)
    path = _file_of(name, fmu)
    return _designs(path, path.read_bytes())


def design_file(spacecraft: SpacecraftFile, path: Path) -> Designs:
    """Run the design chain of a spacecraft's file; raise InputError if there is no design."""
    designs = designs_of(spacecraft.configurations["robust"], spacecraft.configurations["published"])
    try:
        for variant in designs.variants:
            designs.variant(variant)
    except ValueError as error:
        raise InputError(f"{path.name}: {error}") from None
    return designs


@lru_cache(maxsize=2)
def _designs(path: Path, _content: bytes) -> Designs:
    return design_file(read_file(path), path)
