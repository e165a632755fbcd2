"""Fill the templates of an FMU's documentation: HTML with every text escaped, plain text as it is."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined, select_autoescape

FOLDER = Path(__file__).with_name("templates")


@cache
def _environment() -> Environment:
    environment = Environment(
        loader=FileSystemLoader(FOLDER),
        autoescape=select_autoescape(("html",)),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    environment.filters["anchor"] = lambda name: name.lower().replace(" ", "-")
    return environment


def fill(template: str, **values: Any) -> bytes:
    """Return a template of this folder with its values filled in, in UTF-8; a missing value is an error."""
    return _environment().get_template(template).render(values).encode()
