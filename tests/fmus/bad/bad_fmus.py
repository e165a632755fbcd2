"""Make FMUs with one defect: a C source with one DEFECT_... defined, or a model description with one edit."""

from __future__ import annotations

import re
import subprocess
import zipfile
from pathlib import Path

import fmpy

HERE = Path(__file__).parent
XML = (HERE / "bad.xml").read_text(encoding="utf-8")
GUID = re.search(r'guid="([^"]+)"', XML)[1]
HEADERS = Path(fmpy.__file__).parent / "c-code"
REST = HERE.parent / "rest" / "fmi2_rest.c"
FLAGS = ("-std=gnu11", "-Wall", "-Wextra", "-Werror", "-O1", "-shared", "-fPIC")
DEFECTS = set(re.findall(r"DEFECT_(\w+)", (HERE / "bad.c").read_text(encoding="utf-8"))) - {""}


def bad_fmu(folder: Path, *defects: str, xml: str = XML) -> Path:
    """Compile and zip the FMU with defects of the source, or without any; return its path."""
    assert DEFECTS.issuperset(defects), f"{defects}: the source knows {sorted(DEFECTS)}"
    folder.mkdir(parents=True, exist_ok=True)
    library = folder / "bad.so"
    options = [f"-DDEFECT_{defect}" for defect in defects]
    subprocess.run(
        ["gcc", *FLAGS, f'-DGUID="{GUID}"', *options, f"-I{HEADERS}", "-o", library, HERE / "bad.c", REST, "-lm"],
        check=True,
    )
    path = folder / "bad.fmu"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("modelDescription.xml", xml)
        archive.write(library, "binaries/linux64/bad.so")
        archive.writestr("resources/gain.txt", "3.0\n")
        archive.writestr("documentation/index.html", "<!DOCTYPE html><title>bad</title><p>A test.</p>\n")
        archive.writestr("documentation/licenses/license.txt", "BSD-3-Clause\n")
    return path


def forgetful_sensors(path: Path, good: Path) -> None:
    """Build our sensors with a generator left out of the state, from the resources of the good ones."""
    import flexsat
    from flexsat.fmu.export import build_fmu

    with zipfile.ZipFile(good) as archive:
        model = archive.read("resources/model.npz")
    flexsat.__path__.append(str(HERE))
    try:
        build_fmu("flexsat.forgetful.sensors:ForgetfulSensors", path, {"model.npz": model}, "forgetful_sensors")
    finally:
        flexsat.__path__.remove(str(HERE))
