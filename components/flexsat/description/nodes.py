"""Refuse a spacecraft's file whose structure has no mesh, too few modes, or no node at a site."""

from __future__ import annotations

from typing import Any

from ..parameters import Aperture, Plate
from ..structure.mesh import record_mesh
from ..structure.modes import clamped_dofs
from .placement import Site
from .source import Source

FREEDOMS = 3  # of a node


def check_structure(source: Source, values: dict[str, Any], sites: tuple[Site, ...]) -> None:
    """Compare what a file says of aperture, plate and sites with the mesh; raise SpacecraftFileError."""
    try:
        mesh = record_mesh(values.get("aperture", Aperture()))
    except ValueError:
        source.refuse(["aperture"], "there is a mesh for tiles of 2 m side in 4 rings only; leave the table out")
    plate: Plate = values.get("plate", Plate())
    most = FREEDOMS * len(mesh.nodes) - len(clamped_dofs(mesh, "vertices"))
    if plate.plant_modes > most:
        source.refuse(["plate", "plant_modes"], f"must be at most {most}, the modes of the mesh", plate.plant_modes)
    for site in sites:
        if site.on_bus is None:
            try:
                mesh.node_at(site.radius, site.angle)
            except ValueError as error:
                why = str(error).partition(": ")[2]
                source.refuse(["sites", site.name], f"{site.radius:g} m at {site.angle:g} deg: {why}; sites of the"
                              " structure are nodes of its mesh, see the built-in spacecraft")  # fmt: skip
