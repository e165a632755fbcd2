"""Print the acceptance report: a table on a terminal, plain lines elsewhere."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from time import perf_counter
from typing import TextIO

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from lockstep.check.report.check_report import CheckReport, summary
from lockstep.check.report.finding import Finding, Status
from lockstep.standard_streams import LINE_INTERVAL, printable, unfiltered

_STYLES: dict[Status, str] = {
    "pass": "green",
    "info": "cyan",
    "warning": "yellow",
    "error": "bold red",
    "skipped": "dim",
}
_SHOWN = 12  # details of a finding; those of the contract are all shown

Listener = Callable[[Finding], None]


def print_report(report: CheckReport, stream: TextIO | None = None) -> None:
    """Print one FMU's findings to standard output: a table on a terminal, a line a finding elsewhere."""
    stream = stream or sys.stdout
    console = Console(file=unfiltered(stream))
    title = f"{report.file}: {summary(report)}"
    if not console.is_terminal:
        print(printable(title), file=stream)
        for line in plain_lines(report):
            print(printable(line), file=stream)
        return
    table = Table(title=escape(printable(title)), title_justify="left", box=SIMPLE_HEAD)
    table.add_column("check", no_wrap=True)
    table.add_column("status", no_wrap=True)
    table.add_column("finding")
    for finding in report.findings:
        text = "\n".join([finding.message or finding.title, *_shown(finding)])
        style = _STYLES[finding.status]
        table.add_row(finding.check, f"[{style}]{finding.status}[/]", escape(printable(text, keep="\n")))
    console.print(table)


def plain_lines(report: CheckReport) -> list[str]:
    """Return the findings as lines: status, check, message, and details below."""
    lines = []
    for finding in report.findings:
        lines.append(f"  {finding.status:8} {finding.check:24} {finding.message or finding.title}")
        lines += [f"  {'':33} {detail}" for detail in _shown(finding)]
    return lines


def _shown(finding: Finding) -> list[str]:
    details = list(finding.details)
    if finding.group == "contract" or len(details) <= _SHOWN:
        return details
    return [*details[: _SHOWN - 1], f"and {len(details) - _SHOWN + 1} lines more, which --html and --json show"]


@contextmanager
def show_checks(title: str, stream: TextIO | None = None) -> Iterator[Listener]:
    """Yield a function that takes each finding as it is made, and shows the progress on standard error."""
    stream = stream or sys.stderr
    console = Console(file=unfiltered(stream))
    if console.is_terminal:
        with console.status(escape(printable(title))) as status:
            count = 0

            def show(finding: Finding) -> None:
                nonlocal count
                count += 1
                status.update(f"{escape(printable(title))}: {count} checks done, last {finding.check}")

            yield show
        return
    yield _Lines(printable(title), stream)


class _Lines:
    """Prints a line every few seconds, so that a log shows progress."""

    def __init__(self, title: str, stream: TextIO) -> None:
        self._title, self._stream = title, stream
        self._count, self._next = 0, perf_counter() + LINE_INTERVAL

    def __call__(self, finding: Finding) -> None:
        self._count += 1
        if perf_counter() < self._next:
            return
        self._next = perf_counter() + LINE_INTERVAL
        print(f"{self._title}: {self._count} checks done, last {finding.check}", file=self._stream, flush=True)
