"""Sections of a page, and the page that the template of all pages makes of them: one file that needs no network."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from flexbench.html.document import Block
from flexbench.html.render import template_environment

from .figure_images import Image, image_of

PAGE_FOLDER = Path(__file__).with_name("page")
SHARED_SCRIPTS = ("colours.js", "ticks.js", "elements.js")


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
    styles: Sequence[Path] = (),
    folder: Path = PAGE_FOLDER,
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
    styles : files, after the style of all pages
    folder : with templates of the sections, searched before that of all pages
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
