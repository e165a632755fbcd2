"""Refuse a spacecraft's file that asks for more modes than its structure has, or for nodes that it lacks."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ..parameters import Aperture, Modes
from ..structure.mesh import MeshNodes, nodes_of
from ..structure.modes import mode_limit
from .appendage import Appendage
from .fields import make, read_fields
from .placement import Site
from .source import Source, meant


def read_modes(source: Source, table: Any, aperture: Aperture | None, appendages: Sequence[Appendage]) -> Modes:
    """Return the numbers of modes; what is left out is that of the paper's spacecraft, or what there is.

    Raises
    ------
    SpacecraftFileError
        For more modes than aperture and appendages have.
    """
    values = read_fields(source, table, ["modes"], Modes)
    most = sum(min(one.modes, one.structure.mode_count) for one in appendages)
    most += 0 if aperture is None else mode_limit(aperture)
    if values.setdefault("plant", min(Modes().plant, most)) > most:
        source.refuse(["modes", "plant"], f"must be at most {most}, the modes of the structure", values["plant"])
    values.setdefault("design", min(Modes().design, values["plant"]))
    return make(source, ["modes"], Modes, values)


def check_nodes(
    source: Source, sites: Sequence[Site], aperture: Aperture | None, appendages: Sequence[Appendage]
) -> None:
    """Refuse sites that are no nodes of the structure; raise SpacecraftFileError."""
    names = [f"{one.name}.{name}" for one in appendages for name in one.structure.names]
    mesh = None if aperture is None else nodes_of(aperture)
    for site in sites:
        if site.node and site.node not in names:
            some = ", ".join(names[:8]) + (", ..." if len(names) > 8 else "")
            source.refuse(["sites", site.name, "node"], f"no such node; there are {some or 'none'}"
                          f"{meant(site.node, names)}", site.node)  # fmt: skip
        if site.on_plate:
            _check_polar(source, site, mesh)


def _check_polar(source: Source, site: Site, mesh: MeshNodes | None) -> None:
    if mesh is None:
        source.refuse(["sites", site.name], "radius and angle are of a node of the aperture, and there is none; write"
                      ' node = "appendage.node"')  # fmt: skip
    try:
        mesh.node_at(site.radius, site.angle)
    except ValueError as error:
        why = str(error).partition(": ")[2]
        source.refuse(["sites", site.name], f"{site.radius:g} m at {site.angle:g} deg: {why}; sites of the"
                      " structure are nodes of its mesh, see the built-in spacecraft")  # fmt: skip
