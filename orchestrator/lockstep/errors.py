"""Two exception classes, for bad input and for a failed run, and the format of names in messages."""

import difflib
import os
import sys
from collections.abc import Iterable

from lockstep.array_names import in_order, split_element, stem


class InputError(ValueError):
    """Refuse bad input: one line that names the thing, the wrong value and the remedy (exit code 2)."""


class RunError(RuntimeError):
    """End a run that had started: one line that names the component and the simulated time (exit code 1)."""


class EndOfSimulation(RunError):
    """End a run regularly, as a component asks for it: after its step, or before that, if it is not complete."""

    def __init__(self, text: str, component: str, complete: bool) -> None:
        super().__init__(text)
        self.component, self.complete = component, complete


def refuse_undecodable(path: str | os.PathLike[str], what: str = "") -> None:
    """Raise InputError for a path whose bytes are no UTF-8 text; `what` comes before it in the message."""
    try:
        os.fspath(path).encode("utf-8")
    except UnicodeEncodeError:
        name = os.fsencode(path)
    else:
        return
    shown = f"{what}{repr(name)[1:]}"
    try:
        name.decode("utf-8")
    except UnicodeDecodeError:
        raise InputError(f"{shown}: holds bytes that are not UTF-8, which records cannot name; rename it") from None
    encoding = sys.getfilesystemencoding()
    raise InputError(f"{shown}: the encoding of file names is {encoding} here; set LC_ALL=C.UTF-8") from None


def compact(names: Iterable[str], limit: int = 12) -> str:
    """Print names with their array elements folded: `rate[1..3], energy`."""
    runs: list[tuple[str, int, int] | str] = []
    for name in in_order(names):
        base, indices = split_element(name)
        if len(indices) != 1:
            runs.append(name)
            continue
        index = indices[0]
        last = runs[-1] if runs else None
        if isinstance(last, tuple) and last[0] == base and last[2] == index - 1:
            runs[-1] = (base, last[1], index)
        else:
            runs.append((base, index, index))
    texts = [run if isinstance(run, str) else _run_text(*run) for run in runs]
    if len(texts) > limit:
        texts = [*texts[:limit], f"and {len(texts) - limit} more"]
    return ", ".join(texts) or "none"


def suggestion(name: str, names: Iterable[str]) -> str:
    """Return `; did you mean ...?` with the nearest name, or nothing when none is near."""
    array = stem(name)
    # elements of one array differ in their index only: compare those first, or the hint is a far name
    candidates = [other for other in names if stem(other) != array]
    near = difflib.get_close_matches(name, candidates, n=1, cutoff=0.7)
    return f"; did you mean {near[0]}?" if near else ""


def siblings(name: str, names: Iterable[str]) -> list[str]:
    """Return the elements of the array that `name` belongs to, or every name when there are none."""
    every = list(names)
    array = stem(name)
    same = [other for other in every if stem(other) == array]
    return same or every


def _run_text(base: str, first: int, last: int) -> str:
    return f"{base}[{first}]" if first == last else f"{base}[{first}..{last}]"
