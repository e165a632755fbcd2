"""Write `fmus/manifest.json`: hash, GUID, versions and parameters of every built file."""

from __future__ import annotations

import json
import platform
from collections.abc import Mapping
from dataclasses import asdict, fields, replace
from functools import cache
from importlib.metadata import version
from pathlib import Path
from types import MappingProxyType
from typing import Any

from flexsat.description.configuration import Configuration
from flexsat.fmu.export import BuiltFmu
from flexsat.parameters import Aperture, ConfigurationName
from lockstep.whole_file import file_digest, write_whole

from .scenarios import SCENARIOS, scenario_parameters

MANIFEST = "manifest.json"
EARLIER = "earlier_build"  # marks a file that the last build of its configuration did not make
# packages that the content of an FMU depends on
PACKAGES = ("flexsat", "numpy", "scipy", "control", "clarabel", "pythonfmu", "matplotlib", "jinja2")


@cache  # each file of a build names them
def versions() -> Mapping[str, str]:
    """Return the versions that a build depends on."""
    return MappingProxyType({"python": platform.python_version(), **{name: version(name) for name in PACKAGES}})


def describe_configuration(
    config: Configuration, built: Mapping[str, BuiltFmu], others: list[Path], folder: Path
) -> dict[str, Any]:
    """Return the manifest's entry of one configuration; paths are relative to `folder`."""
    fmus = {
        fmu.path.relative_to(folder).as_posix(): {
            "component": component,
            "guid": fmu.guid,
            "sha256": fmu.sha256,
            "bytes": fmu.path.stat().st_size,
        }
        for component, fmu in built.items()
    }
    files = {path.relative_to(folder).as_posix(): {"sha256": file_digest(path)} for path in others}
    return {"versions": dict(versions()), "parameters": _parameters(config), "fmus": fmus, "files": files}


def _parameters(config: Configuration) -> dict[str, Any]:
    """Return all parameters; of modal data their hash, as their files lie beside the FMUs."""
    values = asdict(replace(config, appendages=(), aperture=config.aperture or Aperture()))
    return values | {
        "aperture": None if config.aperture is None else values["aperture"],
        "appendages": [
            {
                item.name: one.structure.digest.hex() if item.name == "structure" else getattr(one, item.name)
                for item in fields(one)
            }
            for one in config.appendages
        ],
    }


def write_manifest(folder: Path, entries: Mapping[ConfigurationName, dict[str, Any]]) -> dict[str, Any]:
    """Write the manifest and return it. What earlier builds left is kept if its files are unchanged.

    Of a configuration that is built anew it is marked: a build without missions leaves those of an earlier one.
    """
    path = folder / MANIFEST
    configurations: dict[str, Any] = dict(entries.items())
    for name, entry in _configurations(path).items():
        if name in entries:
            configurations[name] = _with_earlier(folder, entries[name], entry)
        elif _unchanged(folder, entry):
            configurations[name] = entry
    content = {
        "format": 1,
        "units": "SI: every parameter in the unit that flexsat.parameters gives it",
        "scenarios": {scenario: scenario_parameters(scenario) for scenario in SCENARIOS},
        "configurations": dict(sorted(configurations.items())),
    }
    write_whole(path, (json.dumps(content, indent=2) + "\n").encode())
    return content


def add_to_manifest(
    config: Configuration, built: Mapping[str, BuiltFmu], others: list[Path], folder: Path
) -> dict[str, Any]:
    """Add files to a configuration's entry in the manifest, and return the manifest."""
    entry = describe_configuration(config, built, others, folder)
    before = _configurations(folder / MANIFEST).get(config.name, {})
    return write_manifest(
        folder, {config.name: entry | {part: {**before.get(part, {}), **entry[part]} for part in ("fmus", "files")}}
    )


def earlier_folders(folder: Path) -> list[Path]:
    """Return the folders with FMUs that the last build of their configuration left as they were."""
    entries = _configurations(folder / MANIFEST).values()
    return sorted(
        {folder / file.rpartition("/")[0] for one in entries for file, facts in one["fmus"].items() if EARLIER in facts}
    )


def _with_earlier(folder: Path, entry: dict[str, Any], before: Any) -> dict[str, Any]:
    """Return an entry with the files of another that it lacks and that are as they were, marked."""
    kept = {}
    for part in ("fmus", "files"):
        listed = before.get(part) if isinstance(before, dict) else None
        left = {
            file: facts | {EARLIER: True}
            for file, facts in (listed if isinstance(listed, dict) else {}).items()
            if file not in entry[part] and isinstance(facts, dict) and _unchanged(folder, {"fmus": {file: facts}})
        }
        kept[part] = {**entry[part], **left}
    return entry | kept


def _configurations(path: Path) -> dict[str, Any]:
    try:
        found = json.loads(path.read_text(encoding="utf-8"))["configurations"]
    except (OSError, ValueError, KeyError, TypeError, RecursionError):
        return {}  # none yet, or none that can be trusted
    return found if isinstance(found, dict) else {}


def _unchanged(folder: Path, entry: Any) -> bool:
    try:
        listed = {**entry["fmus"], **entry.get("files", {})}
        return all(file_digest(folder / name) == facts["sha256"] for name, facts in listed.items())
    except (OSError, KeyError, TypeError, AttributeError):
        return False
