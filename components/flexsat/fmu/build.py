"""Build the FMUs of one configuration: design once corrected, once as published, and pack what each component needs."""

from __future__ import annotations

import importlib.metadata
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from ..arrays import Array, Index
from ..controller_weights import VARIANTS
from ..design.chain import Designs, as_arrays, cost_arrays
from ..ports.table import Naming
from .documentation.content import accompanying_files, draw
from .documentation.experiments import EXPERIMENTS
from .documentation.reference_results import run_experiments
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


def component_resources(designs: Designs, component: str) -> dict[str, bytes]:
    """Return the files that travel with a component: one `.npz` with all variants of its matrices."""
    arrays: dict[str, Array | Index] = {}
    for variant in VARIANTS:
        design = getattr(designs, variant)
        if component == "controller" or variant != "published":
            arrays |= as_arrays(getattr(design, component), variant)
        if component == "controller":
            arrays |= {f"{variant}.{COST}.{name}": values for name, values in cost_arrays(design).items()}
    return {MODEL_FILE: npz_bytes(arrays)}


def build_configuration(
    designs: Designs,
    folder: Path,
    report: Callable[[str], None] = lambda _: None,
    naming: Naming = "structured",
    execution_tool: bool = False,
) -> dict[str, BuiltFmu]:
    """Build plant, sensors and controller into `folder`/<configuration>/, each replaced in one piece.

    Parameters
    ----------
    designs : of one configuration
    folder : usually `fmus`
    report : called with a line for each file written
    naming : "flat" builds the same FMUs with flat names into `folder`/<configuration>/flat/
    execution_tool : declare that the FMUs need a tool to be executed
    """
    config = designs.corrected.config
    flat = naming == "flat"
    target = folder / config.name / "flat" if flat else folder / config.name
    built = {}
    for component, shell in SHELLS.items():
        path = target / f"{component}.fmu"
        path.parent.mkdir(parents=True, exist_ok=True)
        model_name = f"{component}_{config.name}{'_flat' if flat else ''}"
        resources = component_resources(designs, component)
        step = getattr(config.rates, component)
        experiments = tuple(replace(experiment, step=step) for experiment in EXPERIMENTS[component])
        table, runs = run_experiments(shell, resources, experiments)
        content = accompanying_files(
            component,
            table.renamed(naming),
            runs,
            draw(designs.corrected.spacecraft, config, component),
            config=config,
            model_name=model_name,
            version=importlib.metadata.version("flexsat"),
            step=step,
            stop=shell.stop_time,
            execution_tool=execution_tool,
        )
        built[component] = build_fmu(
            f"{shell.__module__}:{shell.__name__}",
            path,
            resources,
            model_name,
            documentation=content.documentation,
            extra=content.extra,
            naming=naming,
            execution_tool=execution_tool,
        )
        report(f"{path}  {path.stat().st_size / 1e6:.1f} MB  {built[component].guid}")
    return built
