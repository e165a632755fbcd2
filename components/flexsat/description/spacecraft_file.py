"""Read a spacecraft from a TOML file: one configuration for each of its controllers."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import Any, get_type_hints

from ..controller_weights import ControllerDesign, Weights
from ..errors import SpacecraftFileError
from ..parameters import (
    CONTROLLER_DESIGNS,
    Aperture,
    Plate,
    Rates,
    SensorErrors,
    SensorNoise,
    Slew,
    SpeedSelection,
)
from .appendage_tables import read_appendages
from .configuration import RELEASE, Configuration, Release, check_name
from .fields import make, read_fields, refuse_as
from .nodes import check_nodes, read_modes
from .placed_devices import KIND, read_devices, read_sites
from .placement import Bus, Site
from .source import Source
from .wheel_kinds import TABLE as WHEEL_KINDS
from .wheel_kinds import read_kinds, read_wheel

START = Path(__file__).with_name("start.toml")  # a file to start from, for str.format with `name`
LARGEST = 1_000_000  # bytes of a file: far more than any spacecraft takes
DENSITY = "/rtHz"  # ends the unit of a noise density
_TABLES: Mapping[str, type] = {"aperture": Aperture, "plate": Plate, "rates": Rates, "slew": Slew,
                               "speeds": SpeedSelection, "sensor_errors": SensorErrors}  # fmt: skip
_DEVICES = ("wheels", "gyros", "accelerometers")
KEYS = (
    "name",
    "layout",
    *_DEVICES,
    "sites",
    "bus",
    "wheel",
    WHEEL_KINDS,
    *_TABLES,
    "modes",
    "appendages",
    "noise",
    "controller",
    RELEASE,
)


@dataclass(frozen=True, slots=True, kw_only=True)
class SpacecraftFile:
    """A spacecraft with both of its controllers, and the text that it was read from."""

    text: str
    configurations: Mapping[ControllerDesign, Configuration]
    files: Mapping[str, bytes] = field(default_factory=dict)  # the modal files that it names, by their own names

    @property
    def name(self) -> str:
        """The name of the spacecraft."""
        return self.configurations["robust"].name


def read_spacecraft(path: Path) -> SpacecraftFile:
    """Read a spacecraft's file; raise SpacecraftFileError for one that is refused, or cannot be read."""
    try:
        if path.stat().st_size > LARGEST:
            raise SpacecraftFileError(
                f"{path}: larger than {LARGEST // 1000} kB; a spacecraft's file is a few kB of TOML"
            )
        text = path.read_text(encoding="utf-8")
    except OSError as error:
        raise SpacecraftFileError(
            f"{path}: cannot be read ({error.strerror}); `flexsat new` writes a file to start from"
        ) from None
    except UnicodeDecodeError as error:
        raise SpacecraftFileError(f"{path}: not UTF-8 at byte {error.start}; a spacecraft's file is TOML") from None
    return parse_spacecraft(text, path.name, path.parent)


def parse_spacecraft(text: str, name: str, folder: Path = Path()) -> SpacecraftFile:
    """Return the spacecraft of a file's text; `name` stands for the file in messages, `folder` has its modal files."""
    source = Source(name=name, text=text)
    tables = source.tables()
    source.check_keys(tables, [], KEYS)
    values: dict[str, Any] = {key: _table(source, tables, key, kind) for key, kind in _TABLES.items() if key in tables}
    rates = values.setdefault("rates", Rates())
    if "noise" in tables:
        values["noise"] = _noise(source, tables["noise"], rates)
    if "bus" in tables:
        values["bus"] = _bus(source, tables["bus"])
    sites = read_sites(source, tables.get("sites", {}))
    values["appendages"], files = read_appendages(source, tables.get("appendages", []), folder)
    if values["appendages"] and "aperture" not in tables and "plate" not in tables:
        values["aperture"] = None  # what is given is all that is flexible
    aperture = values.setdefault("aperture", Aperture())
    values["modes"] = read_modes(source, tables.get("modes", {}), aperture, values["appendages"])
    check_nodes(source, sites, aperture, values["appendages"])
    kinds = read_kinds(source, tables.get(WHEEL_KINDS, {}))
    for kind in _DEVICES:
        if kind not in tables:
            source.refuse([kind], "is missing; write for example"
                          f' {kind} = [{{ at = "bus", axes = ["+x", "+y", "+z"] }}]')  # fmt: skip
        values[kind] = read_devices(source, tables[kind], kind, sites, kinds if kind == "wheels" else None)
    used = [entry.get(KIND) for entry in tables["wheels"]]
    for name in kinds:
        if name not in used:
            source.refuse([WHEEL_KINDS, name], f'has no wheel; write kind = "{name}" in an entry of wheels')
    if "wheel" in tables and None not in used:
        source.refuse(["wheel"], "is that of wheels without kind, and all have one; leave it out")
    if RELEASE in tables:
        values["release"] = _release(source, tables[RELEASE], sites)
    common = {
        **values,
        "name": _name(source, tables),
        "layout": _text(source, tables, "layout", f"{len(values['wheels'])} wheels"),
        "sites": sites,
        "wheel": read_wheel(source, tables.get("wheel", {})),
    }
    weights = _weights(source, tables.get("controller", {}))
    return SpacecraftFile(
        text=text,
        files=files,
        configurations={
            design: make(source, [], Configuration, {**common, "weights": weights[design]})
            for design in CONTROLLER_DESIGNS
        },
    )


def _table(source: Source, tables: Mapping[str, Any], key: str, kind: type) -> Any:
    return make(source, [key], kind, read_fields(source, tables[key], [key], kind))


def _name(source: Source, tables: Mapping[str, Any]) -> str:
    name = _text(source, tables, "name", "")
    if not name:
        source.refuse(["name"], 'is missing; write for example name = "pyramid": FMUs are built to fmus/pyramid')
    try:
        check_name(name)
    except ValueError as error:
        source.refuse(["name"], str(error).removeprefix("Configuration.name ").partition(", got")[0], name)
    return name


def _text(source: Source, tables: Mapping[str, Any], key: str, default: str) -> str:
    text = tables.get(key, default)
    if not isinstance(text, str):
        source.refuse([key], "must be a text", text)
    return text


def _bus(source: Source, table: Any) -> Bus:
    values = read_fields(source, table, ["bus"], Bus)
    if len(values.get("inertia", ())) == 3:  # moments alone
        values["inertia"] = (*values["inertia"], 0.0, 0.0, 0.0)
    return make(source, ["bus"], Bus, values)


def _noise(source: Source, table: Any, rates: Rates) -> SensorNoise:
    """Return the deviations of samples; a density with the unit .../rtHz is multiplied by the root of the rate."""
    source.check_keys(table, ["noise"], [item.name for item in fields(SensorNoise)])
    densities = {name: value for name, value in table.items() if isinstance(value, str) and value.endswith(DENSITY)}
    if "filter_frequency" in densities:
        source.refuse(["noise", "filter_frequency"], "must be a number in Hz", densities["filter_frequency"])
    given = {name: value.removesuffix(DENSITY) if name in densities else value for name, value in table.items()}
    values = read_fields(source, given, ["noise"], SensorNoise)
    for name, text in densities.items():
        period = rates.star_tracker if name.startswith("star_tracker") else rates.controller
        values[name] /= math.sqrt(period)
        limits = get_type_hints(SensorNoise, include_extras=True)[name].__metadata__[1]
        if values[name] not in limits:
            source.refuse(
                ["noise", name], f"is a deviation of {values[name]:.3g} of a sample, and must be {limits}", text
            )
    return make(source, ["noise"], SensorNoise, values)


def _weights(source: Source, table: Any) -> dict[ControllerDesign, Weights]:
    """Return the weights of each controller: those of [controller], and over them those of its own table."""
    common = read_fields(source, table, ["controller"], Weights, also=CONTROLLER_DESIGNS)
    shared = make(source, ["controller"], Weights, common)
    found: dict[ControllerDesign, Weights] = {}
    for design in CONTROLLER_DESIGNS:
        keys = ["controller", design]
        own = read_fields(source, table.get(design, {}), keys, Weights)
        try:
            found[design] = replace(shared, **own)
        except ValueError as error:
            refuse_as(source, keys, Weights, str(error))
    return found


def _release(source: Source, table: Any, sites: tuple[Site, ...]) -> Release:
    source.check_keys(table, [RELEASE], [item.name for item in fields(Release)])
    values = read_fields(source, {k: v for k, v in table.items() if k != "mode_rows"}, [RELEASE], Release)
    rows: Sequence[Any] = table.get("mode_rows", [])
    if not isinstance(rows, list) or not all(isinstance(row, str) for row in rows):
        source.refuse([RELEASE, "mode_rows"], "must be a list of names of sites", rows)
    known = [site.name for site in sites if site.on_bus is None]
    if sorted(rows) != sorted(known):
        source.refuse([RELEASE, "mode_rows"], f"must have each site of the structure once: {', '.join(known)}")
    if "modes" not in values:
        source.refuse([RELEASE], "modes is missing; write how many plant and controller have")
    return make(source, [RELEASE], Release, {**values, "mode_rows": tuple(rows)})
