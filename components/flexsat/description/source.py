"""The text of a spacecraft's file, and refusals that name its line, key, value and remedy."""

from __future__ import annotations

import difflib
import tomllib
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, NoReturn

from ..errors import SpacecraftFileError
from .lines import Key, line_of

LONGEST_VALUE = 60  # characters of a wrong value in a message


@dataclass(frozen=True, slots=True, kw_only=True)
class Source:
    """A file: its name in messages, and its text."""

    name: str
    text: str

    def tables(self) -> dict[str, Any]:
        """Return what the text holds; raise SpacecraftFileError if it is not TOML."""
        try:
            return tomllib.loads(self.text)
        except tomllib.TOMLDecodeError as error:
            raise SpacecraftFileError(f"{self.name}: not TOML: {error}") from None

    def refuse(self, keys: Sequence[Key], message: str, value: Any = None) -> NoReturn:
        """Raise SpacecraftFileError with the line of a key, the key, its value if it is given, and a message."""
        shown = "" if value is None else f" = {_shortened(value)}"
        known = next((line for n in range(len(keys), 0, -1) if (line := line_of(self.text, keys[:n]))), None)
        where = self.name if known is None else f"{self.name}:{known}"
        raise SpacecraftFileError(f"{where}: {key_text(keys)}{shown}: {message}")

    def check_keys(self, table: Any, keys: Sequence[Key], known: Iterable[str]) -> None:
        """Refuse what is no table, and keys that are not among the known ones."""
        names = list(known)
        if not isinstance(table, dict):
            self.refuse(keys, f"must be a table with keys such as {names[0]}", table)
        for key in table:
            if key not in names:
                where = f" of {key_text(keys)}" if keys else ""
                self.refuse([*keys, key], f"no such key{where}; there are {', '.join(names)}{meant(key, names)}")


def meant(word: str, known: Iterable[str]) -> str:
    """Return the end of a message that names what was probably meant, or nothing."""
    found = difflib.get_close_matches(word, list(known), 1)
    return f"; did you mean {found[0]}?" if found else ""


def key_text(keys: Sequence[Key]) -> str:
    """Return keys as a reader writes them: wheels[2].axes; places count from 1."""
    text = ""
    for key in keys:
        text += f"[{key + 1}]" if isinstance(key, int) else f".{key}" if text else key
    return text


def _shortened(value: Any) -> str:
    text = f'"{value}"' if isinstance(value, str) else str(value).lower() if isinstance(value, bool) else repr(value)
    return text if len(text) <= LONGEST_VALUE else f"{text[: LONGEST_VALUE - 3]}..."
