"""Make FMUs with one defect: a C source with one DEFECT_... defined, or a model description with one edit."""

from __future__ import annotations

import re
import zipfile
from pathlib import Path

from fmus.c_fmu import compile_library, pack_fmu, quoted

HERE = Path(__file__).parent
XML = (HERE / "bad.xml").read_text(encoding="utf-8")
GUID = re.search(r'guid="([^"]+)"', XML)[1]
SOURCES = "".join((HERE / name).read_text(encoding="utf-8") for name in ("bad.c", "processes.h"))
DEFECTS = set(re.findall(r"DEFECT_(\w+)", SOURCES)) - {""}


def bad_fmu(folder: Path, *defects: str, xml: str = XML) -> Path:
    """Compile and zip the FMU with defects of the source, or without any; return its path."""
    assert DEFECTS.issuperset(defects), f"{defects}: the source knows {sorted(DEFECTS)}"
    library = folder / "bad.so"
    compile_library(library, [HERE / "bad.c"], defines=[quoted("GUID", GUID), *(f"DEFECT_{name}" for name in defects)])
    files = {
        "resources/gain.txt": "3.0\n",
        "documentation/index.html": "<!DOCTYPE html><title>bad</title><p>A test.</p>\n",
        "documentation/licenses/license.txt": "BSD-3-Clause\n",
    }
    return pack_fmu(folder / "bad.fmu", xml, library, files=files)


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
