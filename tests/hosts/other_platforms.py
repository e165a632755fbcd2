"""Build the native FMUs and the host in C for Windows and for Linux on ARM, and run them under Wine and QEMU.

Both emulate what the libraries need of their systems: Wine has its own C library of Windows, QEMU runs ARM's.
"""

from __future__ import annotations

import importlib.util
import shutil
import subprocess
import tempfile
import zipfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

import fmpy
from hosting import HERE

from flexsat.fmu.native.compile import binaries
from flexsat.fmu.native.compilers import compiler_for
from flexsat.fmu.native.platforms import PLATFORMS

ARM_LIBRARIES = Path("/usr/aarch64-linux-gnu")
_WINE = next((path for path in (shutil.which("wine64"), "/usr/lib/wine/wine64") if path and Path(path).exists()), "")
_WINDOWS = Path("/usr/lib/x86_64-linux-gnu/wine/x86_64-windows")  # the libraries of Wine


@dataclass(frozen=True, slots=True, kw_only=True)
class Emulator:
    """How programs for another platform are run here, and how they name a file."""

    command: tuple[str, ...]
    environment: Mapping[str, str] = field(default_factory=dict)
    root: str = ""


def lacks(platform: str) -> str:
    """Return what running programs for a platform lacks here, or nothing."""
    if importlib.util.find_spec("ziglang") is None:
        return "libraries of other platforms are compiled with Zig: pip install ziglang"
    if platform == "win64" and not (_WINE and _WINDOWS.is_dir()):
        return "libraries for Windows run under Wine: apt-get install wine64"
    if platform == "aarch64-linux" and not (shutil.which("qemu-aarch64") and ARM_LIBRARIES.is_dir()):
        return "libraries for ARM run under QEMU: apt-get install qemu-user libc6-arm64-cross"
    return ""


@contextmanager
def emulator(platform: str, folder: Path) -> Iterator[Emulator]:
    """Prepare for running programs of a platform; what Wine keeps is in `folder`."""
    if platform == "aarch64-linux":
        yield Emulator(command=("qemu-aarch64", "-L", str(ARM_LIBRARIES)))
        return
    (folder / "dosdevices").mkdir(parents=True)
    (folder / "drive_c" / "windows").mkdir(parents=True)
    (folder / "dosdevices" / "c:").symlink_to("../drive_c")
    (folder / "dosdevices" / "z:").symlink_to("/")
    (folder / "drive_c" / "windows" / "system32").symlink_to(_WINDOWS)
    (folder / ".update-timestamp").write_text("disable\n")  # else Wine spends half a minute on copies of its libraries
    environment = {"WINEPREFIX": str(folder), "WINEDEBUG": "-all", "HOME": str(folder), "TMPDIR": str(folder),
                   "PATH": "/usr/bin:/bin", "WINEDLLOVERRIDES": "mscoree,mshtml,winemenubuilder.exe="}  # fmt: skip
    try:
        yield Emulator(command=(_WINE,), environment=environment, root="Z:")
    finally:
        server = shutil.which("wineserver") or str(Path(_WINE).with_name("wineserver"))
        subprocess.run([server, "-k"], env=environment, check=False)  # that of this folder


def build_host(platform: str, path: Path) -> None:
    """Compile the host for a platform, without the static parts of C libraries, as the FMUs."""
    (target,) = PLATFORMS[platform].targets
    compiler = compiler_for(target)
    units = [HERE / "c" / "host.c"]
    options = ["-ldl"]
    if compiler.runtime is not None:
        units += [HERE / "c" / "windows_program.c", compiler.runtime]
        options = ["-lkernel32", "-Wl,--subsystem,console", "-Wl,--entry,mainCRTStartup"]
    headers = Path(fmpy.__file__).parent / "c-code"
    with tempfile.TemporaryDirectory() as folder:
        environment = dict(compiler.environment or ()) | {"ZIG_LOCAL_CACHE_DIR": folder}
        objects = [Path(folder, f"{unit.stem}.o") for unit in units]
        commands = [
            [*compiler.command, "-std=c11", "-O1", "-Wall", "-Wextra", "-Werror", "-I", headers, "-c", unit, "-o", made]
            for unit, made in zip(units, objects, strict=True)
        ]
        commands.append([*compiler.command, "-nostdlib", *objects, "-o", path, *compiler.libraries, *options])
        for command in commands:
            done = subprocess.run(command, capture_output=True, text=True, check=False, env=environment)
            assert done.returncode == 0, done.stderr


def build_libraries(fmu: Path, platforms: tuple[str, ...], folder: Path) -> None:
    """Compile the sources that travel in an FMU for some platforms, into a folder of its own in `folder`."""
    with zipfile.ZipFile(fmu) as archive:
        names = [name for name in archive.namelist() if name.startswith("sources/") and name.endswith((".c", ".h"))]
        sources = {name.removeprefix("sources/"): archive.read(name) for name in names}
    for name, library in binaries(sources, fmu.stem, platforms).items():
        path = folder / fmu.stem / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(library)
