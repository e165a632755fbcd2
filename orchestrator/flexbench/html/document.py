"""Hold a document as blocks: headings, paragraphs, listings, tables, pictures; write it as Markdown."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True, slots=True)
class Heading:
    """A heading; level 1 is the title of the document."""

    level: Literal[1, 2, 3]
    text: str


@dataclass(frozen=True, slots=True)
class Paragraph:
    """Plain text; names stand between backticks."""

    text: str


@dataclass(frozen=True, slots=True)
class Listing:
    """Preformatted text: line breaks and spaces are kept."""

    text: str


@dataclass(frozen=True, slots=True)
class Table:
    """A table; the columns in `code` hold names."""

    header: Sequence[str]
    rows: Sequence[Sequence[str]]
    code: frozenset[int] = frozenset({0})


@dataclass(frozen=True, slots=True)
class Picture:
    """An SVG image: inline in HTML, a separate file for Markdown."""

    svg: str
    file: str
    description: str


Block = Heading | Paragraph | Listing | Table | Picture


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
