"""Build FMUs, system files, packages with their metadata, manifest and interface document: `flexsat build`."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from flexsat.description.built_in import CONFIGURATIONS
from flexsat.description.spacecraft_file import SpacecraftFile
from flexsat.design.chain import Designs, build_designs
from flexsat.errors import BuildError
from flexsat.fmu.build import Parts, build_configuration, configuration_parts
from flexsat.fmu.build_missions import FOLDER as MISSIONS
from flexsat.fmu.build_native import build_native_configuration
from flexsat.fmu.export import BuiltFmu
from flexsat.fmu.native.compilers import check_compilers
from flexsat.fmu.native.kept_objects import check_folder
from flexsat.fmu.native.sources import IN_C, native_folder
from flexsat.fmu.reproducible_zip import zip_bytes
from flexsat.parameters import ConfigurationName
from lockstep.errors import InputError
from lockstep.plan.timeline_svg import timeline_svg
from lockstep.ssp.package_members import package_entries
from lockstep.ssp.traceability import srmd_bytes
from lockstep.whole_file import write_whole

from ..html.document import as_markdown
from ..html.render import as_html
from ..icd.contents import TIMELINE_FILE, TIMELINE_TICKS, icd_blocks
from .build_manifest import EARLIER, MANIFEST, describe_configuration, versions, write_manifest
from .build_options import STANDARD, BuildOptions
from .fmu_choice import PrintLine
from .properties import bias_line
from .scenarios import SCENARIOS, ScenarioName, scalar_overrides, scenario_parameters
from .spacecraft import FILE, design_file, read_file
from .systems import WIRES, build_system, write_closed_systems, write_systems

Notes = Callable[[Designs], Iterable[str]]


def build_all(
    names: Sequence[ConfigurationName],
    folder: Path,
    print_line: PrintLine = print,
    options: BuildOptions = STANDARD,
    *,
    without_native: PrintLine | None = None,
) -> None:
    """Build the FMUs of some configurations and all files that go with them. The same input gives the same bytes.

    Parameters
    ----------
    names : configurations to build
    folder : to write to
    print_line : called with the path of each file written
    options : which FMUs
    without_native : called with the reason if the FMUs in C cannot be built; they are left out then. None: an error

    Raises
    ------
    InputError
        If this machine lacks a compiler, or what else a build needs.
    """
    try:
        check_compilers(options.platforms)
        if options.in_c:
            check_folder()
        designs = {name: build_designs(name) for name in CONFIGURATIONS}  # the interface document covers both
        chosen = {name: designs[name] for name in names}
        identities = _build_each(chosen, folder, print_line, options, without_native)
        known = [identity for name in CONFIGURATIONS for identity in identities.get(name, [])]
        for path in write_icd(designs, folder, known):
            print_line(str(path))
    except BuildError as error:
        raise InputError(str(error)) from None


def build_files(
    files: Sequence[Path | SpacecraftFile],
    folder: Path,
    print_line: PrintLine = print,
    options: BuildOptions = STANDARD,
    *,
    notes: Notes | None = None,
) -> None:
    """Build the FMUs of the spacecraft that files describe, each into `folder`/<name>, with its interface document.

    Parameters are those of `build_all`. Each file is copied there too: results are evaluated with it. A spacecraft that
    was made in Python comes as what `flexsat.description.file_text.file_of` returns. `notes` gives lines about its
    designs, which are printed first.

    Raises
    ------
    InputError
        If a file is refused, there is no design for it, or this machine lacks what a build needs.
    """
    try:
        read = [(Path(f"{one.name}.toml"), one) if isinstance(one, SpacecraftFile) else (one, read_file(one))
                for one in files]  # fmt: skip
        check_compilers(options.platforms)
        if options.in_c:
            check_folder()
        for path, spacecraft in read:
            _build_file(spacecraft, path, folder, print_line, options, notes)
    except BuildError as error:
        raise InputError(str(error)) from None


def _build_file(
    spacecraft: SpacecraftFile,
    path: Path,
    folder: Path,
    print_line: PrintLine,
    options: BuildOptions,
    notes: Notes | None,
) -> None:
    designs = {spacecraft.name: design_file(spacecraft, path)}
    design = designs[spacecraft.name].corrected
    if (line := bias_line(design.structure, design.response.nominal)) is not None:
        print_line(f"{path.name}: note: {line}")
    for line in notes(designs[spacecraft.name]) if notes is not None else ():
        print_line(f"{path.name}: {line}")
    identities = _build_each(designs, folder, print_line, options)
    copy = folder / spacecraft.name / FILE
    write_whole(copy, spacecraft.text.encode())
    written = write_icd(designs, folder / spacecraft.name, identities[spacecraft.name])
    data = [folder / spacecraft.name / name for name in spacecraft.files]
    for target, content in zip(data, spacecraft.files.values(), strict=True):
        write_whole(target, content)
    for one in (copy, *data, *written):
        print_line(str(one))


def _build_each(
    designs: Mapping[ConfigurationName, Designs],
    folder: Path,
    print_line: PrintLine,
    options: BuildOptions,
    without_native: PrintLine | None = None,
) -> dict[ConfigurationName, list[tuple[str, str, str]]]:
    """Build spacecraft and write the manifest; return file, GUID and SHA-256 of each FMU that it lists, by name."""
    entries = {}
    for name, both in designs.items():
        parts = configuration_parts(both)
        tool = options.execution_tool
        built = build_configuration(both, folder, print_line, "structured", tool, parts)
        flat_named = build_configuration(both, folder, print_line, "flat", tool, parts) if options.flat else {}
        paths = write_systems(both, folder / name)
        packages = write_packages(both, paths, built)
        closed = write_closed_systems(both, folder / name)
        packages += [*closed, *write_packages(both, closed, built)]
        if options.flat:
            flat_paths = write_systems(both, folder / name / "flat", "flat")
            packages += [*flat_paths, *write_packages(both, flat_paths, flat_named)]
        fmus = built | {f"{component}, flat names": fmu for component, fmu in flat_named.items()}
        try:
            more_fmus, files = _build_in_c(both, folder, parts, print_line, options)
            fmus, packages = fmus | more_fmus, packages + files
        except BuildError as error:
            if without_native is None:
                raise BuildError(f"{error}; --no-native leaves out the FMUs in C") from None
            without_native(str(error))
            options = replace(options, in_c=())
        for path in (*paths, *packages):
            print_line(str(path))
        entries[name] = describe_configuration(both.corrected.config, fmus, [*paths, *packages], folder)
    manifest = write_manifest(folder, entries)
    print_line(str(folder / MANIFEST))
    return {
        name: [
            (file, fmu["guid"], fmu["sha256"])
            for file, fmu in entry["fmus"].items()
            if not fmu.get(EARLIER) and file.split("/")[1] != MISSIONS  # these have a document of their own
        ]
        for name, entry in manifest["configurations"].items()
    }


def _build_in_c(
    designs: Designs, folder: Path, parts: Mapping[str, Parts], print_line: PrintLine, wanted: BuildOptions
) -> tuple[dict[str, BuiltFmu], list[Path]]:
    """Build the FMUs in C; return them, and the systems and packages of them."""
    layout = folder / designs.corrected.config.name
    fmus: dict[str, BuiltFmu] = {}
    files: list[Path] = []
    for fmi in wanted.in_c:
        built = build_native_configuration(designs, folder, parts, print_line, fmi, wanted.platforms)
        fmus |= {f"{component}, {IN_C[fmi]}": fmu for component, fmu in built.items()}
        systems = write_systems(designs, native_folder(layout, fmi))
        files += systems
        if fmi == "2.0":  # other tools that load packages know FMI 2.0
            closed = write_closed_systems(designs, native_folder(layout))
            files += [*write_packages(designs, systems, built), *closed, *write_packages(designs, closed, built)]
            if wanted.flat:
                built = build_native_configuration(
                    designs, folder, parts, print_line, fmi, wanted.platforms, naming="flat"
                )
                fmus |= {f"{component}, native, flat names": fmu for component, fmu in built.items()}
                files += write_systems(designs, native_folder(layout / "flat"), "flat")
    return fmus, files


def write_packages(designs: Designs, systems: Sequence[Path], built: Mapping[str, BuiltFmu]) -> list[Path]:
    """Write each system as an .ssp package, with its simulation resource metadata (.srmd); return all paths."""
    paths = []
    for scenario, path in zip(SCENARIOS, systems, strict=True):
        package, metadata = path.with_suffix(".ssp"), path.with_suffix(".srmd")
        content = zip_bytes(package_entries(path), compress=False)  # FMUs are compressed already
        write_whole(package, content)
        write_whole(metadata, _metadata(designs, scenario, package.name, content, built))
        paths += [package, metadata]
    return paths


def _metadata(
    designs: Designs, scenario: ScenarioName, package: str, content: bytes, built: Mapping[str, BuiltFmu]
) -> bytes:
    config = designs.corrected.config
    set_values = scalar_overrides(scenario_parameters(scenario, slew=config.slew))
    classifications: dict[str, Mapping[str, str]] = {
        "com.flexsat.versions": versions(),
        "com.flexsat.system": {"configuration": config.name, "scenario": scenario},
        "com.flexsat.fmu": {f"{name}.guid": fmu.guid for name, fmu in built.items()}
        | {f"{name}.sha256": fmu.sha256 for name, fmu in built.items()},
        "com.flexsat.parameters": {name: _text(value) for name, value in set_values.items()},
    }
    head = {
        "description": f"closed attitude control loop of the {config.name} configuration, {scenario.replace('_', ' ')}",
        "author": "flexsat developers",
        "license": "BSD-3-Clause",
        "generationTool": f"flexsat {versions()['flexsat']}",
    }
    return srmd_bytes(f"{config.name} {scenario.replace('_', ' ')}", package, content, classifications, head)


def _text(value: float | int | bool) -> str:
    return str(value).lower() if isinstance(value, bool) else repr(value)


def write_icd(
    designs: Mapping[ConfigurationName, Designs], folder: Path, identities: Sequence[tuple[str, str, str]]
) -> list[Path]:
    """Write the interface document of spacecraft as ICD.md with its drawing, and as ICD.html; return their paths."""
    name = list(designs)[-1]  # all have the same schedule
    system = build_system(designs[name], "fine_pointing", folder / name)
    blocks = icd_blocks(designs, WIRES, system, identities)
    files = {
        "ICD.md": as_markdown(blocks),
        TIMELINE_FILE: timeline_svg(system, TIMELINE_TICKS),
        "ICD.html": as_html(blocks),
    }
    for name, text in files.items():
        write_whole(folder / name, text.encode())
    return [folder / name for name in files]
