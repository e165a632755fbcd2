"""Read the sites of a spacecraft's file, and its devices: each entry mounts some along several axes at one site."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Annotated, Any

from ..parameters import DEGREE, Wheel
from ..quantities import Range
from .fields import make, read_fields
from .lines import Key
from .placement import ALONG, BUS, Device, Site, Vector, direction
from .source import Source, meant
from .units import number_in

DEVICE_KEYS = ("at", "axes")
KIND = "kind"  # of a wheel


@dataclass(frozen=True, slots=True, kw_only=True)
class OwnOfGyro:
    """What a single gyro may have of its own."""

    noise: Annotated[float, "rad/s", Range(minimum=0.0, maximum=DEGREE)]  # of a sample
    mounting_error: Annotated[Vector, "rad", Range(minimum=-DEGREE, maximum=DEGREE)]  # rotation vector


OWN = tuple(item.name for item in fields(OwnOfGyro))


def read_sites(source: Source, table: Any) -> tuple[Site, ...]:
    """Return the sites of the table [sites], in its order; raise SpacecraftFileError if one is refused."""
    if not isinstance(table, dict):
        source.refuse(
            ["sites"], 'must be a table; write for example tip = { radius = 14.176, angle = "60 deg" }', table
        )
    found = []
    for name, entry in table.items():
        keys = ["sites", name]
        if name == BUS:
            source.refuse(keys, f"{BUS} is the origin already; choose another name")
        values = read_fields(source, entry, keys, Site, without=("name", "on_bus"), also=("on_bus",))
        if "on_bus" in entry:
            values["on_bus"] = _vector(source, entry["on_bus"], [*keys, "on_bus"], "m")
        elif "radius" not in values and "node" not in values:
            source.refuse(keys, "has no place; write radius and angle of a node of the aperture, node of an appendage,"
                          " or on_bus = [x, y, z]")  # fmt: skip
        found.append(make(source, keys, Site, {**values, "name": name}))
    return tuple(found)


def read_devices(
    source: Source, entries: Any, kind: str, sites: tuple[Site, ...], wheels: Mapping[str, Wheel] | None = None
) -> tuple[Device, ...]:
    """Return wheels or sensors in the order of their entries and axes; raise SpacecraftFileError if one is refused.

    Parameters
    ----------
    kind : "wheels", "gyros", "accelerometers"
    wheels : kinds of wheels by name, which entries may have as `kind`; None: devices have no kinds
    """
    if not isinstance(entries, list) or not entries:
        source.refuse([kind], f'must be a list such as [{{ at = "{BUS}", axes = ["+x", "+y", "+z"] }}]', entries)
    names = [BUS, *(site.name for site in sites)]
    found = []
    for i, entry in enumerate(entries):
        keys: list[Key] = [kind, i]
        own = OWN if kind == "gyros" else ()
        source.check_keys(entry, keys, (*DEVICE_KEYS, *own) if wheels is None else (*DEVICE_KEYS, KIND))
        for key in DEVICE_KEYS:
            if key not in entry:
                source.refuse(keys, f"{key} is missing; write for example axes = [\"+x\"]" if key == "axes"
                              else f'at is missing; write for example at = "{BUS}"')  # fmt: skip
        site = entry["at"]
        if site not in names:
            source.refuse([*keys, "at"], f"no such site; there are {', '.join(names)}{meant(str(site), names)}", site)
        axes = entry["axes"]
        if not isinstance(axes, list) or not axes:
            source.refuse([*keys, "axes"], 'must be a list such as ["+x", [1, 1, 1]]', axes)
        wheel = None
        if wheels is not None and KIND in entry:
            if entry[KIND] not in wheels:
                known = f"there are {', '.join(wheels)}" if wheels else "there are none"
                source.refuse([*keys, KIND], f"no such kind of wheel; {known}{meant(str(entry[KIND]), wheels)}; a table"
                              " [wheel_kinds.NAME] makes one", entry[KIND])  # fmt: skip
            wheel = wheels[entry[KIND]]
        given = {key: entry[key] for key in own if key in entry}
        values = read_fields(source, given, keys, OwnOfGyro)
        found += [
            Device(site=site, axis=read_axis(source, a, [*keys, "axes", k]), wheel=wheel, **values)
            for k, a in enumerate(axes)
        ]
    return tuple(found)


def read_axis(source: Source, value: Any, keys: list[Key]) -> Vector:
    """Return the unit vector of an axis: a text such as "+x", or a direction; raise SpacecraftFileError."""
    if isinstance(value, str):
        if value not in ALONG:
            source.refuse(keys, f"must be {', '.join(ALONG)}, or a direction such as [1, 1, 1]", value)
        return ALONG[value]
    vector = _vector(source, value, keys, "1")
    try:
        return direction(vector)
    except ValueError as error:
        source.refuse(keys, str(error), value)


def _vector(source: Source, value: Any, keys: list[Key], unit: str) -> Vector:
    if not isinstance(value, list) or len(value) != 3:
        source.refuse(keys, f"must be a list of 3 numbers in {unit}" if unit != "1" else "must be a list of 3 numbers",
                      value)  # fmt: skip
    numbers = []
    for i, item in enumerate(value):
        try:
            numbers.append(number_in(unit, item))
        except ValueError as error:
            source.refuse([*keys, i], str(error), item)
    return numbers[0], numbers[1], numbers[2]
