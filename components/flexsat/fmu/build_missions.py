"""Build the FMUs of missions of one configuration: environment, thrusters and mission manager, in Python and in C."""

from __future__ import annotations

import importlib.metadata
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields
from pathlib import Path

import numpy as np

from ..design.chain import Design, Designs
from ..parameters import ENVIRONMENT_PERIOD
from ..ports.table import FmiVersion, PortTable
from ..runtime.missions.mission_data import MissionData
from ..structure.mesh import tile_centres
from ..variants import CORRECTED
from .build_native import described_by, write_native_fmu
from .documentation.content import AccompanyingFiles, accompanying_files, draw
from .documentation.device_rows import device_rows
from .documentation.mission_experiments import MISSION_EXPERIMENTS
from .documentation.native_notes import NativeNotes
from .documentation.reference_results import Run, run_experiments
from .export import BuiltFmu, build_fmu
from .native.compile import native_notes
from .native.export import NativeComponent
from .native.sources import IN_C, native_folder
from .python.environment import Environment
from .python.load_matrices import MODEL_FILE
from .python.mission import Mission
from .python.thrusters import Thrusters
from .reproducible_zip import npz_bytes

HEXAGON = 1.5 * 3.0**0.5  # area over side squared
FOLDER = "missions"  # of the FMUs, in that of a layout
MISSION_SHELLS: dict[str, type[Environment | Thrusters | Mission]] = {
    "environment": Environment,
    "thrusters": Thrusters,
    "mission": Mission,
}


@dataclass(frozen=True, slots=True, kw_only=True)
class MissionParts:
    """What the FMUs of one component of missions have in common, whatever runs them."""

    component: str
    design: Design
    resources: Mapping[str, bytes]
    table: PortTable
    runs: list[Run]
    pictures: Mapping[str, bytes]
    step: float  # s, recommended by the model description

    @property
    def model_name(self) -> str:
        """Name of the model."""
        return f"{self.component}_{self.design.config.name}"

    def accompanying_files(self, native: NativeNotes | None = None, fmi: FmiVersion = "2.0") -> AccompanyingFiles:
        """Return the documentation, pictures and reference results."""
        shell = MISSION_SHELLS[self.component]
        return accompanying_files(
            self.component,
            self.table,
            self.runs,
            self.pictures,
            config=self.design.config,
            devices=device_rows(self.design),
            model_name=self.model_name,
            version=importlib.metadata.version("flexsat"),
            step=self.step,
            stop=shell.stop_time,
            native=native,
            fmi=fmi,
        )


def mission_data(design: Design) -> MissionData:
    """Return what the FMUs of missions know of a spacecraft."""
    config, controller = design.config, design.controller
    count, tiles = len(controller.nominal_speed), config.aperture
    return MissionData(
        inertia=controller.inertia,
        area=0.0 if tiles is None else len(tile_centres(tiles)) * HEXAGON * tiles.tile_side**2,
        wheel_axis=controller.wheel_axis,
        wheel_inertia=np.full(count, controller.wheel_inertia),  # one, or one for each
        torque_limit=controller.torque_limit * controller.torque_limit_factor,
        nominal_speed=controller.nominal_speed,
        speed_band=controller.speed_band,
        period=controller.period,
    )


def mission_resources(design: Design) -> dict[str, bytes]:
    """Return the files that travel in the FMUs of missions of a design."""
    return data_resources(mission_data(design))


def data_resources(data: MissionData) -> dict[str, bytes]:
    """Return the files that travel in the FMUs of missions."""
    arrays = {f"{CORRECTED.name}.{item.name}": np.asarray(getattr(data, item.name)) for item in fields(data)}
    return {MODEL_FILE: npz_bytes(arrays)}


def mission_parts(designs: Designs) -> dict[str, MissionParts]:
    """Return the parts of all components of missions; the experiments are run."""
    design = designs.corrected
    resources = mission_resources(design)
    steps = {"environment": ENVIRONMENT_PERIOD}  # the others step with the controller
    parts = {}
    for component, shell in MISSION_SHELLS.items():
        table, runs = run_experiments(shell, resources, MISSION_EXPERIMENTS[component], fixed_order=False)
        pictures = draw(design.spacecraft, design.config, component)
        parts[component] = MissionParts(
            component=component,
            design=design,
            resources=resources,
            table=table,
            runs=runs,
            pictures=pictures,
            step=steps.get(component, design.controller.period),
        )
    return parts


def build_missions(
    designs: Designs,
    folder: Path,
    report: Callable[[str], None] = lambda _: None,
    *,
    versions_in_c: Sequence[FmiVersion] = ("2.0",),
    platforms: Sequence[str] = (),
) -> dict[str, BuiltFmu]:
    """Build the FMUs of missions into `folder`/<configuration>/missions/, and those in C into its native/.

    Parameters
    ----------
    designs : of one configuration
    folder : usually `fmus`
    report : called with a line for each file written
    versions_in_c : versions of FMI of those in C; those of FMI 3.0 stand in native/fmi3/
    platforms : of those in C, as of `flexsat.fmu.native.compile.binaries`

    Raises
    ------
    BuildError
        If those in C are wanted and there is no C compiler here.
    """
    target = folder / designs.corrected.config.name / FOLDER
    target.mkdir(parents=True, exist_ok=True)
    built = {}
    for component, part in mission_parts(designs).items():
        shell = MISSION_SHELLS[component]
        content = part.accompanying_files()
        built[component] = build_fmu(
            f"{shell.__module__}:{shell.__name__}",
            target / f"{component}.fmu",
            part.resources,
            part.model_name,
            documentation=content.documentation,
            extra=content.extra,
        )
        for fmi in versions_in_c:
            path = native_folder(target, fmi) / f"{component}.fmu"
            built[f"{component}, {IN_C[fmi]}"] = _build_native(part, path, fmi, platforms)
    for one in built.values():
        report(f"{one.path}  {one.path.stat().st_size / 1e6:.1f} MB  {one.guid}")
    return built


def _build_native(part: MissionParts, path: Path, fmi: FmiVersion, platforms: Sequence[str]) -> BuiltFmu:
    files = part.accompanying_files(native_notes(part.model_name, platforms, fmi), fmi)
    return write_native_fmu(native_mission_component(part), files, path, fmi, platforms)


def native_mission_component(part: MissionParts) -> NativeComponent:
    """Return what the native FMU of a component of missions is made from."""
    return described_by(
        MISSION_SHELLS[part.component], part.component, part.model_name, part.table, part.resources, variants={}
    )
