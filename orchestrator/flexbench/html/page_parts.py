"""Sections of a page, and the page that the template of all pages makes of them: one file that needs no network."""

from __future__ import annotations

import base64
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from .document import Block, Picture
from .render import template_environment

PAGE_FOLDER = Path(__file__).with_name("page")
SHARED_SCRIPTS = ("colours.js", "ticks.js", "elements.js")
TYPES = {".svg": "image/svg+xml", ".png": "image/png"}


@dataclass(frozen=True, slots=True, kw_only=True)
class Image:
    """A figure as the bytes of an image file."""

    title: str
    data: bytes
    type: str
    name: str = ""  # of its file, without ending
    raster: Path | None = None  # its PNG, where it is stored in both formats

    @property
    def source(self) -> str:
        """The image as a data URI, so that the page needs no file."""
        return f"data:{self.type};base64,{base64.b64encode(self.data).decode()}"


def image_of(picture: Picture) -> Image:
    """Return the picture of a document block as an image."""
    return Image(title=picture.description, data=picture.svg.encode("utf-8"), type=TYPES[".svg"])


@dataclass(frozen=True, slots=True, kw_only=True)
class PageSection:
    """One section of a page: its title, its template, and the values that the template shows."""

    anchor: str
    title: str
    template: str = "blocks_section.html"
    blocks: Sequence[Block] = ()
    runs: Sequence[tuple[str, Sequence[Block]]] = ()  # name and blocks of each run
    images: Sequence[Image] = ()
    notes: Sequence[str] = ()


def render_page(
    title: str,
    subtitle: str,
    sections: Sequence[PageSection],
    contents: Mapping[str, Any],
    data: Sequence[str],
    scripts: Sequence[Path],
    *,
    folder: Path,
    styles: Sequence[Path] = (),
    status: str = "",
) -> str:
    """Return a page as HTML.

    Parameters
    ----------
    title, subtitle : of the page
    sections : in their order
    contents : for the scripts, as JSON
    data : texts of elements with the ids d0, d1, ..., which the contents name
    scripts : files, after those of all pages
    folder : with templates of the sections, searched before that of all pages
    styles : files, after the style of all pages
    status : of a single run
    """
    return (
        template_environment(folder, PAGE_FOLDER)
        .get_template("page.html")
        .render(
            title=title,
            subtitle=subtitle,
            status=status,
            sections=sections,
            image_of=image_of,
            contents=contents,
            data=data,
            style="".join(map(_text, [PAGE_FOLDER / "style.css", *styles])),
            script="\n".join(map(_text, [*(PAGE_FOLDER / name for name in SHARED_SCRIPTS), *scripts])),
        )
    )


def _text(path: Path) -> str:
    return path.read_text(encoding="utf-8")
