"""The flexible structure of a spacecraft: its aperture and its appendages on one rigid bus."""

from __future__ import annotations

from functools import lru_cache

from ..arrays import Index
from ..description.appendage import Appendage
from ..description.configuration import Configuration
from ..description.placement import Site
from ..parameters import Aperture, Plate
from ..structure.combine import combined, parts_of_modes
from ..structure.modes import aperture_structure
from ..structure.structure import Structure


def structure_of(config: Configuration) -> Structure:
    """Return all that is flexible with the lowest modes of a configuration, in body axes from the origin."""
    return _structure(config.aperture, config.plate, config.appendages, config.modes.plant)


def appendages_of_modes(config: Configuration) -> Index:
    """Return the appendage that each mode of the structure is one of, (m,), from 0; -1 for those of the aperture."""
    first = 0 if config.aperture is None else 1
    parts = _parts(config.aperture, config.plate, config.appendages, config.modes.plant)
    return parts_of_modes(parts, config.modes.plant) - first


def appendage_at(config: Configuration, site: Site) -> int:
    """Return the appendage that a site is a node of, from 0; -1 for a site on the bus or the aperture."""
    owners = (k for k, one in enumerate(config.appendages) if site.node.startswith(f"{one.name}."))
    return next(owners, -1)


@lru_cache(maxsize=8)
def _structure(aperture: Aperture | None, plate: Plate, appendages: tuple[Appendage, ...], count: int) -> Structure:
    return combined(_parts(aperture, plate, appendages, count), count)


def _parts(
    aperture: Aperture | None, plate: Plate, appendages: tuple[Appendage, ...], count: int
) -> tuple[Structure, ...]:
    own = [] if aperture is None else [aperture_structure(aperture, plate, count)]
    return (*own, *(one.in_body() for one in appendages))


def node_of(structure: Structure, site: Site) -> int:
    """Return the node at a site of the structure.

    Raises
    ------
    ValueError
        If there is none.
    """
    if site.node:
        return structure.node_named(site.node)
    if structure.mesh is None:
        raise ValueError(f"site {site.name}: there is no aperture; name a node: appendage.node")
    return structure.mesh.node_at(site.radius, site.angle)
