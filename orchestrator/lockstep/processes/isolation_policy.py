"""Decide which components run in processes of their own where neither the system nor its user does.

Those are FMUs that `flexsat build` did not make, FMUs that allow one instance per process and have one already, and
FMUs that hold a Python module or library of which another FMU holds a different copy: a process has one of each name.

Where those are more than a few, the ones that are not suspected share one process: a crash ends the run anyhow, and is
attributed to the FMU whose call was under way. Suspected are FMUs that say or show that they use more of a process than
their own memory: those of FMI 1.0, which do not say it, those that allow one instance per process or need a tool, and
those that bring Python. What the system or its user isolates has a process of its own.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Set
from dataclasses import dataclass, replace
from pathlib import PurePosixPath

from lockstep.errors import InputError
from lockstep.fmi.model_description import Description
from lockstep.fmi.platforms import library_folders
from lockstep.fmi.safe_zip import open_file, open_zip
from lockstep.system.component import Component
from lockstep.system.system import System

BUILD_RECORD = "resources/build.json"  # of the export, with the GUID of its FMU
FEW = 4  # processes of FMUs that are not suspected: so many work side by side
_CODE = (".py", ".so")

Modules = Mapping[str, frozenset[tuple[str, int]]]  # path and checksum of every file, by module


@dataclass(frozen=True, slots=True, kw_only=True)
class Contents:
    """The content of an FMU's archive that decides."""

    own: bool
    modules: Modules


def settle(system: System, descriptions: Mapping[str, Description]) -> System:
    """Return the system with `isolated` decided for every component, or raise InputError."""
    every = [*system.components, *(c.shadow.component for c in system.components if c.shadow)]
    every = [c for c in every if c.sums is None]  # in the master's process, without a library
    contents = {c.name: read_contents(c, descriptions[c.name]) for c in every if c.isolated is not True}
    inside: list[Component] = []  # the master's process; first those that have to be there
    decided: dict[str, bool] = {}
    for component in sorted(every, key=lambda c: c.isolated is not False):
        isolated = component.isolated
        if isolated is not True:
            conflict = next((text for c in inside if (text := _conflict(component, c, contents, descriptions))), "")
            if conflict and isolated is False:
                raise InputError(f"{component.name}: {conflict}; run one of them in a process of its own")
            isolated = bool(conflict) or (isolated is None and not contents[component.name].own)
        if not isolated:
            inside.append(component)
        decided[component.name] = isolated
    together: list[Component] = []
    for component in every:
        if component.isolated is None and decided[component.name]:
            suspected = _suspected(descriptions[component.name], contents[component.name])
            if not suspected and not any(_conflict(component, c, contents, descriptions) for c in together):
                together.append(component)
    grouped = frozenset(c.name for c in together) if len(together) > FEW else frozenset()
    return replace(system, components=tuple(_settled(c, decided, grouped) for c in system.components))


def _settled(component: Component, decided: Mapping[str, bool], grouped: Set[str]) -> Component:
    shadow = component.shadow
    if shadow is not None:
        shadow = replace(shadow, component=_settled(shadow.component, decided, grouped))
    isolated = decided.get(component.name, False)
    return replace(component, isolated=isolated, grouped=component.name in grouped, shadow=shadow)


def _suspected(description: Description, contents: Contents) -> bool:
    """Return whether an FMU may disturb others in its process."""
    python = any(path.endswith(".py") for files in contents.modules.values() for path, _ in files)
    return description.version == "1.0" or description.once_per_process or description.needs_tool or python


def read_contents(component: Component, description: Description) -> Contents:
    """Return the content of an FMU's archive that decides."""
    library, own_folders = f"{description.identifier}.so", library_folders(description.version)
    files: dict[str, set[tuple[str, int]]] = {}
    with (
        open_file(component.source, component.archive, component.name) as stream,
        open_zip(stream, f"{component.name}: {component.source}") as archive,
    ):
        own = False
        if BUILD_RECORD in archive.namelist():
            try:
                own = json.loads(archive.read(BUILD_RECORD))["guid"] == description.guid
            except (ValueError, KeyError, TypeError, RecursionError):
                own = False
        for member in archive.infolist():
            path = PurePosixPath(member.filename)
            if path.suffix not in _CODE:
                continue
            if path.parts[0] == "resources":
                files.setdefault(path.parts[1].partition(".")[0], set()).add((member.filename, member.CRC))
            elif path.parts[0] == "binaries" and path.parts[1] in own_folders and path.name != library:
                files.setdefault(path.name, set()).add((member.filename, member.CRC))
    return Contents(own=own, modules={name: frozenset(found) for name, found in files.items()})


def _conflict(
    component: Component,
    other: Component,
    contents: Mapping[str, Contents],
    descriptions: Mapping[str, Description],
) -> str:
    """Return why two components cannot share a process; "" if they can."""
    one, two = descriptions[component.name], descriptions[other.name]
    if one.sha256 == two.sha256:
        once = one.once_per_process
        return f"the FMU allows one instance per process, and {other.name} is it already" if once else ""
    here, there = contents[component.name].modules, contents[other.name].modules
    differing = sorted(name for name in here.keys() & there.keys() if here[name] != there[name])
    return f"brings another copy of {differing[0]} than {other.name}" if differing else ""
