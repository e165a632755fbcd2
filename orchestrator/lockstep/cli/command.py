"""One command of a program: options with any number of values, examples in the help, and `--traceback`."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

import click

from lockstep.cli.outcome import json_option, reported
from lockstep.cli.parameter_types import SEPARATOR, Several
from lockstep.cli.usage_errors import option_name, with_option_named
from lockstep.errors import InputError

HELP_SETTINGS: dict[str, Any] = {"help_option_names": ["-h", "--help"], "max_content_width": 110}
_TRACEBACK = "lockstep.traceback"  # key of a context's `meta`
_NUMBER = re.compile(r"-\.?\d")  # a value that begins with a dash


class Command(click.Command):
    """A command whose epilog is printed as it is, and some of whose options take values up to the next option."""

    then: str | None = None  # what to do next

    def invoke(self, ctx: click.Context) -> Any:
        """Run the command, say what to do next, write what `--json` asks for; return the exit code."""
        with reported(ctx, self.then) as codes:
            try:
                found = super().invoke(ctx)
            except InputError as error:
                message = with_option_named(str(error), ctx)
                if message == str(error):
                    raise
                raise InputError(message) from error
            codes.append(found if isinstance(found, int) else 0)
        return found

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Parse the command line of the command, or raise UsageError."""
        rest = super().parse_args(ctx, self._joined(ctx, args))
        if rest and not ctx.resilient_parsing:
            raise click.UsageError(f"'{rest[0]}': one argument too many", ctx)
        return rest

    def _joined(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Return the arguments with the values of each option of type `Several` as one argument.

        An option whose value was forgotten does not take the next option for it.
        """
        options = {name: parameter for parameter in self.get_params(ctx) for name in parameter.opts
                   if isinstance(parameter, click.Option) and not parameter.is_flag}  # fmt: skip
        known = {name for parameter in self.get_params(ctx) for name in parameter.opts}
        joined: list[str] = []
        words = list(args)
        while words:
            word = words.pop(0)
            joined.append(word)
            if word == "--":
                return joined + words
            option = options.get(word)
            if option is None:
                continue
            values: list[str] = []
            count = None if isinstance(option.type, Several) else option.nargs
            while words and len(values) != count:
                if words[0].partition("=")[0] in known or (count is None and _is_option(words[0])):
                    break
                values.append(words.pop(0))
            if not values or (count is not None and len(values) < count):
                wanted = "a value" if count in (None, 1) else f"{count} values"
                follows = f", but {words[0]} follows" if words else ""
                raise click.UsageError(f"{option_name(option)}: needs {wanted}{follows}", ctx)
            joined += [SEPARATOR.join(values)] if count is None else values
        return joined

    def format_epilog(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the examples, and what else explains the command, as they are."""
        write_epilog(self.epilog, ctx, formatter)


def command(
    name: str, epilog: str, *, then: str | None = None, tables: bool = False
) -> Callable[[Callable[..., int]], Command]:
    """Return a decorator that makes a command of a function, whose docstring is the help.

    Parameters
    ----------
    name : as the user writes it
    epilog : examples and notes that follow the options, as they are; `{program}` is the name of the program
    then : what to do next, shown on a terminal after a success; `{program}`, `{path}`, which was written first, and
        the names of parameters are filled in, and where one has no value nothing is printed
    tables : whether it has the option `--json` for its tables
    """

    def decorate(function: Callable[..., int]) -> Command:
        made = click.command(name, cls=Command, epilog=epilog, context_settings=_SETTINGS)(function)
        made.then = then
        made.params += [json_option()] * tables + [traceback_option()]
        return made

    return decorate


_SETTINGS = HELP_SETTINGS | {"allow_extra_args": True}  # Command refuses them, in our words


def traceback_option() -> click.Option:
    """Return the option that asks for a traceback of whatever ends the program."""

    def remember(context: click.Context, _: click.Parameter, asked: bool) -> None:
        context.meta[_TRACEBACK] = asked or traceback_asked(context)

    return click.Option(["--traceback"], is_flag=True, expose_value=False, is_eager=True, callback=remember,
                        help="show where in the program an error occurred")  # fmt: skip


def traceback_asked(context: click.Context) -> bool:
    """Return whether `--traceback` was given, to the program or to its command."""
    return bool(context.meta.get(_TRACEBACK))


def write_epilog(epilog: str | None, context: click.Context, formatter: click.HelpFormatter) -> None:
    """Write examples and notes without wrapping them."""
    if epilog:
        program = context.find_root().info_name or ""
        formatter.write(f"\n{epilog.strip().replace('{program}', program)}\n")


def _is_option(word: str) -> bool:
    return len(word) > 1 and word.startswith("-") and _NUMBER.match(word) is None
