"""Show the progress of `probe-latency`, which runs in the process of the FMU."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from threading import Event, Thread

from lockstep.standard_streams import LINE_INTERVAL, printable, unfiltered


@contextmanager
def show_probing(title: str) -> Iterator[ProbeProgress]:
    """Yield what `probe_latency` calls with the file of its progress."""
    watch = ProbeProgress(title)
    try:
        yield watch
    finally:
        watch.close()


class ProbeProgress:
    """Print the progress that the process of the FMU writes to a file: one line of a terminal, several elsewhere."""

    def __init__(self, title: str) -> None:
        self._title = printable(title)
        self._stream = unfiltered(sys.stderr)
        self._terminal = self._stream.isatty()
        self._end = Event()
        self._thread: Thread | None = None

    def __call__(self, file: Path) -> None:
        """Start to read a file again and again."""
        self._thread = Thread(target=self._read, args=(file,), daemon=True)
        self._thread.start()

    def _read(self, file: Path) -> None:
        shown = ""
        while not self._end.wait(0.2 if self._terminal else LINE_INTERVAL):
            with suppress(OSError, UnicodeDecodeError):
                text = file.read_text(encoding="utf-8")
                if text != shown:
                    shown = text
                    line = f"{self._title}: {printable(text)}"
                    print(f"\r\x1b[K{line}" if self._terminal else line, end="" if self._terminal else "\n",
                          file=self._stream, flush=True)  # fmt: skip

    def close(self) -> None:
        """Stop, and leave a clean line."""
        self._end.set()
        if self._thread is not None:
            self._thread.join()
            if self._terminal:
                print("\r\x1b[K", end="", file=self._stream, flush=True)
