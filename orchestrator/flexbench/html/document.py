"""A document of headings, paragraphs and tables, written as Markdown or as one HTML page."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from html import escape
from typing import Literal


@dataclass(frozen=True, slots=True)
class Heading:
    """A heading; level 1 is the title."""

    level: Literal[1, 2, 3]
    text: str


@dataclass(frozen=True, slots=True)
class Paragraph:
    """Plain text; names between backticks."""

    text: str


@dataclass(frozen=True, slots=True)
class Listing:
    """Text whose line breaks and blanks matter."""

    text: str


@dataclass(frozen=True, slots=True)
class Table:
    """A table; cells of `code` columns are names."""

    header: Sequence[str]
    rows: Sequence[Sequence[str]]
    code: frozenset[int] = frozenset({0})


@dataclass(frozen=True, slots=True)
class Picture:
    """An SVG image: inline in HTML, a file beside the document for Markdown."""

    svg: str
    file: str
    description: str


CODE, _CODE_TAG = re.compile(r"`([^`]+)`"), r"<code>\1</code>"  # as in Markdown
Block = Heading | Paragraph | Listing | Table | Picture

_STYLE = """
body { font: 15px/1.5 system-ui, sans-serif; max-width: 1200px; margin: 2em auto; padding: 0 1em; color: #222; }
h2 { margin-top: 2em; border-bottom: 1px solid #ccc; }
div.table { overflow-x: auto; }
table { border-collapse: collapse; font-size: 13px; }
th, td { border: 1px solid #ccc; padding: 3px 7px; text-align: left; vertical-align: top; }
th { background: #eef2f6; }
code, pre { font-family: ui-monospace, monospace; font-size: 12.5px; }
pre { background: #f6f6f6; padding: 0.8em; overflow-x: auto; }
svg { max-width: 100%; height: auto; }
"""


def as_markdown(blocks: Sequence[Block]) -> str:
    """Write the document as Markdown; pictures are referred to by their file names."""
    parts = []
    for block in blocks:
        match block:
            case Heading(level, text):
                parts.append(f"{'#' * level} {text}")
            case Paragraph(text):
                parts.append(text)
            case Listing(text):
                parts.append(f"```text\n{text}\n```")
            case Picture(_, file, description):
                parts.append(f"![{description}]({file})")
            case Table(header, rows, code):
                lines = [f"| {' | '.join(header)} |", "|" + "---|" * len(header)]
                lines += [f"| {' | '.join(_cell(text, i in code) for i, text in enumerate(row))} |" for row in rows]
                parts.append("\n".join(lines))
    return "\n\n".join(parts) + "\n"


def _cell(text: str, code: bool) -> str:
    text = text.replace("|", "\\|")
    return f"`{text}`" if code and text else text


def as_html(blocks: Sequence[Block]) -> str:
    """Write the document as one page that needs no network."""
    title = next(block.text for block in blocks if isinstance(block, Heading))
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{escape(title)}</title>\n<style>{_STYLE}</style>\n</head>\n<body>\n{body_html(blocks)}\n</body>\n</html>\n"
    )


def body_html(blocks: Sequence[Block], draw: Callable[[Picture], str] = lambda picture: picture.svg) -> str:
    """Write blocks as part of a page; `draw` says how a picture stands in it."""
    parts = []
    for block in blocks:
        match block:
            case Heading(level, text):
                parts.append(f"<h{level}>{escape(text)}</h{level}>")
            case Paragraph(text):
                parts.append(f"<p>{CODE.sub(_CODE_TAG, escape(text))}</p>")
            case Listing(text):
                parts.append(f"<pre>{escape(text)}</pre>")
            case Picture():
                parts.append(draw(block))
            case Table(header, rows, code):
                parts.append(_html_table(header, rows, code))
    return "\n".join(parts)


def _html_table(header: Sequence[str], rows: Sequence[Sequence[str]], code: frozenset[int]) -> str:
    head = "".join(f"<th>{escape(text)}</th>" for text in header)
    lines = []
    for row in rows:
        cells = (
            f"<td><code>{escape(text)}</code></td>" if i in code and text else f"<td>{escape(text)}</td>"
            for i, text in enumerate(row)
        )
        lines.append(f"<tr>{''.join(cells)}</tr>")
    body = "\n".join(lines)
    return f'<div class="table"><table>\n<thead><tr>{head}</tr></thead>\n<tbody>\n{body}\n</tbody>\n</table></div>'
