"""Choose the FMUs of a study of many runs: native ones where `flexsat build` has left them, else those in Python."""

from __future__ import annotations

import zipfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from lockstep.errors import InputError
from lockstep.system.component import Component
from lockstep.system.system import System

from .native_fmus import is_native, native_fmu, with_native_fmus

PrintLine = Callable[[str], None]
IN_C, IN_PYTHON, OTHER = "native", "Python", "other"


@dataclass(frozen=True, slots=True, kw_only=True)
class FmuChoice:
    """Which FMUs the runs of a study have."""

    native: bool  # replace those of the system file by the native ones beside them
    kind: str  # of the FMUs simulated: native, Python, or which component has which
    note: str = ""  # why they are not native

    @property
    def text(self) -> str:
        """The choice as a line to print."""
        return f"FMUs: {self.kind}" + (f"; {self.note}" if self.note else "")

    def of(self, system: System) -> System:
        """Return a system with the chosen FMUs."""
        return with_native_fmus(system) if self.native else system


def choose_fmus(systems: Sequence[System], python: bool = False) -> FmuChoice:
    """Return the FMUs for all runs of a study: native where every system has some, and they are of the same design.

    Parameters
    ----------
    systems : of the study, as their files say
    python : keep the FMUs of the system files
    """
    if python:
        kind = kind_of(systems)
        return FmuChoice(native=False, kind=kind, note="--python" if IN_C not in kind else "of the system file")
    without = [system for system in systems if not any(is_native(c) or _has_native(c) for c in system.components)]
    if without:
        own = [c for system in without for c in system.components if component_kind(c) == IN_PYTHON]
        note = f"no native ones in {native_fmu(own[0]).parent}; `flexsat build` makes them" if own else ""
        return FmuChoice(native=False, kind=kind_of(systems), note=note)
    try:
        chosen = [with_native_fmus(system) for system in systems]
    except InputError as error:
        return FmuChoice(native=False, kind=kind_of(systems), note=str(error).removeprefix("--native: "))
    return FmuChoice(native=True, kind=kind_of(chosen))


def silent(line: str) -> None:
    """Report nothing."""


def _has_native(component: Component) -> bool:
    return component.sums is None and component.archive is None and native_fmu(component).is_file()


def kind_of(systems: Sequence[System]) -> str:
    """Return the kind of the FMUs, with the names of their components where there are several kinds."""
    names: dict[str, dict[str, None]] = {}
    for system in systems:
        for component in system.components:
            if component.sums is None:
                names.setdefault(component_kind(component), {})[component.name] = None
    if len(names) == 1:
        return next(iter(names))
    return ", ".join(f"{kind} ({', '.join(names[kind])})" for kind in (IN_C, IN_PYTHON, OTHER) if kind in names)


def component_kind(component: Component) -> str:
    """Return the kind of a component's FMU: native, Python, or other."""
    if is_native(component):
        return IN_C
    return IN_PYTHON if _brings_python(component.source) else OTHER


def _brings_python(fmu: Path) -> bool:
    try:
        with zipfile.ZipFile(fmu) as archive:
            return any(name.startswith("resources/") and name.endswith(".py") for name in archive.namelist())
    except (OSError, zipfile.BadZipFile):
        return False  # the master refuses it, and says why
