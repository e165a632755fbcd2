"""Replace the FMUs of a system by the native ones that `flexsat build` leaves beside them."""

from __future__ import annotations

import json
import zipfile
from dataclasses import replace
from pathlib import Path

from lockstep.errors import InputError
from lockstep.fmi.safe_zip import open_file
from lockstep.processes.isolation_policy import BUILD_RECORD
from lockstep.ssp.native_fmu import NATIVE, differing_data, of_other_data
from lockstep.system.component import Component
from lockstep.system.system import System


def with_native_fmus(system: System) -> System:
    """Return a system with the native FMU of each component that has one; names and values are the same.

    Raises
    ------
    InputError
        If no component has one, or one has other matrices than the FMU that it would replace.
    """
    components = tuple(_native(component) for component in system.components)
    if components == system.components and not any(map(is_native, components)):
        raise InputError(f"--native: {_why_none(system)}")
    return replace(system, components=components)


def is_native(component: Component) -> bool:
    """Return whether the FMU of a component is a native one of flexsat, as its build record says."""
    if component.sums is not None:
        return False
    try:
        with open_file(component.source, component.archive, component.name) as file, zipfile.ZipFile(file) as fmu:
            return bool(json.loads(fmu.read(BUILD_RECORD))["native"])
    except (InputError, OSError, ValueError, KeyError, TypeError, RecursionError, zipfile.BadZipFile):
        return False


def _native(component: Component) -> Component:
    if component.sums is not None or component.archive is not None or not native_fmu(component).is_file():
        return component
    found = differing_data((component.source, None), (native_fmu(component), None), component.name)
    if found:
        raise InputError(f"--native: {native_fmu(component)}{of_other_data(found, component.source)};"
                         " `flexsat build` makes both anew")  # fmt: skip
    return replace(component, source=native_fmu(component))


def _why_none(system: System) -> str:
    """Return why no component of a system can be replaced, and what to do."""
    fmus = [component for component in system.components if component.sums is None]
    archives = {component.archive for component in fmus if component.archive is not None}
    if len(archives) == 1:
        (archive,) = archives
        package = archive.parent / NATIVE / archive.name
        remedy = f"run {package}" if package.is_file() else "run the package of the native ones"
        return f"the FMUs of {system.name} are those inside {archive}; {remedy}"
    looked_for = ", ".join(str(native_fmu(component)) for component in fmus) or "nothing"
    return (f"no FMU of {system.name} has a native one beside it (looked for {looked_for}); "
            "`flexsat build` makes those of flexsat's components")  # fmt: skip


def native_fmu(component: Component) -> Path:
    """Return where the native FMU of a component is, if it has one."""
    return component.source.parent / NATIVE / component.source.name
