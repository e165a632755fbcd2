"""One line for each way to misspell a command line, with the name or value that was probably meant."""

from __future__ import annotations

import re
from collections.abc import Iterable
from difflib import get_close_matches

import click
from click.core import ParameterSource
from click.exceptions import NoSuchCommand

# options of earlier versions and their names of today, where a command has the latter and not the former
RENAMED = {
    "--stop": "--stop-time",
    "--duration": "--stop-time",
    "--step": "--step-size",
    "--period": "--step-size",
    "--hand-over": "--switchover",
    "--fresh": "--reinitialise",
    "--from": "--restart-from",
    "--to": "--format",
    "--window": "--time-range",
    "--range": "--speed-range",
    "--quiet": "--noise-free",
    "--controller-fmu": "--replace",
}


def describe_usage_error(error: click.UsageError, root: click.Context | None, commands: Iterable[str]) -> str:
    """Return what is wrong with a command line, what is accepted, and where to read more; in one line."""
    context = error.ctx or root
    problem = _problem(error, context, list(commands))
    return problem if context is None else f"{problem}; see `{context.command_path} --help`"


def option_name(parameter: click.Parameter) -> str:
    """Return the name of an option, or of an argument, as a user writes it."""
    return max(parameter.opts, key=len) if isinstance(parameter, click.Option) else parameter.human_readable_name


def with_option_named(message: str, context: click.Context) -> str:
    """Return the message of an error that says `NAME: no such ...`, with the option that gave the name before it.

    What looks names up does not know which option they come from: it may be any, or a file.
    """
    before, found, _ = message.partition(": no such ")
    if not found:
        return message
    name = before.rpartition(": ")[2]
    given = {
        (option_name(parameter), text)
        for parameter in context.command.params
        if isinstance(parameter, click.Option)
        and context.get_parameter_source(str(parameter.name)) is ParameterSource.COMMANDLINE
        for text in _texts(context.params.get(str(parameter.name)))
        if name == text or (name in re.split("[=:.]", text) and "." not in name)  # C.P=V: the message has all of C.P
    }
    if len(given) != 1:  # none, or it may be either
        return message
    option, text = given.pop()
    shown = f"{option} {text or repr(text)}"
    return f"{shown}{message[len(name) :]}" if before == name == text else f"{shown}: {message}"


def _texts(value: object) -> Iterable[str]:
    """Return the texts given for an option: none, one, or those of a list."""
    if isinstance(value, str):
        return [value]
    return [text for one in value for text in _texts(one)] if isinstance(value, tuple) else []


def similar(name: str, names: Iterable[str]) -> list[str]:
    """Return the names that begin with a name, or else the one that is spelled most like it."""
    known = list(names)
    begin = [other for other in known if len(name) > 3 and other.startswith(name)]
    return sorted(begin) or get_close_matches(name, known, n=1)


def _problem(error: click.UsageError, context: click.Context | None, commands: list[str]) -> str:
    if isinstance(error, NoSuchCommand):
        meant = similar(error.command_name, commands)
        choices = f"choose from {', '.join(commands)}"
        return f"'{error.command_name}': no such command; {_suggestion(meant) or choices}"
    if isinstance(error, click.NoSuchOption):
        return _unknown_option(error.option_name, context)
    if isinstance(error, click.BadOptionUsage):  # the only kind that `Command` leaves to click
        return f"{error.option_name}: takes no value"
    if isinstance(error, click.MissingParameter) and error.param is not None:
        return f"{option_name(error.param)}: missing"
    if isinstance(error, click.BadParameter) and error.param is not None:
        return f"{option_name(error.param)}: {error.message.rstrip('.')}"
    if error.message == "Missing command.":
        return "COMMAND: missing"
    return error.format_message().rstrip(".")


def _unknown_option(name: str, context: click.Context | None) -> str:
    known = [] if context is None else _long_options(context.command, context)
    if RENAMED.get(name) in known:
        return f"{name} is now {RENAMED[name]}"
    meant = similar(name, known)
    return f"{name}: no such option" + (f"; {_suggestion(meant)}" if meant else "")


def _long_options(command: click.Command, context: click.Context) -> list[str]:
    return [name for parameter in command.get_params(context) for name in parameter.opts if name.startswith("--")]


def _suggestion(names: list[str]) -> str:
    return f"did you mean {' or '.join(names)}?" if names else ""
