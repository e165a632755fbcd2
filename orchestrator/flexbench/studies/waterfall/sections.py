"""What a sweep says, as blocks of a document and as lines."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ...html.document import Block, Heading, Paragraph, Picture, Table
from .sweep import read_waterfall

HEADER = ("speed [rpm]", "mode", "allowed for wheels", "linear deformation there [µm]")
FIGURE = Path("figures", "waterfall.svg")


def flagged_rows(content: Mapping[str, Any]) -> list[tuple[str, ...]]:
    """Return the crossings inside an allowed band, as texts."""
    return [
        (
            f"{crossing['speed_rpm']:.1f}",
            str(crossing["mode"]),
            ", ".join(map(str, crossing["inside_band_of_wheels"])),
            f"{1e6 * crossing['linear_deformation_of_those_m']:.3g}",
        )
        for crossing in content["crossings"]
        if crossing["inside_band_of_wheels"]
    ]


def summary(content: Mapping[str, Any]) -> str:
    """Return the sweep in a sentence."""
    speeds, flagged = content["speed_rpm"], flagged_rows(content)
    return (
        f"{content['configuration']}, seed {content['seed']}: {len(speeds)} runs of {content['stop']:g} s from"
        f" {speeds[0]:.0f} to {speeds[-1]:.0f} rpm, all wheels at one speed, loop open. The first harmonic meets"
        f" {len(content['crossings'])} modes, {len(flagged)} of them inside an allowed band."
    )


def blocks_beside(folder: Path) -> list[Block]:
    """Return the blocks of a sweep kept in a run's folder, in `waterfall` in it, or in `waterfall` beside it."""
    for place in (folder, folder / "waterfall", folder.parent / "waterfall"):
        content = read_waterfall(place)
        if content is None:
            continue
        blocks: list[Block] = [Heading(3, "Waterfall over wheel speed"), Paragraph(summary(content))]
        if (place / FIGURE).is_file():
            svg = (place / FIGURE).read_text(encoding="utf-8")
            blocks.append(Picture(svg[svg.index("<svg") :], FIGURE.name, "Deformation over wheel speed"))
        if flagged_rows(content):
            blocks.append(Table(HEADER, flagged_rows(content), code=frozenset()))
        return blocks
    return []
