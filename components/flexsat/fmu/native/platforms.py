"""The platforms that native FMUs are built for: folders of FMI 2.0, tuples of FMI 3.0, and what each library needs.

FMI 2.0.5 has names for x86 alone and refers to the tuples of FMI 3.0 for all else, hence `aarch64-linux`. The folder
`darwin64` holds a universal library, since tools on Macs with ARM look there too.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from ...ports.table import FmiVersion

HERE = "linux64"  # what this machine's own compiler builds for


@dataclass(frozen=True, slots=True, kw_only=True)
class Platform:
    """A folder of binaries: the tuples of FMI 3.0 whose code its library has, and the suffix of the library."""

    targets: tuple[str, ...]
    suffix: str


PLATFORMS = {
    HERE: Platform(targets=("x86_64-linux",), suffix=".so"),
    "win64": Platform(targets=("x86_64-windows",), suffix=".dll"),
    "aarch64-linux": Platform(targets=("aarch64-linux",), suffix=".so"),
    "darwin64": Platform(targets=("x86_64-darwin", "aarch64-darwin"), suffix=".dylib"),
}
_NEEDS = {
    "x86_64-linux": "Linux on x86-64 with glibc 2.17 or newer",
    "x86_64-windows": "Windows on x86-64 with the Universal C Runtime, which Windows 10 and newer have",
    "aarch64-linux": "Linux on 64-bit ARM with glibc 2.17 or newer",
    "x86_64-darwin": "macOS 11 or newer on x86-64 (not tested)",
    "aarch64-darwin": "macOS 11 or newer on ARM (not tested)",
}
_NEEDS_HERE = "Linux on x86-64 with glibc 2.29 or newer"
_FOLDER_OF_ARM = (
    "; the folder has the name of FMI 3.0, as FMI 2.0.5 wants it: for tools that look in linux64 there, "
    "such as FMPy, move the library to a folder of that name"
)


def folders(platforms: Sequence[str], fmi: FmiVersion) -> dict[str, tuple[str, ...]]:
    """Return folders below binaries/, each with the tuples of FMI 3.0 whose code its library has.

    No platform stands for that of this machine.
    """
    targets = [(name, PLATFORMS[name].targets) for name in platforms or (HERE,)]
    if fmi == "2.0":
        return dict(targets)
    return {target: (target,) for _, several in targets for target in several}


def needs(platforms: Sequence[str], fmi: FmiVersion) -> tuple[tuple[str, str], ...]:
    """Return folders below binaries/, each with what the library in it needs."""
    found = []
    for folder, targets in folders(platforms, fmi).items():
        text = ", and ".join(_NEEDS[target] for target in targets) if platforms else _NEEDS_HERE
        found.append((folder, text + _FOLDER_OF_ARM if folder == "aarch64-linux" and fmi == "2.0" else text))
    return tuple(found)
