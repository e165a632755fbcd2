"""Figures of a page as images: those stored in the results folders, or else drawn now."""

from __future__ import annotations

import base64
import io
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from flexbench.html.document import Picture
from lockstep.errors import InputError

from .captions import caption_of
from .results import Result

ROOM = 2_500_000  # bytes for all figures of a page, before base64
LARGE = 800_000  # bytes of an SVG from which on PNG is smaller
TYPES = {".svg": "image/svg+xml", ".png": "image/png"}


@dataclass(frozen=True, slots=True, kw_only=True)
class Image:
    """A figure as the bytes of an image file."""

    title: str
    data: bytes
    type: str

    @property
    def source(self) -> str:
        """The image as a data URI, so that the page needs no file."""
        return f"data:{self.type};base64,{base64.b64encode(self.data).decode()}"


def image_of(picture: Picture) -> Image:
    """Return the picture of a document block as an image."""
    return Image(title=picture.description, data=picture.svg.encode("utf-8"), type=TYPES[".svg"])


def stored_images(folder: Path) -> list[Image]:
    """Return the figures stored in a results folder, each in the smaller of its formats."""
    found: dict[str, Path] = {}
    for path in sorted((folder / "figures").glob("*")):
        if path.suffix in TYPES and (path.stem not in found or path.stat().st_size < found[path.stem].stat().st_size):
            found[path.stem] = path
    return [
        Image(title=caption_of(stem), data=path.read_bytes(), type=TYPES[path.suffix]) for stem, path in found.items()
    ]


def drawn_images(results: Sequence[Result]) -> list[Image]:
    """Draw the paper's figures of the runs of flexsat systems, configurations overlaid."""
    from flexbench.figures.figure_lists import result_figures  # matplotlib takes a second to import

    images = []
    for name, draw in result_figures([result.run for result in results if result.run is not None]).items():
        with suppress(InputError):  # a signal that the figure needs was not recorded, or in part
            images.append(_image(caption_of(name), draw()))
    return images


def _image(title: str, figure: Any) -> Image:
    vector = io.BytesIO()
    figure.savefig(vector, format="svg")
    if len(vector.getvalue()) <= LARGE:
        return Image(title=title, data=vector.getvalue(), type=TYPES[".svg"])
    raster = io.BytesIO()
    figure.savefig(raster, format="png", dpi=150)
    return Image(title=title, data=raster.getvalue(), type=TYPES[".png"])


def split_by_size(images: Sequence[Image], room: int = ROOM) -> tuple[list[Image], list[Image]]:
    """Return the images that fit the page, in their order, and those that are too large for it."""
    taken, left = [], []
    for image in images:
        if len(image.data) <= room:
            taken.append(image)
            room -= len(image.data)
        else:
            left.append(image)
    return taken, left
