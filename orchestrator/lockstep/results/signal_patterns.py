"""Select the variables to record."""

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

from lockstep.array_names import in_order, name_and_arrays
from lockstep.errors import InputError, compact, suggestion
from lockstep.fmi.model_description import Description, Variable
from lockstep.system.name_patterns import is_pattern
from lockstep.system.system import System

ALL = "all"
_KINDS = {  # causalities by the word before the colon of a pattern
    "outputs": ("output",),
    "inputs": ("input",),
    "locals": ("local",),
    "parameters": ("parameter", "calculatedParameter", "structuralParameter"),
}
_HELD = (*_KINDS["inputs"], *_KINDS["parameters"])


@dataclass(frozen=True, slots=True, kw_only=True)
class Signal:
    """One variable to record."""

    component: str
    variable: Variable

    @property
    def name(self) -> str:
        """The name of its column."""
        return f"{self.component}.{self.variable.name}"

    @property
    def held(self) -> bool:
        """Whether a step takes it at its start and keeps it: an input or a parameter."""
        return self.variable.causality in _HELD


class _Names:
    """Signals by name, and by the arrays that they are elements of."""

    def __init__(self, signals: Sequence[Signal]) -> None:
        self.names = {signal.name: signal for signal in signals}

    @cached_property
    def _found(self) -> dict[str, list[str]]:
        found: dict[str, list[str]] = {}
        for name in self.names:
            for one in name_and_arrays(name):
                found.setdefault(one, []).append(name)
        return found

    def matching(self, pattern: str) -> list[str]:
        if pattern == ALL:
            return list(self.names)
        if not is_pattern(pattern):
            return self._found.get(pattern, [])
        return matching(pattern, self.names)


def select(system: System, descriptions: Mapping[str, Description], patterns: Iterable[str]) -> tuple[Signal, ...]:
    """Return the variables that match any pattern: outputs and locals in the order of the system, then those held.

    In a pattern `*` and `?` are wildcards and brackets are literal; the name of an array is all its elements. A pattern
    means outputs, and where none matches other variables; after `inputs:`, `locals:` or `parameters:` it means these.
    `all` is every output, or every local of a system without outputs.
    """
    every = [
        Signal(component=c.name, variable=variable)
        for c in system.components
        for variable in descriptions[c.name].variables.values()
        if variable.scalar is not None
    ]
    known: dict[tuple[str, ...], _Names] = {}

    def named(*causalities: str) -> _Names:
        if causalities not in known:
            known[causalities] = _Names([s for s in every if not causalities or s.variable.causality in causalities])
        return known[causalities]

    outputs = named(*_KINDS["outputs"])
    chosen: set[str] = set()
    for pattern in patterns:
        if pattern == ALL:
            chosen.update(outputs.names or named(*_KINDS["locals"]).names)
            continue
        kind, rest = split_kind(pattern)
        matched = named(*_KINDS[kind]).matching(rest) if kind else outputs.matching(rest) or named().matching(rest)
        if not matched:
            there = named(*_KINDS[kind or "outputs"]).names
            near = suggestion(rest, there if kind else named().names)
            raise InputError(
                f"record {pattern!r} matches no {kind or 'output or other variable'}; there are {compact(there)}{near}"
            )
        chosen.update(matched)
    found = (signal for signal in every if signal.name in chosen)
    return tuple(sorted(found, key=lambda signal: signal.held))


def split_kind(pattern: str) -> tuple[str, str]:
    """Return the kind of variables before the colon of a pattern, "" if there is none, and the rest."""
    kind, colon, rest = pattern.partition(":")
    return (kind, rest) if colon and kind in _KINDS else ("", pattern)


def matching(pattern: str, names: Iterable[str]) -> list[str]:
    """Return the names that a pattern means, elements of an array in the order of their indices."""
    expression = "".join({"*": ".*", "?": "."}.get(letter, re.escape(letter)) for letter in pattern)
    rule = re.compile(expression)
    return in_order(name for name in names if any(map(rule.fullmatch, name_and_arrays(name))))
