"""Pack a bundle: equal systems and FMUs give equal bytes."""

from __future__ import annotations

import hashlib
import io
import uuid
import zipfile
from collections.abc import Mapping, Sequence
from dataclasses import replace

from lockstep.bundle.compile import library
from lockstep.bundle.contents import Contents
from lockstep.bundle.declared import identifier
from lockstep.bundle.documentation import documentation
from lockstep.bundle.members import folders, members
from lockstep.bundle.model_description import model_description
from lockstep.bundle.model_description3 import model_description3
from lockstep.bundle.platforms import PLATFORMS
from lockstep.bundle.program import program
from lockstep.bundle.program_file import PROGRAM, program_bytes
from lockstep.bundle.shown import shown
from lockstep.errors import InputError
from lockstep.fmi.platforms import PLATFORM
from lockstep.fmi.safe_zip import UNIX

_EPOCH = (1980, 1, 1, 0, 0, 0)  # the earliest time that a zip can hold
_MODE = 0o100644 << 16  # a plain file, readable by all


def bundle_bytes(contents: Contents, platforms: Sequence[str] = (), version: str = "2.0") -> bytes:
    """Return the FMU of a system.

    Parameters
    ----------
    contents : of the bundle
    platforms : keys of PLATFORMS, which Zig compiles for; none for this machine's, with its own C compiler
    version : of FMI that hosts see; the FMUs inside have their own

    Raises
    ------
    InputError
        If an FMU cannot be read or lacks a binary, or the C compiler is missing or fails.
    """
    names = tuple(platforms) or (_here(),)
    files = members(contents, names)
    variables = shown(contents.ports, contents.descriptions, version)
    contents = replace(contents, ports=tuple(port for variable in variables for port in variable.ports))
    places, operations = folders(contents), program(contents)

    def described(guid: str) -> bytes:
        return model_description3(contents, guid, variables) if version == "3.0" else model_description(contents, guid)

    guid = _guid(program_bytes(contents, operations, "", places, variables), described(""), contents)
    name = identifier(contents.system.name)
    for platform in names:
        path = f"binaries/{PLATFORMS[platform].folders[version][0]}/{name}{PLATFORMS[platform].suffix}"
        files[path] = library(platform if platforms else None, version)
    files[f"resources/{PROGRAM}"] = program_bytes(contents, operations, guid, places, variables)
    files["modelDescription.xml"] = described(guid)
    files["documentation/index.html"] = documentation(contents, names, version)
    return _packed(files)


def _here() -> str:
    """Return this machine's platform, which its own C compiler builds for."""
    if PLATFORM not in PLATFORMS:
        raise InputError(f"this machine is {PLATFORM}, for which no bundle can be built; use Linux on x86-64")
    return PLATFORM


def _guid(program: bytes, description: bytes, contents: Contents) -> str:
    digest = hashlib.sha256(program + description)
    for component in contents.system.components:
        digest.update(contents.descriptions[component.name].sha256.encode())
    return f"{{{uuid.uuid5(uuid.NAMESPACE_URL, digest.hexdigest())}}}"


def _packed(files: Mapping[str, bytes]) -> bytes:
    memory = io.BytesIO()
    with zipfile.ZipFile(memory, "w") as archive:
        # the model description first: tools read it without the rest
        for name in sorted(files, key=lambda name: (name != "modelDescription.xml", name)):
            info = zipfile.ZipInfo(name, _EPOCH)
            info.external_attr, info.create_system, info.compress_type = _MODE, UNIX, zipfile.ZIP_DEFLATED
            archive.writestr(info, files[name])
    return memory.getvalue()
