"""Build the FMUs of a campaign's spacecraft files, once for each content: a file as it is, or with fields of a case."""

from __future__ import annotations

import hashlib
import re
import shutil
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from flexsat.description.spacecraft_file import SpacecraftFile, parse_spacecraft
from flexsat.errors import SpacecraftFileError
from flexsat.fmu.native.sources import NATIVE
from lockstep.data_text import parse_toml
from lockstep.errors import InputError
from lockstep.results.run_record import to_toml

from ..loop.fmu_choice import PrintLine
from ..loop.spacecraft import check_built_in_names, read_file
from .campaign_file import Campaign, Input, is_spacecraft
from .distributions import Value, with_unit
from .sampling import Case

_FIELD = re.compile(r"[A-Za-z_]\w*(\.[A-Za-z_]\w*|\[[1-9]\d*\])*")


def build_spacecraft(
    campaign: Campaign, cases: Sequence[Case], paths: Mapping[str, Path], folder: Path, report: PrintLine
) -> tuple[Sequence[Mapping[str, str]], dict[str, Path]]:
    """Return the paths of all systems of a campaign, of spacecraft files those of FMUs that are built for them.

    Where inputs change fields of the files, each case has systems of its own, of the same content once: their keys in
    the paths then, by name, for each case. What a folder holds is not built again.

    Raises
    ------
    InputError
        If a file is refused with the values of a case: all are read before the first one is built.
    """
    fields = [one for one in campaign.inputs if one.kind == "spacecraft"]
    if not fields:
        return (), {
            name: _built(path, read_file(path), campaign, folder, report) if is_spacecraft(path) else path
            for name, path in paths.items()
        }
    _check(fields, paths, campaign.path.name)
    found: dict[str, tuple[Path, SpacecraftFile]] = {}
    keys: list[dict[str, str]] = []
    for number, values in enumerate(cases, start=1):
        keys.append({})
        for name, path in paths.items():
            spacecraft = _changed(path, fields, values, f"{campaign.path.name}: case {number}")
            keys[-1][name] = key = f"{name} {_digest(spacecraft)}"
            found[key] = path, spacecraft
    return keys, {
        key: _built(path, spacecraft, campaign, folder, report, f" ({number} of {len(found)})")
        for number, (key, (path, spacecraft)) in enumerate(found.items(), start=1)
    }


def _built(
    path: Path, spacecraft: SpacecraftFile, campaign: Campaign, folder: Path, report: PrintLine, which: str = ""
) -> Path:
    from ..loop.build import build_files

    target = folder / "spacecraft" / _digest(spacecraft)
    fmus = target / spacecraft.name
    system = (fmus if campaign.python else fmus / NATIVE) / f"{campaign.scenario}.ssd"
    if not target.is_dir():
        report(f"{path.name}: building its FMUs{which}")
        partial = target.with_name(f".{target.name}")
        shutil.rmtree(partial, ignore_errors=True)  # of a process that was killed
        build_files([spacecraft], partial, lambda _: None)
        partial.replace(target)
    if not system.is_file():
        raise InputError(f"{path}: campaign: scenario = {campaign.scenario!r}: no such system; {system} is missing")
    return system


def _digest(spacecraft: SpacecraftFile) -> str:
    content = repr((spacecraft.text, sorted(spacecraft.files.items())))
    return hashlib.sha256(content.encode()).hexdigest()[:12]


def _check(fields: Sequence[Input], paths: Mapping[str, Path], where: str) -> None:
    for one in fields:
        for target in one.targets:
            if not _FIELD.fullmatch(target):
                raise InputError(f"{where}: input.{one.name}: spacecraft = {target!r}: write a key of the file, such as"
                                 " bus.mass or bus.inertia[1]")  # fmt: skip
    for name, path in paths.items():
        if not is_spacecraft(path):
            raise InputError(f"{where}: systems: {path.name}: input.{fields[0].name} changes spacecraft files; give"
                             f" {name} as one (.toml)")  # fmt: skip


def _changed(path: Path, fields: Sequence[Input], values: Case, where: str) -> SpacecraftFile:
    """Return a spacecraft with the fields of a case."""
    original = read_file(path)
    tables = parse_toml(original.text.encode(), str(path))
    for one in fields:
        for target in one.targets:
            _set(tables, target, with_unit(values[one.name], one.unit), f"{path.name}: input.{one.name}")
    given = ", ".join(f"{one.name} = {values[one.name]!r}" for one in fields)
    try:
        changed = parse_spacecraft(to_toml(tables), path.name, path.parent)
    except SpacecraftFileError as error:
        raise InputError(f"{where} ({given}): {error}") from None
    check_built_in_names(changed, path.name)
    return changed


def _set(tables: dict[str, Any], target: str, value: Value, where: str) -> None:
    """Write a value to a key, which may be of a table that the file leaves out."""
    *parts, last = re.findall(r"\w+|\[\d+\]", target)
    place: Any = tables
    for part in parts:
        place = _entry(place, part, target, where) if part[0] == "[" else place.setdefault(part, {})
        if not isinstance(place, dict | list):
            raise InputError(f"{where}: spacecraft = {target!r}: {part} is no table of the file; correct the key")
    if last[0] == "[":
        _entry(place, last, target, where)
        place[int(last[1:-1]) - 1] = value
    elif isinstance(place, dict):
        place[last] = value
    else:
        raise InputError(f"{where}: spacecraft = {target!r}: {last} follows a list; write the entry's number, from [1]")


def _entry(place: Any, part: str, target: str, where: str) -> Any:
    number = int(part[1:-1])
    if not isinstance(place, list) or number > len(place):
        count = len(place) if isinstance(place, list) else 0
        raise InputError(f"{where}: spacecraft = {target!r}: {part}: the file has {count} entries there; write them in"
                         " the file, or correct the number")  # fmt: skip
    return place[number - 1]
