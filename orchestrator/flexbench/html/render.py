"""Write documents as HTML by Jinja templates, every text escaped."""

from __future__ import annotations

import re
from collections.abc import Sequence
from functools import cache
from pathlib import Path

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from .document import Block, Heading, Listing, Paragraph, Picture

TEMPLATES = Path(__file__).with_name("templates")
LONGEST_NUMBER = 24  # letters of a cell that is kept on one line, with its unit or a second number
_CODE = re.compile(r"`([^`]+)`")  # as in Markdown


@cache
def template_environment(*folders: Path) -> Environment:
    """Return an environment that finds templates in these folders, and after them those of this package.

    Texts are escaped, unknown names are errors, and `tojson` escapes what could end a script element.
    """
    environment = Environment(
        loader=FileSystemLoader([*folders, TEMPLATES]),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    environment.policies["json.dumps_kwargs"] = {"ensure_ascii": False, "allow_nan": False}
    environment.filters["split_code"] = _CODE.split  # texts and, in odd places, what stands between backticks
    environment.tests["number_cell"] = is_number_cell
    for name, kind in (("heading", Heading), ("paragraph", Paragraph), ("listing", Listing), ("picture", Picture)):
        environment.tests[name] = kind.__instancecheck__
    return environment


def is_number_cell(text: str) -> bool:
    """Return whether a cell is short and begins with a number, so that it must not break, as in an exponent."""
    return len(text) <= LONGEST_NUMBER and text.lstrip("+-")[:1].isdigit()


def as_html(blocks: Sequence[Block]) -> str:
    """Write the document as one page that needs no network; its pictures are trusted SVG."""
    title = next(block.text for block in blocks if isinstance(block, Heading))
    return template_environment().get_template("document.html").render(title=title, blocks=blocks)
