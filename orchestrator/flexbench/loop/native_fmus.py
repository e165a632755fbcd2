"""Replace the FMUs of a system by the native ones that `flexsat build` leaves beside them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from flexsat.fmu.native.sources import NATIVE
from lockstep.errors import InputError
from lockstep.system.component import Component
from lockstep.system.system import System


def with_native_fmus(system: System) -> System:
    """Return a system with the native FMU of each component that has one; names and values are the same.

    Raises
    ------
    InputError
        If no component has one.
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
    return replace(component, source=_path(component))


def _path(component: Component) -> Path:
    return component.source.parent / NATIVE / component.source.name
