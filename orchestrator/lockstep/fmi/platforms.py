"""Where an FMU has the library for this machine.

FMI 1.0 and 2.0 name folders for x86 alone. FMI 2.0.5 refers to the tuples of FMI 3.0 for other processors, such
as aarch64-linux; tools also write libraries for these into the folder of x86.
"""

from collections.abc import Callable

import fmpy

PLATFORM = str(fmpy.platform)  # as FMI 1.0 and 2.0 name the folder of their binaries
_TUPLE = str(fmpy.platform_tuple)  # as FMI 3.0 does
PLATFORMS = {"1.0": PLATFORM, "2.0": PLATFORM, "3.0": _TUPLE}  # by version of FMI
_OTHERS = () if _TUPLE.startswith("x86") else (_TUPLE,)  # of FMI 2.0, before its own


def library_folders(version: str) -> tuple[str, ...]:
    """Return the folders below binaries/ that may have the library for this machine; the first is to be preferred."""
    return (*_OTHERS, PLATFORM) if version == "2.0" else (PLATFORMS[version],)


def library_path(identifier: str, version: str, has: Callable[[str], bool] = lambda _: False) -> str:
    """Return the path in an FMU of its library for this machine: the first that it has, or where it should be."""
    name = f"{identifier}{fmpy.sharedLibraryExtension}"
    paths = [f"binaries/{folder}/{name}" for folder in library_folders(version)]
    return next((path for path in paths if has(path)), f"binaries/{PLATFORMS[version]}/{name}")
