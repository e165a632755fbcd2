"""Figures of a page as images: those stored in the results folders, or else drawn now; reduced where room is short."""

from __future__ import annotations

import io
import re
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

import PIL.Image

from flexbench.html.page_parts import TYPES, Image
from lockstep.errors import InputError

from .captions import caption_of, place_of
from .results import Result

_PLACES = re.compile(rb' (?:d|x|y|points)="[^"]*"')  # of paths and marks; not the scales of transformations
_DECIMALS = re.compile(rb"(\.\d\d)\d+")
ROOM = 2_400_000  # bytes for all figures of a page, before base64
WIDTHS = (1800, 1400, 1000, 700)  # pixels of a figure that is reduced, widest first; a page shows 1170
COLOURS = 64  # of a reduced figure: lines, bands, and shades between
LARGE = 800_000  # bytes of an SVG from which on PNG is smaller


def slim(svg: bytes) -> bytes:
    """Return an SVG whose places have two decimals: a hundredth of a point, as no screen shows less."""
    return _PLACES.sub(lambda found: _DECIMALS.sub(rb"\1", found[0]), svg)


def stored_images(folder: Path) -> list[Image]:
    """Return the figures stored in a results folder, each in the smaller of its formats."""
    files: dict[str, list[Path]] = {}
    for path in sorted((folder / "figures").glob("*")):
        if path.suffix in TYPES:
            files.setdefault(path.stem, []).append(path)
    images = []
    for stem, paths in sorted(files.items(), key=lambda entry: (place_of(entry[0]), entry[0])):
        read = {path: slim(path.read_bytes()) if path.suffix == ".svg" else path.read_bytes() for path in paths}
        smallest = min(paths, key=lambda path: len(read[path]))
        raster = next((path for path in paths if path.suffix == ".png"), None)
        images.append(
            Image(
                title=caption_of(stem),
                data=read[smallest],
                type=TYPES[smallest.suffix],
                name=stem,
                raster=raster,
            )
        )
    return images


def drawn_images(results: Sequence[Result]) -> list[Image]:
    """Draw the paper's figures of the runs of flexsat systems, configurations overlaid."""
    from flexbench.figures.figure_lists import result_figures  # matplotlib takes a second to import

    images = []
    for name, draw in result_figures([result.run for result in results if result.run is not None]).items():
        with suppress(InputError):  # a signal that the figure needs was not recorded, or in part
            images.append(_image(name, draw()))
    return images


def _image(name: str, figure: Any) -> Image:
    from flexbench.figures.drawing import png_bytes, svg_text

    data = slim(svg_text(figure, name).encode())
    if len(data) <= LARGE:
        return Image(title=caption_of(name), data=data, type=TYPES[".svg"], name=name)
    return Image(title=caption_of(name), data=png_bytes(figure), type=TYPES[".png"], name=name)


def fitted_images(images: Sequence[Image], room: int = ROOM) -> tuple[list[Image], list[Image]]:
    """Return the images that fit the page, in their order, and those for which there is no room.

    Where they are too large together the largest are replaced by PNG of fewer pixels and colours, so that only images
    without a PNG can be left out.
    """
    shown = list(images)
    for width in WIDTHS:
        for k in sorted(range(len(shown)), key=lambda k: -len(shown[k].data)):
            if sum(len(image.data) for image in shown) <= room:
                return shown, []
            shown[k] = _reduced(shown[k], width)
    left: list[Image] = []
    while sum(len(image.data) for image in shown) > room:
        left.append(shown.pop(max(range(len(shown)), key=lambda k: len(shown[k].data))))
    return shown, left


def _reduced(image: Image, width: int) -> Image:
    """Return an image as a PNG of at most this width with few colours, if that is smaller."""
    if image.raster is None and image.type != TYPES[".png"]:
        return image
    source = io.BytesIO(image.data) if image.raster is None else image.raster
    with PIL.Image.open(source) as opened:
        picture = opened.convert("RGB")
    if picture.width > width:
        picture = picture.resize((width, round(picture.height * width / picture.width)), PIL.Image.Resampling.LANCZOS)
    written = io.BytesIO()
    picture.quantize(COLOURS).save(written, format="png", optimize=True)
    if len(written.getvalue()) >= len(image.data):
        return image
    return replace(image, data=written.getvalue(), type=TYPES[".png"])
