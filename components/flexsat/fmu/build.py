"""Build the FMUs of one configuration: design once corrected, once as published, and pack what each component needs."""

from __future__ import annotations

import importlib.metadata
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from ..arrays import Array, Index
from ..description.configuration import Configuration
from ..design.chain import Designs, as_arrays, cost_arrays
from ..ports.table import FmiVersion, Naming, PortTable
from ..runtime.slew_guidance import shaper_for_pole
from ..variants import PUBLISHED, Variant
from .documentation.content import AccompanyingFiles, accompanying_files, draw
from .documentation.device_rows import DeviceRows, device_rows
from .documentation.experiments import experiments_of
from .documentation.native_notes import NativeNotes
from .documentation.reference_results import Run, run_experiments
from .export import BuiltFmu, build_fmu
from .python.controller import Controller
from .python.load_matrices import COST, MODEL_FILE
from .python.plant import Plant
from .python.sensors import Sensors
from .reproducible_zip import npz_bytes

SHELLS: dict[str, type[Plant | Sensors | Controller]] = {
    "plant": Plant,
    "sensors": Sensors,
    "controller": Controller,
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Parts:
    """What the FMUs of one component have in common, whatever their names and whatever runs them.

    Attributes
    ----------
    resources : files that the Python FMU reads
    table : the ports, with structured names
    runs : experiments with their results
    """

    component: str
    config: Configuration
    resources: Mapping[str, bytes]
    table: PortTable
    runs: list[Run]
    pictures: Mapping[str, bytes]
    devices: DeviceRows

    def accompanying_files(
        self,
        model_name: str,
        naming: Naming,
        *,
        execution_tool: bool = False,
        native: NativeNotes | None = None,
        fmi: FmiVersion = "2.0",
    ) -> AccompanyingFiles:
        """Return the documentation, pictures and reference results of an FMU of this component."""
        return accompanying_files(
            self.component,
            self.table.renamed(naming),
            self.runs,
            self.pictures,
            config=self.config,
            devices=self.devices,
            model_name=model_name,
            version=importlib.metadata.version("flexsat"),
            step=getattr(self.config.rates, self.component),
            stop=SHELLS[self.component].stop_time,
            execution_tool=execution_tool,
            native=native,
            fmi=fmi,
        )


def configuration_parts(designs: Designs) -> dict[str, Parts]:
    """Return the parts of plant, sensors and controller of one configuration; the experiments are run."""
    config, law = designs.corrected.config, designs.corrected.controller
    spacing = float(shaper_for_pole(law.shaper_frequency, law.shaper_damping, law.period).shifts[0])
    parts, devices = {}, device_rows(designs.corrected)
    for component, shell in SHELLS.items():
        resources = component_resources(designs, component)
        step = getattr(config.rates, component)
        experiments = experiments_of(component, step, spacing)
        table, runs = run_experiments(shell, resources, experiments)
        pictures = draw(designs.corrected.spacecraft, config, component)
        parts[component] = Parts(
            component=component,
            config=config,
            resources=resources,
            table=table,
            runs=runs,
            pictures=pictures,
            devices=devices,
        )
    return parts


def component_resources(designs: Designs, component: str) -> dict[str, bytes]:
    """Return the files that travel with a component: one `.npz` with all variants of its matrices."""
    arrays: dict[str, Array | Index] = {}
    for variant in variants_of(designs, component):
        design = designs.variant(variant)
        arrays |= as_arrays(getattr(design, component), variant.name)
        if component == "controller":
            arrays |= {f"{variant.name}.{COST}.{name}": values for name, values in cost_arrays(design).items()}
    return {MODEL_FILE: npz_bytes(arrays)}


def variants_of(designs: Designs, component: str) -> list[Variant]:
    """Return the variants that a component has matrices of: the weights that differ are those of the controller."""
    return [variant for variant in designs.variants if component == "controller" or variant != PUBLISHED]


def build_configuration(
    designs: Designs,
    folder: Path,
    report: Callable[[str], None] = lambda _: None,
    naming: Naming = "structured",
    execution_tool: bool = False,
    parts: Mapping[str, Parts] | None = None,
) -> dict[str, BuiltFmu]:
    """Build plant, sensors and controller into `folder`/<configuration>/, each replaced in one piece.

    Parameters
    ----------
    designs : of one configuration
    folder : usually `fmus`
    report : called with a line for each file written
    naming : "flat" builds the same FMUs with flat names into `folder`/<configuration>/flat/
    execution_tool : declare that the FMUs need a tool to be executed
    parts : from `configuration_parts`, if they have been made already
    """
    config = designs.corrected.config
    flat = naming == "flat"
    target = folder / config.name / "flat" if flat else folder / config.name
    built = {}
    for component, part in (parts or configuration_parts(designs)).items():
        shell = SHELLS[component]
        path = target / f"{component}.fmu"
        path.parent.mkdir(parents=True, exist_ok=True)
        model_name = f"{component}_{config.name}{'_flat' if flat else ''}"
        content = part.accompanying_files(model_name, naming, execution_tool=execution_tool)
        built[component] = build_fmu(
            f"{shell.__module__}:{shell.__name__}",
            path,
            part.resources,
            model_name,
            documentation=content.documentation,
            extra=content.extra,
            naming=naming,
            execution_tool=execution_tool,
        )
        report(f"{path}  {path.stat().st_size / 1e6:.1f} MB  {built[component].guid}")
    return built
