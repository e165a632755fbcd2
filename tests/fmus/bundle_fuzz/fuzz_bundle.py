"""Build the program of fuzz.c with the sources of a bundle's library, and run it with the sanitizers of gcc."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

from fmus.bundle_host import MS, bundled
from fmus.c_fmu import HEADERS, quoted
from lockstep import Component, System
from lockstep.bundle.compile import sources
from lockstep.bundle.ports import Choice

# all but fatal_at: an FMU that failed fatally must not be called, so that its memory stays
CHOICE = Choice(
    outputs=("all",), parameters=tuple(f"*.{n}" for n in ("gain", "trim", "label", "fail_at", "end_at", "nan_at"))
)
SANITIZERS = "-fsanitize=address,undefined,float-cast-overflow"
OPTIONS = ("-std=c99", "-O0", "-fno-sanitize-recover=all", "-DTICK_EXPORT=", "-DTICK_ONE_THREAD")


def as_fmi3(system: System, folder: Path) -> System:
    """Return a system of one component: another system as an FMU of FMI 3.0, with the same choice of ports."""
    path = bundled(system, folder / "inside.fmu", CHOICE, version="3.0")
    return System(name="outer", tick=MS, components=(Component(name="in", source=path, period=MS, isolated=False),))


def build_fuzzer(folder: Path, version: str = "2.0") -> Path:
    """Compile in a folder for a version of FMI, and return the program."""
    folder.mkdir(parents=True, exist_ok=True)
    files = sources(version)
    for name, content in files.items():
        (folder / name).write_bytes(content)
    units = sorted(name for name in files if name.endswith(".c"))
    main = Path(__file__).with_name("fuzz.c")
    calls = quoted("CALLS", str(main.with_name(f"calls{version[0]}.h")))
    command = ["gcc", *OPTIONS, SANITIZERS, f"-D{calls}", f"-I{HEADERS}", "-o", "fuzz", main, *units, "-ldl"]
    subprocess.run(command, cwd=folder, check=True)
    return folder / "fuzz"


def run_fuzzer(program: Path, resources: Path, guid: str, sequences: int, seed: int = 1, version: str = "2.0") -> str:
    """Run sequences on a bundle whose resources are unpacked; return what it prints, or raise AssertionError."""
    place = resources.as_uri() if version == "2.0" else f"{resources}/"
    arguments = [program, place, guid, str(sequences), str(seed)]
    environment = os.environ | {"ASAN_OPTIONS": "detect_leaks=1:handle_abort=1"}
    done = subprocess.run(arguments, capture_output=True, text=True, check=False, env=environment)
    assert done.returncode == 0, done.stderr[-6000:]
    return done.stdout
