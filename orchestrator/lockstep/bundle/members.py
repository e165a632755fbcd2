"""Unpack the FMUs of a system to the files of a bundle: a binary cannot unpack a zip file by itself."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path

from lockstep.bundle.contents import Contents
from lockstep.bundle.platforms import PLATFORMS
from lockstep.errors import InputError
from lockstep.fmi.library import unpack_fmu
from lockstep.fmi.model_description import Description
from lockstep.fmi.temporary_folder import temporary_folder
from lockstep.system.component import Component

_LICENSES = "documentation/licenses/"


def folders(contents: Contents) -> dict[str, str]:
    """Return the folder of each component below resources/; components of one FMU share it."""
    found: dict[str, str] = {}
    by_digest: dict[str, str] = {}
    for number, component in enumerate(contents.system.components):
        name = re.sub(r"\W+", "_", component.name, flags=re.ASCII)[:40]
        digest = contents.descriptions[component.name].sha256
        found[component.name] = by_digest.setdefault(digest, f"{number}_{name}")
    return found


def members(contents: Contents, platforms: Sequence[str]) -> dict[str, bytes]:
    """Return the files of all FMUs by their path in the bundle: what they need to run, and their licences.

    Raises
    ------
    InputError
        If an FMU cannot be read, or has no binary for a platform.
    """
    found: dict[str, bytes] = {}
    done: set[str] = set()
    places = folders(contents)
    with temporary_folder("bundle") as temporary:
        for component in contents.system.components:
            place = places[component.name]
            if place not in done:
                done.add(place)
                unpacked = temporary / place
                unpack_fmu(component, unpacked)
                description = contents.descriptions[component.name]
                found |= _needed(component, description, unpacked, place, platforms)
    return found


def _needed(
    component: Component, description: Description, unpacked: Path, place: str, platforms: Sequence[str]
) -> Mapping[str, bytes]:
    chosen: list[str] = []
    for name in platforms:
        platform = PLATFORMS[name]
        places = platform.folders[description.version]
        paths = [f"binaries/{folder}/{description.identifier}{platform.suffix}" for folder in places]
        path = next((path for path in paths if (unpacked / path).is_file()), None)
        if path is None:
            binaries = sorted(one.name for one in (unpacked / "binaries").iterdir() if one.is_dir())
            raise InputError(
                f"{component.name}: {component.source.name} has no binary for {name}, only for {', '.join(binaries)}; "
                "build it for that platform, or leave the platform out of --platforms"
            )
        chosen.append(path.rpartition("/")[0] + "/")
    found: dict[str, bytes] = {}
    for file in sorted(path for path in unpacked.rglob("*") if path.is_file()):
        inside = file.relative_to(unpacked).as_posix()
        if inside == "modelDescription.xml" or inside.startswith(("resources/", *chosen)):
            found[f"resources/{place}/{inside}"] = file.read_bytes()
        elif inside.startswith(_LICENSES):
            found[f"{_LICENSES}{place}/{inside.removeprefix(_LICENSES)}"] = file.read_bytes()
    return found
