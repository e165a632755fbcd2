"""Write an error for the log of a host: one line if it explains itself, else with the traceback."""

from __future__ import annotations

import traceback


def reason_of(call: str, error: BaseException, brief: bool) -> str:
    """Return the failed call and the error in one line; `brief` leaves out the type of the error."""
    return f"{call}: {error}" if brief else f"{call}: {type(error).__name__}: {error}"


def log_text(call: str, error: BaseException, brief: bool) -> str:
    """Return the text for the log: the reason, and the traceback unless `brief`."""
    reason = reason_of(call, error, brief)
    return reason if brief else f"{reason}\n{''.join(traceback.format_exception(error))}"


def printf_safe(text: str) -> str:
    """Return a text as a printf format that prints it; the wrapper encodes it without error handling."""
    return text.replace("\0", "").encode("utf-8", "backslashreplace").decode("utf-8").replace("%", "%%")
