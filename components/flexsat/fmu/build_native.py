"""Build the native FMUs of one configuration: the same ports, documentation and reference results, and a C library."""

from __future__ import annotations

import hashlib
import importlib.metadata
import tempfile
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path
from typing import Any

from ..design.chain import Designs
from ..ports.table import FmiVersion, Naming, PortTable
from .build import SHELLS, Parts, variants_of
from .documentation.content import AccompanyingFiles
from .export import BuiltFmu
from .native.compile import native_notes
from .native.export import NativeComponent, native_content
from .native.platforms import folders
from .native.sources import c_files, native_folder
from .python.life_cycle import ComponentSlave
from .python.model_description import about_component
from .reproducible_zip import write_atomically, zip_bytes


def build_native_configuration(
    designs: Designs,
    folder: Path,
    parts: Mapping[str, Parts],
    report: Callable[[str], None] = lambda _: None,
    fmi: FmiVersion = "2.0",
    platforms: Sequence[str] = (),
    naming: Naming = "structured",
) -> dict[str, BuiltFmu]:
    """Build plant, sensors and controller into `folder`/<configuration>/native/, each replaced in one piece.

    Parameters
    ----------
    designs : of one configuration
    folder : usually `fmus`
    parts : from `configuration_parts`
    report : called with a line for each file written
    fmi : version; those of FMI 3.0 stand in the folder fmi3/ of this folder
    platforms : that each has libraries for, which Zig compiles; none for Linux x86-64, with this machine's compiler
    naming : "flat" builds the same FMUs with flat names into `folder`/<configuration>/flat/native/

    Raises
    ------
    BuildError
        If there is no C compiler here, or no Zig for platforms, or this is another platform than Linux x86-64.
    """
    layout = folder / designs.corrected.config.name
    target = native_folder(layout / "flat" if naming == "flat" else layout, fmi)

    def build(component: str) -> BuiltFmu:
        return _build(designs, parts[component], target / f"{component}.fmu", fmi, platforms, naming)

    built = {}
    text = f"  {', '.join(folders(platforms, fmi))}" if platforms else ""
    with ThreadPoolExecutor(2) as pool:  # compilers are processes of their own
        for component, fmu in zip(SHELLS, pool.map(build, SHELLS), strict=True):
            built[component] = fmu
            report(f"{fmu.path}  {fmu.path.stat().st_size / 1e6:.1f} MB  {fmu.guid}{text}")
    return built


def _build(
    designs: Designs, parts: Parts, path: Path, fmi: FmiVersion, platforms: Sequence[str], naming: Naming
) -> BuiltFmu:
    component = native_component(designs, parts, naming)
    name = component.about.model_name
    files = parts.accompanying_files(name, naming, native=native_notes(name, platforms, fmi), fmi=fmi)
    return write_native_fmu(component, files, path, fmi, platforms)


def write_native_fmu(
    component: NativeComponent, files: AccompanyingFiles, path: Path, fmi: FmiVersion, platforms: Sequence[str]
) -> BuiltFmu:
    """Compile an FMU in C and write it with its documentation; replaced in one piece.

    Raises
    ------
    BuildError
        If there is no C compiler here, or no Zig for platforms.
    """
    made = native_content(component, fmi, platforms)
    documentation = {f"documentation/{file}": content for file, content in files.documentation.items()}
    archive = zip_bytes({**files.extra, **documentation, **made.entries})
    path.parent.mkdir(parents=True, exist_ok=True)
    write_atomically(path, archive)
    return BuiltFmu(path=path, guid=made.guid, sha256=hashlib.sha256(archive).hexdigest())


def native_component(designs: Designs, parts: Parts, naming: Naming = "structured") -> NativeComponent:
    """Return what the native FMU of a component is made from."""
    flat = "_flat" if naming == "flat" else ""
    return described_by(
        SHELLS[parts.component],
        parts.component,
        f"{parts.component}_{parts.config.name}{flat}",
        parts.table.renamed(naming),
        parts.resources,
        {
            variant.name: getattr(designs.variant(variant), parts.component)
            for variant in variants_of(designs, parts.component)
        },
    )


def described_by(
    shell: type[ComponentSlave],
    component: str,
    model_name: str,
    table: PortTable,
    resources: Mapping[str, bytes],
    variants: Mapping[str, Any],
) -> NativeComponent:
    """Return a component in C that is described as its shell in Python is.

    Parameters
    ----------
    shell : that reads the resources
    component : name; its main C file has it too
    table : ports
    variants : matrices by the name of the variant
    """
    with tempfile.TemporaryDirectory(prefix="flexsat_native_") as folder:
        for file, content in resources.items():
            Path(folder, file).write_bytes(content)
        started = shell(instance_name=component, resources=folder)
    version = importlib.metadata.version("flexsat")
    about = about_component(started, {"version": version}, f"flexsat {version}")
    return NativeComponent(
        main=c_files()[f"{component}.c"],
        table=table,
        variants=variants,
        about=replace(about, model_name=model_name),
        equal_steps=started.equal_steps,
        step_parameter=started.step_parameter,
        resources=resources,
    )
