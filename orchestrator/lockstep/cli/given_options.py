"""Refuse options of the command line that would have no effect beside others."""

from __future__ import annotations

from collections.abc import Container, Iterator

import click
from click.core import ParameterSource

from lockstep.cli.usage_errors import option_name
from lockstep.errors import InputError


def given_options() -> Iterator[click.Parameter]:
    """Yield the options and arguments of the running command that the command line gives."""
    context = click.get_current_context()
    for parameter in context.command.params:
        if context.get_parameter_source(str(parameter.name)) is ParameterSource.COMMANDLINE:
            yield parameter


def only_words(name: str, words: Container[str]) -> bool:
    """Return whether all values of an option that can be given several times are among these words."""
    values = click.get_current_context().params.get(name) or ()
    return all(value in words for value in values)


def refuse_given(names: Container[str], reason: str) -> None:
    """Raise InputError if an option or argument of one of these names is given; `reason` follows its name."""
    for parameter in given_options():
        if str(parameter.name) in names:
            raise InputError(f"{option_name(parameter)}: {reason}")
