"""Find the components that a name, or a pattern with the wildcards `*` and `?`, means."""

import re
from collections.abc import Mapping, Sequence
from typing import TypeVar

from lockstep.errors import InputError, compact, suggestion

Given = TypeVar("Given")


def is_pattern(text: str) -> bool:
    """Return whether a text has wildcards."""
    return "*" in text or "?" in text


def matches(pattern: str, name: str) -> bool:
    """Return whether a name is the one given, or one that a pattern means."""
    expression = "".join({"*": ".*", "?": "."}.get(letter, re.escape(letter)) for letter in pattern)
    return re.fullmatch(expression, name) is not None


def named(pattern: str, names: Sequence[str], what: str = "") -> list[str]:
    """Return the names that a name or pattern means; InputError, which begins with `what`, if there are none."""
    found = [name for name in names if matches(pattern, name)]
    if not found:
        there = f"there are {compact(names)}{suggestion(pattern, names)}"
        raise InputError(f"{what}{pattern}: no such component; {there}")
    return found


def given_for(name: str, given: Mapping[str, Given], option: str) -> Given | None:
    """Return what is given for a name itself, else for a pattern that means it; InputError if two patterns differ."""
    if name in given:
        return given[name]
    found = {pattern: value for pattern, value in given.items() if is_pattern(pattern) and matches(pattern, name)}
    if len(set(found.values())) > 1:
        raise InputError(f"{name}: {option} is given by {' and by '.join(found)}; give it for {name} itself as well")
    return next(iter(found.values()), None)
