"""What the documentation of an FMU in C says of its library."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class NativeNotes:
    """How the library is built, and which are there.

    Attributes
    ----------
    compile_command, microsoft_command : build the library in the folder sources/
    binaries : folders below binaries/, each with what its library needs
    """

    compile_command: str
    microsoft_command: str
    binaries: tuple[tuple[str, str], ...]
