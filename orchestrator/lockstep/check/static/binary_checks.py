"""Static checks of the binaries: platforms, exported functions against capability flags, what must be there to load."""

from __future__ import annotations

import re
import struct
import tempfile
from collections.abc import Iterable, Iterator
from contextlib import suppress
from pathlib import Path, PurePosixPath

from lockstep.check.static.elf import BITS, MACHINE, Library, exported_with_dependencies, find_library, read_library
from lockstep.check.static.exported import functions_of, functions_of_flags
from lockstep.check.static.fmu_archive import FmuArchive, unreadable
from lockstep.check.static.static_check import CheckOutcome, Notes, check
from lockstep.errors import compact
from lockstep.fmi.platforms import PLATFORMS, library_folders

_SUFFIXES3 = {  # FMI 3.0 names the architecture first
    f"{architecture}-{system}": suffix
    for system, suffix in (("linux", ".so"), ("windows", ".dll"), ("darwin", ".dylib"))
    for architecture in ("x86_64", "x86", "aarch64")
}
SUFFIXES = {  # FMI 2.0 has names for x86; FMI 2.0.5 takes all others from FMI 3.0
    **{"linux64": ".so", "linux32": ".so", "win64": ".dll", "win32": ".dll", "darwin64": ".dylib"},
    **{platform: suffix for platform, suffix in _SUFFIXES3.items() if not platform.startswith("x86")},
}
EXTERNAL = ("documentation/externalDependencies.txt", "documentation/externalDependencies.html")
_ELF_PLATFORMS = {"1.0": "linux64", "2.0": "linux64", "3.0": "x86_64-linux"}  # of the library that is examined
# of a portable executable
_MACHINES = {
    "win64": 0x8664,
    "win32": 0x014C,
    "x86_64-windows": 0x8664,
    "x86-windows": 0x014C,
    "aarch64-windows": 0xAA64,
}
_BITS = {"linux64": 64, "linux32": 32, "x86_64-linux": 64, "x86-linux": 32, "aarch64-linux": 64}
_ELF_MACHINES = {"x86_64-linux": 62, "aarch64-linux": 183}  # of tuples; other names are used for several
_MACH_O = (b"\xcf\xfa\xed\xfe", b"\xca\xfe\xba\xbe")  # 64 bits, universal


def binary_name(fmu: FmuArchive, platform: str) -> str:
    """Return the path of the binary of a platform, or of where it should be."""
    identifier = fmu.model.identifier if fmu.model else ""
    return f"binaries/{platform}/{identifier}{_suffixes(fmu).get(platform, '.so')}"


def _version(fmu: FmuArchive) -> str:
    return fmu.model.version if fmu.model and fmu.model.version in _ELF_PLATFORMS else "2.0"


def _suffixes(fmu: FmuArchive) -> dict[str, str]:
    """Return the platforms of the FMU's version of FMI, with the suffixes of their libraries."""
    return _SUFFIXES3 if _version(fmu) == "3.0" else SUFFIXES


def _elf_platform(fmu: FmuArchive) -> str:
    return _ELF_PLATFORMS[_version(fmu)]


def _nothing_to_load(fmu: FmuArchive) -> str:
    """Return why there is no binary to look for; empty if there is one."""
    reason = unreadable(fmu)
    if not reason and fmu.model is not None and not fmu.model.identifier:
        reason = "no modelIdentifier of a co-simulation FMU, which names the binary"
    return reason


@check("platforms", "there is a binary for this platform, and each is of its folder's platform")
def platforms(fmu: FmuArchive) -> CheckOutcome:
    """List the binaries and look at their first bytes."""
    reason = _nothing_to_load(fmu)
    if reason:
        return CheckOutcome(status="skipped", message=reason)
    notes = Notes()
    folders = sorted({PurePosixPath(n).parts[1] for n in fmu.names if n.startswith("binaries/") and n.count("/") > 1})
    good = []
    here = next((name for name in library_folders(_version(fmu)) if name in folders), PLATFORMS[_version(fmu)])
    for platform in folders:
        if platform not in _suffixes(fmu):
            notes.info(f"binaries/{platform} is not a platform of FMI {_version(fmu)}")
            continue
        note = notes.error if platform == here else notes.warning  # a fault elsewhere stops nothing here
        name = binary_name(fmu, platform)
        if name not in fmu.names:
            note(f"binaries/{platform} lacks {PurePosixPath(name).name}, the file that modelIdentifier names")
            continue
        problem = _foreign(fmu.read(name), platform)
        if problem:
            note(f"{name} is {problem}")
        else:
            good.append(platform)
    sources = any(n.startswith("sources/") for n in fmu.names)
    if here not in folders:
        there = ", ".join(folders) or ("source code only, to be compiled" if sources else "none")
        notes.error(f"no binary for {here}, on which this check runs; there is {there}")
    return notes.outcome(", ".join(good) + (", sources" if sources else ""))


def _foreign(content: bytes, platform: str) -> str:
    """Describe a binary that is not of its platform; empty if it is."""
    if platform in _MACHINES:
        if content[:2] != b"MZ" or len(content) < 0x40:
            return "no Windows library"
        (header,) = struct.unpack_from("<I", content, 0x3C)
        if content[header : header + 4] != b"PE\0\0" or len(content) < header + 6:
            return "no Windows library"
        (machine,) = struct.unpack_from("<H", content, header + 4)
        return "" if machine == _MACHINES[platform] else f"a Windows library for machine 0x{machine:04x}"
    if "darwin" in platform:
        return "" if content[:4] in _MACH_O else "no macOS library"
    if content[:4] != b"\x7fELF":
        return "no ELF file"
    bits = {1: 32, 2: 64}.get(content[4] if len(content) > 4 else 0, 0)
    if bits != _BITS[platform]:
        return f"an ELF file of {bits} bits"
    (machine,) = struct.unpack_from("<H", content.ljust(20, b"\0"), 18)
    return "" if machine == _ELF_MACHINES.get(platform, machine) else f"an ELF file for machine {machine}"


def _library(fmu: FmuArchive) -> Library | CheckOutcome:
    """Read the Linux library, or return why that is not possible."""
    reason = _nothing_to_load(fmu)
    if not reason and binary_name(fmu, _elf_platform(fmu)) not in fmu.names:
        reason = f"no {_elf_platform(fmu)} binary to examine"
    if reason:
        return CheckOutcome(status="skipped", message=reason)
    library = read_library(fmu.read(binary_name(fmu, _elf_platform(fmu))))
    if (library.machine, library.bits) != (MACHINE, BITS) or not library.shared:
        kind = "shared library" if library.shared else "file that is no shared library"
        return CheckOutcome(status="error", message=f"a {library.bits} bit {kind} for {library.machine}, not x86-64")
    return library


@check("functions", "all functions of co-simulation are exported, also those of the capability flags")
def functions(fmu: FmuArchive) -> CheckOutcome:
    """Compare the exported symbols with the standard and the flags."""
    library = _library(fmu)
    if isinstance(library, CheckOutcome):
        return library
    assert fmu.model is not None
    model, notes = fmu.model, Notes()
    reported: set[str] = set()
    required, promised = functions_of(model.version, model.identifier), functions_of_flags(model.version)
    for flag, names in promised.items():
        missing = [name for name in names if name not in library.exported]
        if model.can(flag) and missing:
            notes.error(f"{flag} is true, but {', '.join(missing)} {'is' if len(missing) == 1 else 'are'} not exported")
            reported |= set(missing)
    if model.can("canSerializeFMUstate") and not model.can("canGetAndSetFMUstate"):
        notes.error("canSerializeFMUstate is true without canGetAndSetFMUstate")
    missing = [name for name in required if name not in library.exported and name not in reported]
    if missing:
        notes.error(
            f"not exported: {', '.join(missing)}; FMI requires every function, also those of unused capabilities"
        )
    flags = [flag for flag in promised if model.can(flag)]
    return notes.outcome(f"{len(required)} functions; {', '.join(flags) or 'no optional capability'}")


@check("dependencies", "the Linux binary finds what it needs, and external requirements are documented")
def dependencies(fmu: FmuArchive) -> CheckOutcome:
    """Look at needed libraries, search paths, and symbols that nothing needed offers."""
    library = _library(fmu)
    if isinstance(library, CheckOutcome):
        return library
    notes = Notes()
    for path in library.paths:
        if not path.startswith(("$ORIGIN", "${ORIGIN}")):
            notes.warning(f"searches libraries in {path}, a folder of the machine that built it")
    offered, lost = _offered(fmu, library)
    for name in lost:
        notes.warning(f"needs {name}, which is neither in the FMU nor on this machine")
    open_ = sorted(library.undefined - offered)
    python = _of_python(open_)
    other = [name for name in open_ if name not in python]
    text = _external_text(fmu)
    if python:
        _needs_python(fmu, "it", len(python), text, notes)
    for name, inner in _inner_fmus(fmu):
        if symbols := _of_python(inner.undefined):
            same_folder = name.startswith(f"binaries/{_elf_platform(fmu)}/")
            who = f"{PurePosixPath(name).name} in the same folder" if same_folder else f"the FMU inside, {name},"
            _needs_python(fmu, who, len(symbols), text, notes)
    if other and not lost:  # a library that is not there may offer them
        notes.error(f"symbols that no needed library exports: {compact(other, 6)}")
    assert fmu.model is not None
    if fmu.model.can("needsExecutionTool") and not text and not python:
        notes.warning(f"needsExecutionTool is true, but no {EXTERNAL[0]} names the tool")
    versions = [f"{name} {value}" for name, value in library.versions.items() if name in ("GLIBC", "GLIBCXX")]
    needs = ", ".join([*library.needed, *(f"at least {version}" for version in versions)])
    return notes.outcome(f"needs {needs or 'nothing'}")


def _offered(fmu: FmuArchive, library: Library) -> tuple[set[str], list[str]]:
    """Return the symbols that the needed libraries offer, and those libraries that were not found."""
    offered: set[str] = set()
    lost = []
    inside = {
        PurePosixPath(n).name: n for n in fmu.names if n.startswith((f"binaries/{_elf_platform(fmu)}/", "resources/"))
    }
    for name in library.needed:
        path = find_library(name)
        if name in inside:
            offered |= _exported_from(fmu, inside[name])
        elif path is not None:
            offered |= exported_with_dependencies(path)
        else:
            lost.append(name)
    return offered, lost


def _exported_from(fmu: FmuArchive, name: str) -> frozenset[str]:
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder) / PurePosixPath(name).name
        copy.write_bytes(fmu.read(name))
        return exported_with_dependencies(copy)


def _external_text(fmu: FmuArchive) -> str:
    there = [name for name in EXTERNAL if name in fmu.names]
    return fmu.read(there[0]).decode("utf-8", "replace") if there else ""


def _of_python(symbols: Iterable[str]) -> list[str]:
    return [name for name in symbols if re.match(r"_?Py", name)]


def _inner_fmus(fmu: FmuArchive) -> Iterator[tuple[str, Library]]:
    """Yield the other libraries that travel in this FMU and offer FMI: a wrapper's, or an FMU's as in a container."""
    for name in sorted(fmu.names - {binary_name(fmu, _elf_platform(fmu))}):
        if name.endswith(".so"):
            with suppress(ValueError):  # a library of another platform, or damaged: only the main one is checked
                library = read_library(fmu.read(name))
                if library.exported & {"fmi2DoStep", "fmi3DoStep"}:
                    yield name, library


def _needs_python(fmu: FmuArchive, who: str, count: int, text: str, notes: Notes) -> None:
    """Report that the host must have loaded libpython, and whether the FMU documents it."""
    assert fmu.model is not None
    what = f"{who} needs libpython in the host ({count} symbols of Python that no needed library exports)"
    faults = []
    if not re.search("python", text, re.I):
        faults.append(f"{EXTERNAL[0]} does not say so")
    if faults and not fmu.model.can("needsExecutionTool"):  # FMI means it for an FMU without the model itself
        faults.append("needsExecutionTool is not true")
    if faults:
        notes.warning(f"{what}; {' and '.join(faults)}")
    else:
        notes.info(f"{what}; {EXTERNAL[0]} says so")


@check("instances", "how many instances a process may hold")
def instances(fmu: FmuArchive) -> CheckOutcome:
    """Note the flags that limit how a master may use the FMU."""
    reason = _nothing_to_load(fmu)
    if reason or fmu.model is None:
        return CheckOutcome(status="skipped", message=reason)
    notes = Notes()
    if fmu.model.can("canBeInstantiatedOnlyOncePerProcess"):
        notes.info("only one instance per process: several instances need a process each")
    return notes.outcome("any number in one process")
