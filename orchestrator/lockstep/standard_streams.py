"""Standard output and standard error of a program: open, in any encoding, and without control characters of others.

Names, descriptions and log messages of FMUs and systems reach both. Whatever is printed while `standard_streams` is
active passes through `PlainStream`; what draws bars and colours on a terminal takes `unfiltered(stream)`, and passes
the texts of others through `printable` itself.
"""

from __future__ import annotations

import errno
import os
import sys
import unicodedata
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Any, TextIO

LINE_INTERVAL = 5.0  # [s] of wall time between two lines of progress where there is no terminal
_CONTROLS = {"Cc", "Cf", "Cs", "Zl", "Zp"}  # of Unicode: they act on a terminal, reverse the text, or break the line


class StreamError(Exception):
    """Standard output cannot be written: its reader is gone, or its disk is full.

    No OSError: whoever catches one around a `print` expects that of a file.
    """

    def __init__(self, error: OSError) -> None:
        super().__init__(f"standard output: {error.strerror or error}")
        self.reader_is_gone = error.errno == errno.EPIPE


def printable(text: str, keep: str = "") -> str:
    r"""Return a text with its control characters, other than those to keep, as escapes of TOML: \u001b."""
    if text.isprintable():  # nearly all
        return text
    return "".join(c if c in keep or unicodedata.category(c) not in _CONTROLS else _escape(c) for c in text)


def _escape(character: str) -> str:
    number = ord(character)
    return f"\\u{number:04x}" if number < 0x10000 else f"\\U{number:08x}"


class PlainStream:
    """A text stream that escapes control characters, and characters that its encoding lacks.

    Parameters
    ----------
    stream : to write to
    required : whether a failure to write is an error, StreamError; otherwise the text is lost
    filtered : whether to escape control characters
    """

    def __init__(self, stream: TextIO, *, required: bool, filtered: bool = True) -> None:
        self._stream, self._required, self._filtered = stream, required, filtered

    def write(self, text: str) -> int:
        """Write a text."""
        shown = printable(text, keep="\n\t") if self._filtered else text
        encoding = self._stream.encoding or "utf-8"
        with self._failures():
            self._stream.write(shown.encode(encoding, "backslashreplace").decode(encoding))
        return len(text)

    def flush(self) -> None:
        """Write what is buffered."""
        with self._failures():
            self._stream.flush()

    def unfiltered(self) -> PlainStream:
        """Return the same stream without the filter of control characters."""
        return PlainStream(self._stream, required=self._required, filtered=False)

    @contextmanager
    def _failures(self) -> Iterator[None]:
        try:
            yield
        except OSError as error:
            _discard(self._stream)
            if self._required:
                raise StreamError(error) from None

    def __getattr__(self, name: str) -> Any:
        """Return whatever else the stream has."""
        return getattr(self._stream, name)


def unfiltered(stream: TextIO) -> TextIO:
    """Return a stream that passes control characters: for bars and tables of a terminal."""
    return stream.unfiltered() if isinstance(stream, PlainStream) else stream  # type: ignore[return-value]


@contextmanager
def standard_streams() -> Iterator[None]:
    """Make both streams usable in this block, whatever the program was started with.

    A file that is opened while standard output is closed would become standard output: an FMU that prints would write
    into the results. So closed descriptors are opened first.
    """
    _open_closed_descriptors()
    before = sys.stdout, sys.stderr
    for name, number in (("stdout", 1), ("stderr", 2)):
        if getattr(sys, name) is None:
            # not closed at its end: the descriptor stays open as long as the process lives
            setattr(sys, name, os.fdopen(number, "w", encoding="utf-8", closefd=False))
    opened = sys.stdout, sys.stderr
    sys.stdout = PlainStream(opened[0], required=True)
    sys.stderr = PlainStream(opened[1], required=False)
    try:
        yield
    finally:
        sys.stdout, sys.stderr = (new if old is None else old for old, new in zip(before, opened, strict=True))


def _open_closed_descriptors() -> None:
    """Open descriptors 0 to 2 that are closed, on the null device: the system gives the lowest free number."""
    while (number := os.open(os.devnull, os.O_RDWR)) <= 2:
        os.set_inheritable(number, True)  # programs that this one starts need them as much
    os.close(number)


def _discard(stream: TextIO) -> None:
    """Write what is left of a stream to nowhere: the interpreter would report the same error again at its end."""
    with suppress(OSError, ValueError):
        number = os.open(os.devnull, os.O_WRONLY)
        os.dup2(number, stream.fileno())
        os.close(number)
