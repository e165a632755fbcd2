"""Make the FMI 3.0 variant of a delivered native FMU: its sources and matrices behind the other layer."""

import shutil
import subprocess
import zipfile
from dataclasses import replace
from pathlib import Path

from flexsat.fmu.build import SHELLS
from flexsat.fmu.documentation.xml_text import xml_bytes
from flexsat.fmu.native.fmi3_description import fmi3_model_description
from flexsat.fmu.native.port_source import differentiable
from flexsat.fmu.native.sources import c_files, component_sources
from flexsat.fmu.python.model_description import about_component
from flexsat.fmu.reproducible_zip import zip_bytes
from fmus.native.twin import OPTIONS


def fmi3_variant(native: Path, out: Path) -> Path:
    """Write the FMU of a component, and return its path; its token is the GUID of the given one."""
    component = native.stem
    work = out.with_suffix("")
    with zipfile.ZipFile(native) as archive:
        archive.extractall(work)
    sources = work / "sources"
    for path in sources.glob("fmi2*"):
        path.unlink()
    for name, content in component_sources(c_files()[f"{component}.c"], "3.0").items():
        if name.startswith("fmi3"):
            (sources / name).write_bytes(content)
    compiler = shutil.which("cc")
    assert compiler is not None
    # without optimisation, which is quicker to compile and gives the same bits
    command = [compiler, *OPTIONS, "-O0", "-fPIC", "-shared", "-fvisibility=hidden", "-o", str(work / "library.so")]
    done = subprocess.run([*command, *map(str, sources.glob("*.c")), "-lm"], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    shell = SHELLS[component](instance_name=component, resources=str(work / "resources"))
    guid = (sources / "identity.c").read_text(encoding="utf-8").partition('"{')[2].partition('}"')[0]
    about = about_component(shell, {"version": "1"}, "flexsat tests")
    about = replace(about, model_name=component, guid=f"{{{guid}}}", derivatives=differentiable(shell.table))
    entries = {
        "modelDescription.xml": xml_bytes(fmi3_model_description(shell.table, about)),
        f"binaries/x86_64-linux/{component}.so": (work / "library.so").read_bytes(),
        "resources/build.json": (work / "resources" / "build.json").read_bytes(),
    }
    out.write_bytes(zip_bytes(entries, compress=False))
    return out
