"""Write numbers and lists of them as C."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator

import numpy as np

from ...arrays import Array

WIDTH = 118  # characters of a line
_INDENT = "   "
_LINE = re.compile(rf".{{1,{WIDTH - len(_INDENT)}}}(?= |$)")  # as many words as it has room for


def double_text(value: float) -> str:
    """Return a double as an exact C constant, as short as it can be."""
    if value == 0.0:
        return "0.0" if not np.signbit(value) else "-0.0"
    mantissa, _, exponent = value.hex().partition("p")
    mantissa = mantissa.rstrip("0") if "." in mantissa else mantissa
    return f"{mantissa}p{int(exponent)}"


def wrapped(words: Iterable[str]) -> Iterator[str]:
    """Yield lines of words with commas."""
    line = _INDENT
    for word in words:
        if len(line) + len(word) + 2 > WIDTH:
            yield line
            line = _INDENT
        line += f" {word},"
    yield line


def wrapped_doubles(values: Array) -> list[str]:
    """Return the same lines as `wrapped` of each value's `double_text`, in less time: matrices have a million numbers.

    Raises
    ------
    ValueError
        If there are none, or one is not finite, which C has no constant for.
    """
    if not (values.size and np.isfinite(values).all()):
        raise ValueError(f"values of a C array must be finite, and at least one, got {values}")
    text = f" {', '.join(map(float.hex, values.ravel().tolist()))},"
    text = text.replace("0x0.0p+0", "0.0").replace("p+", "p")
    return [f"{_INDENT}{line}" for line in _LINE.findall(re.sub("0+p", "p", text))]
