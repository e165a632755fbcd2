"""Write a spacecraft as the text of a file: what Python builds, and results are evaluated with later."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import fields, replace
from typing import Any

from ..controller_weights import ControllerDesign, Weights
from ..parameters import CONTROLLER_DESIGNS, Wheel
from .configuration import RELEASE, Configuration
from .placement import UNIT, Device, Site
from .spacecraft_file import SpacecraftFile, parse_spacecraft
from .wheel_kinds import HARMONICS, TABLE

_TABLES = ("bus", "aperture", "plate", "modes", "noise", "sensor_errors", "rates", "slew", "speeds")


def file_of(robust: Configuration, published: Configuration | None = None) -> SpacecraftFile:
    """Return the file that describes a spacecraft.

    Parameters
    ----------
    robust : the spacecraft, with the weights of its robust controller
    published : the same with other weights, for the FMUs' design `published`; None: the same weights

    Raises
    ------
    ValueError
        For appendages, whose modal data are files of their own, two that differ in more than their weights, or what a
        file may not state either: a site without a node, more modes than the structure has.
    """
    if all(device.wheel is not None for device in robust.wheels):  # the usual one is of no effect: a file has none
        robust, published = (one and replace(one, wheel=Wheel()) for one in (robust, published or robust))
    given: Mapping[ControllerDesign, Configuration] = {"robust": robust, "published": published or robust}
    if robust.appendages:
        raise ValueError(
            "Configuration.appendages: their modal data are files; write a spacecraft's file that names them"
        )
    text = "\n".join(_lines(robust, {name: one.weights for name, one in given.items()}))
    found = parse_spacecraft(text, robust.name)
    for design in CONTROLLER_DESIGNS:
        different = [
            item.name
            for item in fields(Configuration)
            if not _same(getattr(found.configurations[design], item.name), getattr(given[design], item.name))
        ]
        if different:
            raise ValueError(
                f"{robust.name}: robust and published controller may differ in their weights alone; they, or a file,"
                f" have another {', '.join(different)}"
            )
    return found


def _same(one: Any, other: Any) -> bool:
    """Return whether values are equal; axes of devices are those of unit vectors but for rounding."""
    if isinstance(one, tuple) and isinstance(other, tuple) and one and isinstance(one[0], Device):
        return len(one) == len(other) and all(
            (a.site, a.wheel, a.noise, a.mounting_error) == (b.site, b.wheel, b.noise, b.mounting_error)
            and math.dist(a.axis, b.axis) < UNIT
            for a, b in zip(one, other, strict=True)
        )
    return bool(one == other)


def _lines(config: Configuration, weights: Mapping[ControllerDesign, Weights]) -> Iterator[str]:
    yield "# Written by flexsat from a spacecraft in Python. Numbers are SI, radians included."
    yield f"name = {_text(config.name)}"
    yield f"layout = {_text(config.layout)}"
    kinds = {wheel: f"kind{k}" for k, wheel in enumerate(dict.fromkeys(d.wheel for d in config.wheels if d.wheel), 1)}
    for key in ("wheels", "gyros", "accelerometers"):
        devices: Sequence[Device] = getattr(config, key)
        yield f"{key} = ["
        for device in devices:
            kind = "" if device.wheel is None else f", kind = {_text(kinds[device.wheel])}"
            noise = "" if device.noise is None else f", noise = {_value(device.noise)}"
            off = f", mounting_error = {_value(device.mounting_error)}" if any(device.mounting_error) else ""
            yield f"  {{ at = {_text(device.site)}, axes = [{_value(device.axis)}]{kind}{noise}{off} }},"
        yield "]"
    yield "[sites]"
    yield from (f"{_text(site.name)} = {_site(site)}" for site in config.sites)
    for table in _TABLES:
        if (one := getattr(config, table)) is not None:
            yield f"[{table}]"
            yield from _fields(one)
    if any(device.wheel is None for device in config.wheels):
        yield "[wheel]"
        yield from _fields(config.wheel)
    for wheel, name in kinds.items():
        yield f"[{TABLE}.{name}]"
        yield from _fields(wheel)
    for design, one in weights.items():
        yield f"[controller.{design}]"
        yield from _fields(one)
    if config.release is not None:
        yield f"[{RELEASE}]"
        yield from _fields(config.release)


def _fields(one: Any) -> Iterator[str]:
    for item in fields(one):
        value = getattr(one, item.name)
        if isinstance(one, Wheel) and item.name == HARMONICS:
            value = [f"{{ {', '.join(_fields(harmonic))} }}" for harmonic in value]
            yield f"{item.name} = [{', '.join(value)}]"
        else:
            yield f"{item.name} = {_value(value)}"


def _site(site: Site) -> str:
    if site.on_bus is not None:
        return f"{{ on_bus = {_value(site.on_bus)} }}"
    if site.node:
        return f"{{ node = {_text(site.node)} }}"
    return f"{{ radius = {site.radius!r}, angle = {site.angle!r} }}"


def _value(value: Any) -> str:
    if isinstance(value, str):
        return _text(value)
    if isinstance(value, (tuple, list)):
        return f"[{', '.join(map(_value, value))}]"
    return json.dumps(value)  # numbers with all their digits, true and false


def _text(value: str) -> str:
    return json.dumps(value, ensure_ascii=False)
