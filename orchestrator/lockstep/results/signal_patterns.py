"""Select the outputs to record."""

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from lockstep.array_names import in_order, name_and_arrays
from lockstep.errors import InputError, compact, suggestion
from lockstep.fmi.model_description import Description, Variable
from lockstep.system.system import System


@dataclass(frozen=True, slots=True, kw_only=True)
class Signal:
    """One output to record."""

    component: str
    variable: Variable

    @property
    def name(self) -> str:
        """The name of its column."""
        return f"{self.component}.{self.variable.name}"


def select(system: System, descriptions: Mapping[str, Description], patterns: Iterable[str]) -> tuple[Signal, ...]:
    """Return the outputs that match any pattern, in the order of the system.

    In a pattern `*` and `?` are wildcards and brackets are literal; `all` is every output; the name of an array is
    all its elements.
    """
    outputs = [
        Signal(component=c.name, variable=variable)
        for c in system.components
        for variable in descriptions[c.name].variables.values()
        if variable.causality == "output" and variable.scalar is not None
    ]
    names = [signal.name for signal in outputs]
    chosen: set[str] = set()
    for pattern in patterns:
        if pattern == "all":
            chosen.update(names)
            continue
        matched = matching(pattern, names)
        if not matched:
            raise InputError(
                f"record {pattern!r} matches no output; there are {compact(names)}{suggestion(pattern, names)}"
            )
        chosen.update(matched)
    return tuple(signal for signal in outputs if signal.name in chosen)


def matching(pattern: str, names: Iterable[str]) -> list[str]:
    """Return the names that a pattern means, elements of an array in the order of their indices."""
    expression = "".join({"*": ".*", "?": "."}.get(letter, re.escape(letter)) for letter in pattern)
    rule = re.compile(expression)
    return in_order(name for name in names if any(map(rule.fullmatch, name_and_arrays(name))))
