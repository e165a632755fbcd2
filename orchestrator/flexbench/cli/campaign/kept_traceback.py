"""Keep the traceback of an unexpected error in a campaign's folder: standard error may reach nobody after hours."""

from __future__ import annotations

import sys
import traceback
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from lockstep.errors import InputError, RunError
from lockstep.standard_streams import StreamError

NAME = "traceback.txt"
_EXPECTED = (InputError, RunError, OSError, StreamError, MemoryError)  # one line says what they are


@contextmanager
def kept_traceback(folder: Path) -> Iterator[None]:
    """Write the traceback of an unexpected error into a folder; remove that of an earlier call if there is none."""
    try:
        yield
    except Exception as error:
        if not isinstance(error, _EXPECTED):
            with suppress(OSError):
                folder.mkdir(parents=True, exist_ok=True)
                text = "".join(traceback.format_exception(error))
                (folder / NAME).write_text(text, encoding="utf-8", errors="backslashreplace")
                print(f"{folder / NAME}: traceback of the error", file=sys.stderr)
            from ...engine.fingerprint import code_changed

            if code_changed():  # an update while it ran: modules that are imported late do not fit
                raise RunError(f"the code of flexsat has changed while {folder} was simulated ({error}); restore it and"
                               " give the same command again, or give another folder") from error  # fmt: skip
        raise
    (folder / NAME).unlink(missing_ok=True)
