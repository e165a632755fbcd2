"""Write numbers and lists of them as C."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np

WIDTH = 118  # characters of a line


def double_text(value: float) -> str:
    """Return a double as an exact C constant, as short as it can be."""
    if value == 0.0:
        return "0.0" if not np.signbit(value) else "-0.0"
    mantissa, _, exponent = value.hex().partition("p")
    mantissa = mantissa.rstrip("0") if "." in mantissa else mantissa
    return f"{mantissa}p{int(exponent)}"


def wrapped(words: Iterable[str]) -> Iterator[str]:
    """Yield lines of words with commas."""
    line = "   "
    for word in words:
        if len(line) + len(word) + 2 > WIDTH:
            yield line
            line = "   "
        line += f" {word},"
    yield line
