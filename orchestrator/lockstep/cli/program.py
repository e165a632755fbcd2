"""Programs whose commands are imported when they are called; every error becomes one line and an exit code."""

from __future__ import annotations

import sys
import traceback
from collections.abc import Mapping, Sequence
from contextlib import suppress
from importlib import import_module
from pathlib import Path

import click

from lockstep.cli.command import HELP_SETTINGS, traceback_asked, traceback_option, write_epilog
from lockstep.cli.usage_errors import describe_usage_error
from lockstep.errors import InputError, RunError, refuse_undecodable
from lockstep.interrupt import Stopped, ended_by_signals, exit_code
from lockstep.processes.cpu_affinity import own_thread
from lockstep.standard_streams import StreamError, standard_streams
from lockstep.version import VERSION

BUG = 70  # exit code of an error of the program itself: EX_SOFTWARE of sysexits.h


class CommandGroup(click.Group):
    """A group of commands, each in a module of its own that is imported when the command is called.

    A module holds its command under its own name: `lockstep.cli.write_ssp` has the command `write_ssp`.
    """

    def __init__(
        self,
        name: str,
        commands: Mapping[str, tuple[str, str]],
        *,
        label: str,
        description: str,
        epilog: str,
        interrupted: str = "interrupted",
    ) -> None:
        """Make a program.

        Parameters
        ----------
        name : as it is called, `python -m lockstep`
        commands : module and one line of help of each command, in the order of the help
        label : what each message on standard error begins with
        description, epilog : of the help; `{program}` in the epilog is the name
        interrupted : message after Ctrl-C
        """
        super().__init__(
            name,
            help=description,
            epilog=epilog,
            params=[_version_option(name), traceback_option()],
            context_settings=HELP_SETTINGS,
            no_args_is_help=False,
            subcommand_metavar="COMMAND ...",
        )
        self._modules = dict(commands)
        self._label, self._interrupted = label, interrupted

    def list_commands(self, ctx: click.Context) -> list[str]:  # noqa: ARG002
        """Return the names of all commands."""
        return list(self._modules)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:  # noqa: ARG002
        """Import a command; None if there is no such command."""
        if cmd_name not in self._modules:
            return None
        module = self._modules[cmd_name][0]
        found: click.Command = getattr(import_module(module), module.rpartition(".")[2])
        return found

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Find the command that the arguments name, or raise NoSuchCommand with those there are."""
        name = args[0]
        command = self.get_command(ctx, name)
        if command is None:
            raise click.exceptions.NoSuchCommand(name, possibilities=self._modules, ctx=ctx)
        return name, command, args[1:]

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:  # noqa: ARG002
        """List the commands without importing them."""
        with formatter.section("Commands"):
            formatter.write_dl([(name, text) for name, (_, text) in self._modules.items()])

    def format_epilog(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the examples as they are."""
        write_epilog(self.epilog, ctx, formatter)

    def run(self, arguments: Sequence[str] | None = None) -> int:
        """Run a command and return the exit code.

        0, 1 failed run, 2 bad input, 70 a bug of the program, 130 Ctrl-C, 143 SIGTERM, 129 SIGHUP.

        An error is one line on standard error, after a traceback if `--traceback` asks for one.
        """
        words = list(sys.argv[1:] if arguments is None else arguments)
        with standard_streams():
            code = self._run(words)
            with suppress(StreamError):
                sys.stdout.flush()
            return code

    def _run(self, words: list[str]) -> int:
        context: click.Context | None = None
        try:
            _refuse_paths(words)
            with ended_by_signals(), own_thread(), self.make_context(self.name, words) as context:
                code = int(self.invoke(context) or 0)
                sys.stdout.flush()  # here, where a reader that is gone is no error
                return code
        except click.exceptions.Exit as end:
            return int(end.exit_code)
        except (Exception, KeyboardInterrupt) as error:
            if isinstance(error, StreamError) and error.reader_is_gone:
                return 1
            if context is not None and traceback_asked(context):
                traceback.print_exception(error)
            code, message = self._describe(error, context)
        print(f"{self._label}: {' '.join(message.split())}", file=sys.stderr)
        return code

    def _describe(self, error: BaseException, context: click.Context | None) -> tuple[int, str]:
        """Return the exit code and the message of an error."""
        if isinstance(error, click.UsageError):
            return 2, describe_usage_error(error, context, self._modules)
        if isinstance(error, RunError | StreamError):
            return 1, str(error)
        if isinstance(error, InputError):
            return 2, str(error)
        if isinstance(error, KeyboardInterrupt):
            code = exit_code(error)
            by = f"interrupted by {error.name}" if isinstance(error, Stopped) else "interrupted"
            return code, self._interrupted.replace("interrupted", by, 1)
        if isinstance(error, OSError):
            return 1, f"{error.filename or 'system'}: {error.strerror or error}"
        if isinstance(error, MemoryError):
            return 1, "out of memory; use a shorter run or fewer recorded signals, or a machine with more"
        what = f"{type(error).__name__}: {error}".strip().removesuffix(":")
        return BUG, (
            f"{what}: this is a bug of {self._label}, not of the input; please report it with the command line, "
            "the input files and what the same command prints with --traceback"
        )


def _version_option(program: str) -> click.Option:
    """Return the option that prints the version of the distribution, which both programs come from."""

    def show(context: click.Context, _: click.Parameter, asked: bool) -> None:
        if asked and not context.resilient_parsing:
            click.echo(f"{program} {VERSION}")
            context.exit()

    return click.Option(["--version"], is_flag=True, expose_value=False, is_eager=True, callback=show,
                        help="print the version and exit")  # fmt: skip


def _refuse_paths(words: Sequence[str]) -> None:
    """Refuse arguments, and a working folder, whose bytes are no text: paths are written to records and reports."""
    for word in words:
        refuse_undecodable(word)
    try:
        folder = Path.cwd()
    except OSError as error:
        raise InputError(f"the working folder: {error.strerror}; change to a folder that exists") from None
    refuse_undecodable(folder, "the working folder ")
