"""Find flags whose values keep the outputs of an FMU from answering: a mode off, a measurement not valid."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from itertools import combinations, product

from lockstep.check.dynamic.experiment import Experiment, Port

Flags = Mapping[str, float]
MOST_FLAGS = 6
MOST_TRIALS = 48  # each is a process of its own, of about half a second
_SILENT = 0.5  # share of the Real inputs without an answer, from which flags are looked for
_VALUES = (1.0, 2.0, 3.0)  # of an Integer


def silent(inputs: Sequence[Port], unmoved: Sequence[str]) -> bool:
    """Return whether so few Real inputs have an answer that a flag may block it."""
    reals = [port.name for port in inputs if port.kind == "Real"]
    return bool(reals) and len(set(reals) & set(unmoved)) > _SILENT * len(reals)


def blocking_flags(experiment: Experiment, given: Sequence[str], answers: Callable[[Flags], int], before: int) -> Flags:
    """Return values of flags with which more inputs have an answer; the fewest flags, none if there are none.

    Parameters
    ----------
    experiment : of the FMU, with the start values that its flags had
    given : inputs whose value the user chose
    answers : how many pairs of output and input answer with these values
    before : that number with the start values
    """
    flags = [port for port in experiment.inputs if port.kind in ("Boolean", "Integer") and port.name not in given]
    if not 0 < len(flags) <= MOST_FLAGS:
        return {}
    best: Flags = {}
    most, trials = before, 0
    for size in (1, 1, 1, 2):  # flag after flag while one helps; two at once where no single one does
        if size == 2 and best:
            break
        rest = [port for port in flags if port.name not in best]
        found = best
        for ports in combinations(rest, size):
            for values in product(*map(_others, ports)):
                trial = {**best, **dict(zip([port.name for port in ports], values, strict=True))}
                trials += 1
                count = answers(trial) if trials <= MOST_TRIALS else 0
                if count > most:
                    found, most = trial, count
        best = found
    return best


def _others(port: Port) -> list[float]:
    if port.kind == "Boolean":
        return [1.0 - port.start]
    return [value for value in _VALUES if port.minimum <= value <= port.maximum and value != port.start]
