"""The command `check`: its options, and what it does with them."""

from __future__ import annotations

import argparse
import os
from collections.abc import Callable, Sequence
from pathlib import Path

from lockstep.check.check_fmu import check_fmu
from lockstep.check.contract import Contract, named
from lockstep.check.report.check_report import CheckReport, as_json, as_junit, fails, write_text
from lockstep.check.report.report_html import as_html
from lockstep.check.report.report_text import print_report, show_checks
from lockstep.check.static.fmu_archive import read_archive
from lockstep.errors import InputError

EXIT_CODES = "exit code: 0 no error, 1 an error (with --strict also a warning), 2 bad input such as a missing file"

_NEIGHBOURS = 2  # FMUs of the same call that each is loaded beside: more would cost time and tell little


def add_check_options(parser: argparse.ArgumentParser) -> None:
    """Add the options that every `check` command has."""
    parser.add_argument(
        "fmus",
        nargs="+",
        type=Path,
        metavar="FMU",
        help="co-simulation FMUs of any maker (FMI 1.0 and 3.0: fewer checks); several are also loaded side by side",
    )
    parser.add_argument("--static", action="store_true", help="only look at the file; do not run it")
    parser.add_argument("--strict", action="store_true", help="warnings fail too")
    parser.add_argument("--html", type=Path, metavar="FILE", help="write the report as one HTML page")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the report as JSON")
    parser.add_argument(
        "--junit", type=Path, metavar="FILE", help="write the report as JUnit XML, a test case a finding"
    )


def check_as_told(options: argparse.Namespace, contracts: Callable[[], Sequence[Contract]] = tuple) -> int:
    """Check every FMU, print a report of each, write the files asked for; return the exit code.

    Bad input is refused before any check begins: they may take minutes.
    """
    outputs = {"--html": options.html, "--json": options.json, "--junit": options.junit}
    _refuse(options.fmus, outputs)
    like: str | None = getattr(options, "like", None)
    offered = contracts()
    if like is not None:
        named(offered, like)
    reports: list[CheckReport] = []
    for path in options.fmus:
        with show_checks(str(path)) as progress:
            others = [other for other in options.fmus if other.resolve() != path.resolve()][:_NEIGHBOURS]
            found = check_fmu(
                path, dynamic=not options.static, contracts=offered, like=like, others=others, report=progress
            )
        print_report(found)
        reports.append(found)
        _write(outputs, reports, options.strict)  # after each: what is done survives an interruption
    return 1 if fails(reports, options.strict) else 0


def _refuse(paths: Sequence[Path], outputs: dict[str, Path | None]) -> None:
    for path in paths:
        read_archive(path)
    inputs = {path.resolve() for path in paths}
    for option, output in outputs.items():
        if output is None:
            continue
        if output.is_dir():
            raise InputError(f"{option} {output}: is a folder; give the name of a file")
        if output.resolve() in inputs:
            raise InputError(f"{option} {output}: is one of the FMUs; give another name")
        _refuse_folder(option, output)
    given = [output.resolve() for output in outputs.values() if output is not None]
    if len(set(given)) < len(given):
        raise InputError(f"{' and '.join(o for o, p in outputs.items() if p)}: the same file; give each its own name")


def _refuse_folder(option: str, output: Path) -> None:
    """Find out now whether a report can be written, not after minutes of checks."""
    try:
        output.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{option} {output}: cannot be written ({error.strerror})") from None
    if not os.access(output.parent, os.W_OK):
        raise InputError(f"{option} {output}: cannot be written ({output.parent} is read-only)")


def _write(outputs: dict[str, Path | None], reports: Sequence[CheckReport], strict: bool) -> None:
    html, json, junit = outputs["--html"], outputs["--json"], outputs["--junit"]
    if html is not None:
        write_text(html, as_html(reports))
    if json is not None:
        write_text(json, as_json(reports))
    if junit is not None:
        write_text(junit, as_junit(reports, strict))
