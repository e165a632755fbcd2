"""Links from a page to files of the repository that are no pages: the README is a page, others are named."""

import os
import re
from pathlib import Path
from typing import Any

from sphinx.application import Sphinx

_LINK = re.compile(r"\[([^\]]*)\]\((\.\./[^)#\s]+)(#[^)\s]+)?\)")
_CODE = re.compile(r"(^```.*?^```)", re.DOTALL | re.MULTILINE)


def rewrite(text: str) -> str:
    """Return a page whose links to the README lead to its page; other files are named with their path."""

    def replaced(found: re.Match[str]) -> str:
        words, target, anchor = found[1], found[2].removeprefix("../"), found[3] or ""
        return f"[{words}](reference/readme.md{anchor})" if target == "README.md" else f"{words} (`{target}`)"

    return "".join(part if part.startswith("```") else _LINK.sub(replaced, part) for part in _CODE.split(text))


def readme(root: Path) -> str:
    """Return the README as a page in docs/reference/, with the links that it then needs."""
    text = (root / "README.md").read_text(encoding="utf-8").replace("](docs/", "](../")
    text = re.sub(r"\[[^\]]*\]\(([A-Z]+\.\w+)\)", r"`\1`", text)  # files at the top, which are no pages
    return re.sub(r"\]\((orchestrator|components|examples)/", r"](../../\1/", text)


def _on_read(_: Sphinx, _name: str, content: list[str]) -> None:
    content[0] = rewrite(content[0])


def setup(app: Sphinx) -> dict[str, Any]:
    """Register with Sphinx."""
    source = Path(app.srcdir)
    page = source / "reference" / "readme.md"
    page.parent.mkdir(exist_ok=True)
    page.write_text(readme(source.parent), encoding="utf-8")
    app.connect("source-read", _on_read)
    return {"parallel_read_safe": os.name == "posix"}
