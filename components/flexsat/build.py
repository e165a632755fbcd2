"""Build the FMUs of one configuration: design once corrected, once as published, and pack what each component needs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from .archive import npz_bytes
from .design import Design, as_arrays, build_design
from .export import BuiltFmu, build_fmu
from .parameters import ConfigurationName, configuration
from .shells.matrices import AS_PUBLISHED, CORRECTED, MODEL_FILE

SHELLS = {
    "plant": "flexsat.shells.plant:Plant",
    "sensors": "flexsat.shells.sensors:Sensors",
    "controller": "flexsat.shells.controller:Controller",
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Designs:
    """Both variants of one configuration's design."""

    corrected: Design
    as_published: Design


def build_designs(name: ConfigurationName) -> Designs:
    """Run the design chain twice; raise ValueError for an unknown configuration."""
    config = configuration(name)
    return Designs(corrected=build_design(config), as_published=build_design(config, as_published=True))


def component_resources(designs: Designs, component: str) -> dict[str, bytes]:
    """Return the files that travel with a component: one `.npz` with both variants of its matrices."""
    arrays = as_arrays(getattr(designs.corrected, component), CORRECTED)
    arrays |= as_arrays(getattr(designs.as_published, component), AS_PUBLISHED)
    return {MODEL_FILE: npz_bytes(arrays)}


def build_configuration(
    designs: Designs, folder: Path, report: Callable[[str], None] = lambda _: None
) -> dict[str, BuiltFmu]:
    """Build plant, sensors and controller into `folder`/<configuration>/, each replaced in one piece.

    Parameters
    ----------
    designs : of one configuration
    folder : usually `fmus`
    report : called with a line for each file written
    """
    name = designs.corrected.config.name
    built = {}
    for component, shell in SHELLS.items():
        path = folder / name / f"{component}.fmu"
        path.parent.mkdir(parents=True, exist_ok=True)
        resources = component_resources(designs, component)
        built[component] = build_fmu(shell, path, resources, f"{component}_{name}")
        report(f"{path}  {path.stat().st_size / 1e6:.1f} MB  {built[component].guid}")
    return built
