"""Make the files of an FMU other than its code: documentation, pictures, terminals, reference results."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from ...description.configuration import Configuration
from ...description.placement import ALONG, Device, Site
from ...ports.table import FmiVersion, PortTable
from ...spacecraft.assembly import Spacecraft
from ...spacecraft.flexible import structure_of
from .component_text import ComponentText
from .controller_text import CONTROLLER
from .device_rows import DeviceRows
from .drawing import Shown, icon, model_picture
from .licences import licence_files
from .mission_text import ENVIRONMENT, MISSION, THRUSTERS
from .native_notes import NativeNotes
from .page import external_dependencies, page, replay_instructions
from .plant_text import PLANT
from .reference_results import Run, reference_files
from .sensors_text import SENSORS
from .terminals import terminals_xml

MODEL_PICTURE = "model.png"
TEXTS: dict[str, ComponentText] = {
    "plant": PLANT,
    "sensors": SENSORS,
    "controller": CONTROLLER,
    "environment": ENVIRONMENT,
    "thrusters": THRUSTERS,
    "mission": MISSION,
}


@dataclass(frozen=True, slots=True, kw_only=True)
class AccompanyingFiles:
    """Files of an FMU other than its code: below documentation/, and elsewhere in the archive."""

    documentation: dict[str, bytes]
    extra: dict[str, bytes]


def accompanying_files(
    component: str,
    table: PortTable,
    runs: Sequence[Run],
    pictures: Mapping[str, bytes],
    *,
    config: Configuration,
    devices: DeviceRows,
    model_name: str,
    version: str,
    step: float,
    stop: float,
    execution_tool: bool = False,
    native: NativeNotes | None = None,
    fmi: FmiVersion = "2.0",
) -> AccompanyingFiles:
    """Return the files of one FMU other than its code, with names in the naming of the table.

    Parameters
    ----------
    component : plant, sensors or controller
    runs : its experiments, already run
    devices : what the elements of the arrays belong to
    pictures : from `draw`
    step, stop : of the default experiment [s]
    execution_tool : whether the model description declares that a tool is needed
    native : of an FMU in C; None for one in Python
    """
    experiments = [run.experiment for run in runs]
    index = page(
        table,
        TEXTS[component],
        experiments,
        file=f"{component}.fmu",
        model_name=model_name,
        configuration=_layout(config),
        devices=devices,
        version=version,
        step=step,
        stop=stop,
        execution_tool=execution_tool,
        native=native,
        fmi=fmi,
    )
    documentation = {
        "index.html": index,
        "externalDependencies.txt": external_dependencies(native, fmi),
        "fmi-ls-ref.txt": replay_instructions(native is not None, fmi),
        **{f"licenses/{name}": content for name, content in licence_files(native is not None).items()},
    }
    terminals = {"terminalsAndIcons/terminalsAndIcons.xml": terminals_xml(table, fmi)}
    if fmi == "3.0":  # the picture of the model has another place
        pictures = {"documentation/diagram.png" if name == MODEL_PICTURE else name: p for name, p in pictures.items()}
    return AccompanyingFiles(
        documentation=documentation, extra={**pictures, **terminals, **reference_files(table, runs, fmi)}
    )


def draw(spacecraft: Spacecraft, config: Configuration, component: str) -> dict[str, bytes]:
    """Return the pictures of an FMU by their path in the archive."""
    shown = Shown(structure=structure_of(config), aperture=config.aperture)
    modes = {"plant": config.modes.plant, "controller": config.modes.design}
    return {
        MODEL_PICTURE: model_picture(spacecraft, component, shown, modes.get(component)),
        "terminalsAndIcons/icon.png": icon(spacecraft, component, shown),
    }


def _layout(config: Configuration) -> str:
    kinds = config.wheel_set.kinds
    wheels = f"its wheels are {kinds}" if "," in kinds else f"each wheel has {kinds.partition(' of ')[2]}"
    sites = ", ".join(f"{site.name} {_place(site)}" for site in config.all_sites)
    return (
        f"This one carries {config.layout}; {wheels}. The structure has {config.modes.plant} modes,"
        f" of which the controller is designed with {config.modes.design}, and {config.plate.area_density:.4g}"
        f" kg/m2; the bus has {config.bus.mass:.6g} kg. Sites, in m from the centre of the aperture: {sites}."
        f" Gyros: {_devices(config.gyros)}. Accelerometers: {_devices(config.accelerometers)}."
    )


def _place(site: Site) -> str:
    if site.on_bus is None:
        return f"{site.radius:g} @ {site.angle:g} deg from x"
    return f"({', '.join(f'{x:g}' for x in site.on_bus)})"


def _devices(devices: Sequence[Device]) -> str:
    """Return sites and axes in the order of the devices: bus +x, +y, +z; site1 +x, +y."""
    names = {axis: name for name, axis in ALONG.items()}
    groups: list[tuple[str, list[str]]] = []
    for device in devices:
        axis = names.get(device.axis) or f"({', '.join(f'{x:.4g}' for x in device.axis)})"
        if not groups or groups[-1][0] != device.site:
            groups.append((device.site, []))
        groups[-1][1].append(axis)
    return "; ".join(f"{site} {', '.join(axes)}" for site, axes in groups)
