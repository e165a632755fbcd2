"""What a command came to: tables, remarks and written files, for readers and with `--json`; and what to do next.

A command prints its results with `show_table`, `remark` and `wrote`; what they print is collected for `--json`. A
result that is printed in a form of its own, such as a timeline, is collected by `keep_table`. What to do next is the
parameter `then` of `@command`, one text a command, unless the command calls `suggest`.
"""

from __future__ import annotations

import json
import shlex
import shutil
import sys
import textwrap
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, redirect_stdout, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TextIO

import click

from lockstep.cli.parameter_types import PATH
from lockstep.cli.print_table import print_table
from lockstep.errors import InputError
from lockstep.whole_file import write_whole

FORMAT = 1  # of the JSON; raised when a reader of the old one would fail
PRINTED = Path("-")  # of --json: standard output
_KEY = "lockstep.outcome"  # of a context's `meta`
_JSON = "lockstep.json"
_COMMENT = "    # "  # between a command and what it does, in the line of what to do next
_HELP = "write the printed tables and the written files as JSON; - prints it"


@dataclass(slots=True)
class PrintedOutput:
    """What a command has printed so far."""

    tables: list[dict[str, Any]] = field(default_factory=list)
    remarks: list[str] = field(default_factory=list)
    files: list[str] = field(default_factory=list)
    suggestion: str | None = None  # instead of the command's `then`

    def as_json(self, command: str, code: int, then: str | None) -> str:
        """Return it as JSON, described in docs/commands.md."""
        content = {
            "format": FORMAT,
            "command": command,
            "exit_code": code,
            "tables": self.tables,
            "remarks": self.remarks,
            "files": self.files,
            "next": then,
        }
        return json.dumps(content, indent=1, ensure_ascii=False, allow_nan=False) + "\n"


def json_path_option(text: str = _HELP) -> Callable[[Any], Any]:
    """Return the option `--json` of a command that writes numbers of its own format; it gets the path."""
    return click.option("--json", type=PATH, metavar="FILE", callback=_checked, help=text)


def json_option() -> click.Option:
    """Return the option `--json` of a command whose tables are collected."""

    def remember(context: click.Context, parameter: click.Parameter, path: Path | None) -> None:
        context.meta[_JSON] = _checked(context, parameter, path)

    return click.Option(["--json"], type=PATH, metavar="FILE", expose_value=False, callback=remember, help=_HELP)


def show_table(header: Sequence[str], rows: Iterable[Sequence[str]], title: str = "") -> None:
    """Print a table, below its title if it has one, and keep it for `--json`."""
    table = [tuple(row) for row in rows]
    _current().tables.append(
        {"title": title, "columns": list(header), "rows": [[_value(cell) for cell in row] for row in table]}
    )
    if title:
        print(title)
    print_table(header, table)


def remark(*texts: str) -> None:
    """Print sentences about the results, wrapped between words on a terminal, and keep them for `--json`."""
    _current().remarks.extend(texts)
    _print_sentences(texts, sys.stdout)


def note(*texts: str) -> None:
    """Print sentences that are no results to standard error, wrapped between words on a terminal."""
    _print_sentences(texts, sys.stderr)


def _print_sentences(texts: Iterable[str], stream: TextIO) -> None:
    from rich.console import Console
    from rich.markup import escape

    from lockstep.standard_streams import printable, unfiltered

    console = Console(file=unfiltered(stream), highlight=False, emoji=False)
    for text in texts:
        if console.is_terminal:
            console.print(escape(printable(text, keep="\n")))
        else:
            print(text, file=stream)


def print_lines(lines: Iterable[str]) -> None:
    """Print lines of a result in a form of its own; on a terminal, what is longer than its width continues indented."""
    width = shutil.get_terminal_size().columns if sys.stdout.isatty() else None
    for line in lines:
        if width is None or len(line) <= width:
            print(line)
            continue
        indent = " " * (len(line) - len(line.lstrip()) + 4)
        print("\n".join(textwrap.wrap(line, width, subsequent_indent=indent, break_long_words=False,
                                      break_on_hyphens=False)))  # fmt: skip


def wrote(*paths: Path | str) -> None:
    """Print the paths of what was written, a line each, and keep them; the first is `{path}` in `then`."""
    keep(*paths)
    for path in paths:
        print(path, flush=True)


def keep_table(header: Sequence[str], rows: Iterable[Sequence[Any]], title: str) -> None:
    """Keep a table for `--json` whose content some other text has printed; numbers keep all their digits."""
    _current().tables.append(
        {"title": title, "columns": list(header), "rows": [[_plain(value) for value in row] for row in rows]}
    )


def keep(*paths: Path | str) -> None:
    """Keep the paths of what was written, which some other line has printed."""
    _current().files.extend(map(str, paths))


def suggest(then: str) -> None:
    """Set what to do next, as `then` of `@command`, where it depends on what was found."""
    _current().suggestion = then


@contextmanager
def reported(context: click.Context, then: str | None) -> Iterator[list[int]]:
    """Collect what the command of a context prints; it appends its exit code to the list.

    At the end the line of what to do next goes to standard error if that is a terminal, as progress bars do, and the
    JSON where `--json` says. If that is standard output, everything else goes to standard error.
    """
    kept = PrintedOutput()
    context.meta[_KEY] = kept
    path: Path | None = context.meta.get(_JSON)
    codes: list[int] = []
    output = sys.stdout
    with redirect_stdout(sys.stderr if path == PRINTED else output):
        yield codes
    code = codes[-1] if codes else 0
    line = None if code else _filled(kept.suggestion or then, context, kept)
    if path is not None:
        _write(kept.as_json(context.command_path, code, line), path, output)
    if line and on_terminal():
        output.flush()  # before the line that is about it
        print(_within(f"next: {line}", shutil.get_terminal_size().columns), file=sys.stderr)


def _within(line: str, width: int) -> str:
    """Return a command with its comment on a line of its own where both do not fit the width."""
    command, mark, comment = line.partition(_COMMENT)
    return line if len(line) <= width or not mark else f"{command}\n      # {comment}"


def on_terminal() -> bool:
    """Return whether a user sees standard error at once: logs and scripts need no hint."""
    return sys.stderr.isatty()


def _current() -> PrintedOutput:
    context = click.get_current_context(silent=True)
    found = None if context is None else context.meta.get(_KEY)
    return (
        found if isinstance(found, PrintedOutput) else PrintedOutput()
    )  # called outside a command: nothing to keep it for


def _filled(then: str | None, context: click.Context, kept: PrintedOutput) -> str | None:
    """Return a text with what it names: the program, the path written first, parameters; None if one has no value."""
    if then is None:
        return None
    given: Mapping[str, Any] = {name: _shown(value) for name, value in context.params.items() if value is not None}
    names = {"program": context.find_root().info_name, **given}
    if kept.files:
        names["path"] = shlex.quote(kept.files[0])
    with suppress(KeyError, IndexError, ValueError):  # also braces in a path
        return then.format_map(names)
    return None


def _shown(value: Any) -> Any:
    if isinstance(value, Path | str):
        return shlex.quote(str(value))
    return tuple(map(_shown, value)) if isinstance(value, tuple) else value


def _value(cell: str) -> str | float | None:
    """Return a cell as a number if it is one, None if it is empty."""
    text = cell.strip()
    if text in ("", "-"):
        return None
    for kind in (int, float):
        with suppress(ValueError):
            number = kind(text)
            return number if abs(number) < float("inf") else text
    return text


def _plain(value: Any) -> str | float | bool | None:
    """Return a value as JSON has it: what is not finite as text, what is no number as its text."""
    if value is None or isinstance(value, str | bool | int):
        return value
    if isinstance(value, float):  # also one of numpy
        return float(value) if abs(value) < float("inf") else str(float(value))
    return str(value)


def _checked(context: click.Context, parameter: click.Parameter, path: Path | None) -> Path | None:  # noqa: ARG001
    """Refuse a file that cannot be written, before the command takes its time."""
    if path is None or path == PRINTED:
        return path
    if path.is_dir():
        raise InputError(f"--json {path}: is a folder; give the name of a file, or - to print")
    if not path.absolute().parent.is_dir():
        raise InputError(f"--json {path}: there is no folder {path.parent}; make it, or give another name")
    return path


def _write(text: str, path: Path, output: TextIO) -> None:
    if path == PRINTED:
        output.write(text)
        return
    try:
        write_whole(path, text.encode())
    except OSError as error:
        raise InputError(f"--json {path}: cannot be written ({error.strerror or error})") from None
