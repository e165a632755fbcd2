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
from collections.abc import Iterator, Mapping, Set
from contextlib import contextmanager
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
_MOST_READ = 100  # contents that are kept

Modules = Mapping[str, frozenset[tuple[str, int]]]  # path and checksum of every file, by module


@dataclass(frozen=True, slots=True, kw_only=True)
class Contents:
    """The content of an FMU's archive that decides."""

    own: bool
    modules: Modules


@dataclass(frozen=True, slots=True, kw_only=True)
class _Part:
    """A component that is, or may be, in the master's process."""

    name: str
    contents: Contents
    description: Description
    run: str = ""  # the name of the system of another run

    @property
    def where(self) -> str:
        """How messages name it."""
        return f"{self.name} of {self.run}, a run that is open," if self.run else self.name


_of_open_runs: list[_Part] = []
_read: dict[str, Contents] = {}  # by digest


@contextmanager
def in_this_process(system: System, descriptions: Mapping[str, Description]) -> Iterator[None]:
    """Have runs that are opened inside the block, in this process, consider the FMUs of this run that are in it."""
    every = [*system.components, *(c.shadow.component for c in system.components if c.shadow)]
    inside = [_part(c, descriptions[c.name]) for c in every if not c.isolated and c.sums is None]
    parts = [replace(part, run=system.name) for part in inside]
    _of_open_runs.extend(parts)
    try:
        yield
    finally:
        _of_open_runs[:] = [other for other in _of_open_runs if not any(other is part for part in parts)]


def settle(system: System, descriptions: Mapping[str, Description]) -> System:
    """Return the system with `isolated` decided for every component, or raise InputError."""
    every = [*system.components, *(c.shadow.component for c in system.components if c.shadow)]
    every = [c for c in every if c.sums is None]  # in the master's process, without a library
    parts = {c.name: _part(c, descriptions[c.name]) for c in every if c.isolated is not True}
    inside = list(_of_open_runs)  # the master's process; first those that have to be there
    decided: dict[str, bool] = {}
    for component in sorted(every, key=lambda c: c.isolated is not False):
        isolated = component.isolated
        if isolated is not True:
            conflict = next((text for part in inside if (text := _conflict(parts[component.name], part))), "")
            if conflict and isolated is False:
                raise InputError(f"{component.name}: {conflict}; run one of them in a process of its own")
            isolated = bool(conflict) or (isolated is None and not parts[component.name].contents.own)
        if not isolated:
            inside.append(parts[component.name])
        decided[component.name] = isolated
    together: list[_Part] = []
    for component in every:
        if component.isolated is None and decided[component.name]:
            part = parts[component.name]
            if not _suspected(part) and not any(_conflict(part, other) for other in together):
                together.append(part)
    grouped = frozenset(part.name for part in together) if len(together) > FEW else frozenset()
    return replace(system, components=tuple(_settled(c, decided, grouped) for c in system.components))


def refuse_without_isolated(system: System, what: str) -> None:
    """Raise InputError if no component, nor shadow, of a settled system is isolated; `what` needs one."""
    if not any(c.isolated or (c.shadow is not None and c.shadow.component.isolated) for c in system.components):
        name = system.components[0].name
        raise InputError(
            f"{what}: no FMU of this run is isolated; isolate one, for example --isolate {name}, or leave it out"
        )


def _settled(component: Component, decided: Mapping[str, bool], grouped: Set[str]) -> Component:
    shadow = component.shadow
    if shadow is not None:
        shadow = replace(shadow, component=_settled(shadow.component, decided, grouped))
    isolated = decided.get(component.name, False)
    return replace(component, isolated=isolated, grouped=component.name in grouped, shadow=shadow)


def _suspected(part: _Part) -> bool:
    """Return whether an FMU may disturb others in its process."""
    description = part.description
    python = any(path.endswith(".py") for files in part.contents.modules.values() for path, _ in files)
    return description.version == "1.0" or description.once_per_process or description.needs_tool or python


def read_contents(component: Component, description: Description) -> Contents:
    """Return the content of an FMU's archive that decides."""
    if description.sha256 not in _read:
        if len(_read) >= _MOST_READ:
            del _read[next(iter(_read))]
        _read[description.sha256] = _contents(component, description)
    return _read[description.sha256]


def _contents(component: Component, description: Description) -> Contents:
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


def _part(component: Component, description: Description) -> _Part:
    return _Part(name=component.name, contents=read_contents(component, description), description=description)


def _conflict(one: _Part, other: _Part) -> str:
    """Return why two components cannot share a process; "" if they can."""
    if one.description.sha256 == other.description.sha256:
        once = one.description.once_per_process
        return f"the FMU allows one instance per process, and {other.where} is it already" if once else ""
    here, there = one.contents.modules, other.contents.modules
    differing = sorted(name for name in here.keys() & there.keys() if here[name] != there[name])
    return f"brings another copy of {differing[0]} than {other.where}" if differing else ""
