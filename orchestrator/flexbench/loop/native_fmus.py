"""Replace the FMUs of a system by the native ones that `flexsat build` leaves beside them."""

from __future__ import annotations

import zipfile
from dataclasses import replace
from pathlib import Path

from flexsat.fmu.native.sources import NATIVE
from lockstep.errors import InputError
from lockstep.system.component import Component
from lockstep.system.system import System

MATRICES = "resources/model.npz"  # in both; equal designs have equal bytes


def with_native_fmus(system: System) -> System:
    """Return a system with the native FMU of each component that has one; names and values are the same.

    Raises
    ------
    InputError
        If no component has one, or one is of another design than the FMU that it would replace.
    """
    components = tuple(_native(component) for component in system.components)
    if components == system.components:
        looked_for = ", ".join(str(_path(c)) for c in system.components if c.sums is None) or "nothing"
        raise InputError(f"--native: no FMU of {system.name} has a native one beside it (looked for {looked_for}); "
                         "`flexsat build` makes those of flexsat's components")  # fmt: skip
    return replace(system, components=components)


def _native(component: Component) -> Component:
    if component.sums is not None or component.archive is not None or not _path(component).is_file():
        return component
    if _of_another_design(component.source, _path(component)):
        raise InputError(f"--native: {_path(component)} has other matrices than {component.source}, as it is older or"
                         " newer; `flexsat build` makes both anew")  # fmt: skip
    return replace(component, source=_path(component))


def _of_another_design(fmu: Path, native: Path) -> bool:
    """Return whether the two carry different matrices; files that are no FMUs of flexsat are left to the master."""
    try:
        with zipfile.ZipFile(fmu) as first, zipfile.ZipFile(native) as second:
            one, other = first.getinfo(MATRICES), second.getinfo(MATRICES)
    except (OSError, KeyError, zipfile.BadZipFile):
        return False
    return (one.CRC, one.file_size) != (other.CRC, other.file_size)


def _path(component: Component) -> Path:
    return component.source.parent / NATIVE / component.source.name
