"""The flexible structure of a spacecraft: its aperture and its appendages on one rigid bus."""

from __future__ import annotations

from functools import lru_cache

from ..description.appendage import Appendage
from ..description.configuration import Configuration
from ..description.placement import Site
from ..parameters import Aperture, Plate
from ..structure.combine import combined
from ..structure.modes import aperture_structure
from ..structure.structure import Structure


def structure_of(config: Configuration) -> Structure:
    """Return all that is flexible with the lowest modes of a configuration, in body axes from the origin."""
    return _structure(config.aperture, config.plate, config.appendages, config.modes.plant)


@lru_cache(maxsize=8)
def _structure(aperture: Aperture | None, plate: Plate, appendages: tuple[Appendage, ...], count: int) -> Structure:
    parts = [] if aperture is None else [aperture_structure(aperture, plate, count)]
    return combined([*parts, *(one.in_body() for one in appendages)], count)


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
