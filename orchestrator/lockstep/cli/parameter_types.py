"""Types of command-line values, whose messages name the option, the value, and what is accepted."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from pathlib import Path

import click

from lockstep.cli.usage_errors import option_name, similar

SEPARATOR = "\0"  # between the values of an option that takes several: no argument can contain it


class NamedPath(click.ParamType[Path]):
    """A file or folder. An empty text, often a variable that is not set, would be the working folder."""

    name = "path"

    def convert(self, value: object, param: click.Parameter | None, ctx: click.Context | None) -> Path:
        """Return the path, or raise UsageError."""
        if value == "":
            raise _error("is empty; give the name of a file or folder, `.` for this one", param, ctx)
        return Path(str(value))


class Number(click.ParamType[float]):
    """A finite number, in a range if one is given."""

    name = "number"

    def __init__(self, *, above: float = -math.inf, most: float = math.inf) -> None:
        self._above, self._most = above, most

    def convert(self, value: object, param: click.Parameter | None, ctx: click.Context | None) -> float:
        """Return the number, or raise UsageError."""
        try:
            number = float(str(value))
        except ValueError:
            raise _error(f"'{value}' is not a number", param, ctx) from None
        if not math.isfinite(number):
            raise _error(f"'{value}' is not a finite number", param, ctx)
        if not self._above < number <= self._most:
            accepted = f"must be > {self._above:g} and <= {self._most:.10g}"
            raise click.UsageError(f"{_name(param)} {number:g}: {accepted}", ctx)
        return number


class WholeNumber(click.ParamType[int]):
    """A whole number, in a range if one is given."""

    name = "whole number"

    def __init__(self, minimum: int | None = None, maximum: int | None = None) -> None:
        self._minimum, self._maximum = minimum, maximum

    def convert(self, value: object, param: click.Parameter | None, ctx: click.Context | None) -> int:
        """Return the number, or raise UsageError."""
        try:
            number = int(str(value))
        except ValueError:
            raise _error(f"'{value}' is not a whole number", param, ctx) from None
        if self._minimum is not None and number < self._minimum:
            raise click.UsageError(f"{_name(param)} {number}: must be {self._minimum} or more", ctx)
        if self._maximum is not None and number > self._maximum:
            raise click.UsageError(f"{_name(param)} {number}: must be {self._maximum} or less", ctx)
        return number


class OneOf(click.ParamType[str]):
    """One of a few words."""

    name = "choice"

    def __init__(self, choices: Iterable[str]) -> None:
        self.choices = tuple(choices)

    def convert(self, value: object, param: click.Parameter | None, ctx: click.Context | None) -> str:
        """Return the word, or raise UsageError."""
        if value in self.choices:
            return str(value)
        meant = similar(str(value), self.choices)
        suggestion = f"; did you mean {meant[0]}?" if meant else ""
        raise _error(f"'{value}' is none of {', '.join(self.choices)}{suggestion}", param, ctx)


class SomeOf(click.ParamType[tuple[str, ...]]):
    """Some of a few words, with commas between them; each once, in their usual order."""

    name = "choices"

    def __init__(self, choices: Iterable[str]) -> None:
        self._one = OneOf(choices)

    def convert(self, value: object, param: click.Parameter | None, ctx: click.Context | None) -> tuple[str, ...]:
        """Return the words, or raise UsageError."""
        if isinstance(value, tuple):  # the default
            return value
        given = {self._one.convert(word.strip(), param, ctx) for word in str(value).split(",")}
        return tuple(word for word in self._one.choices if word in given)


class NetworkAddress(click.ParamType[str]):
    """Host and port, after a protocol if one is given: what cannot be one is refused without waiting for an answer."""

    name = "address"

    def convert(self, value: object, param: click.Parameter | None, ctx: click.Context | None) -> str:
        """Return the address, or raise UsageError."""
        text = str(value)
        match = re.fullmatch(r"(?:[a-z]+://)?(?:\[[0-9a-fA-F:.]+\]|[^\s:/\[\]]+):([0-9]{1,5})", text)
        if match is None or not 0 < int(match[1]) < 65536:
            raise _error(f"'{text}' is no address; write for example tcp://127.0.0.1:8786", param, ctx)
        return text


class Several(click.ParamType[tuple[str | float, ...]]):
    """One value or more, up to the next option; `Command` joins them to one argument."""

    name = "values"

    def __init__(self, one: click.ParamType[str] | click.ParamType[float] = click.STRING) -> None:
        self._one = one

    def convert(
        self, value: object, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[str | float, ...]:
        """Return the values, or raise UsageError."""
        if isinstance(value, tuple):
            return value
        return tuple(self._one.convert(text, param, ctx) for text in str(value).split(SEPARATOR))


def _error(problem: str, param: click.Parameter | None, ctx: click.Context | None) -> click.UsageError:
    return click.UsageError(f"{_name(param)}: {problem}", ctx)


def _name(param: click.Parameter | None) -> str:
    return "value" if param is None else option_name(param)


PATH, NETWORK_ADDRESS = NamedPath(), NetworkAddress()
NUMBER, COUNT = Number(), WholeNumber(1, 1_000_000)
SEED = WholeNumber(0, 2**31 - 1)  # an Integer of FMI 2.0
DURATION = Number(above=0.0, most=9.2e9)  # [s]: the longest time of the master's clock
