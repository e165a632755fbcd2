"""The command `python -m lockstep check`, and what every `check` command shares."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Sequence
from contextlib import redirect_stdout
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import click

from lockstep.cli.command import command
from lockstep.cli.options import option_group
from lockstep.cli.outcome import PRINTED, wrote
from lockstep.cli.parameter_types import PATH
from lockstep.errors import InputError

if TYPE_CHECKING:
    from lockstep.check.adapted_findings import Behind
    from lockstep.check.contract import Contract
    from lockstep.check.report.check_report import CheckReport

EXIT_CODES = "exit code: 0 no error, 1 an error (with --strict also a warning), 2 bad input such as a missing file"

_EXAMPLES = f"""
{EXIT_CODES}

example:
  {{program}} check vendor.fmu --html report.html --strict
"""
_NEIGHBOURS = 2  # FMUs of the same call that each is loaded beside: more would cost time and reveal little


@dataclass(frozen=True, slots=True, kw_only=True)
class CheckOptions:
    """What to check, and the reports to write."""

    fmus: tuple[Path, ...]
    static: bool
    strict: bool
    html: Path | None
    json: Path | None
    junit: Path | None


check_options = option_group(
    "options",
    CheckOptions,
    click.argument("fmus", type=PATH, nargs=-1, required=True, metavar="FMU...",
                   help="co-simulation FMUs of any tool and any version of FMI; several are also loaded together"),
    click.option("--static", is_flag=True, help="only inspect the file; do not run it"),
    click.option("--strict", is_flag=True, help="treat warnings as errors"),
    click.option("--html", type=PATH, metavar="FILE", help="write the report as one HTML page"),
    click.option("--json", type=PATH, metavar="FILE", help="write the report as JSON; - prints it instead"),
    click.option("--junit", type=PATH, metavar="FILE", help="write the report as JUnit XML, one test case per finding"),
)  # fmt: skip


@command(
    "check",
    _EXAMPLES,
    then="{program} probe-latency {fmus[0]}    # delay and feedthrough from each input to each output",
)
@check_options
def check(options: CheckOptions) -> int:
    """Check FMUs for acceptance: the files, and how they run."""
    return check_fmus(options)


def check_fmus(
    options: CheckOptions,
    contracts: Callable[[], Sequence[Contract]] = tuple,
    like: str | None = None,
    behind: Behind | None = None,
) -> int:
    """Check every FMU, print a report of each, write the files asked for; return the exit code.

    Bad input is refused before any check begins: they may take minutes.

    Parameters
    ----------
    options : of the command line
    contracts : returns the components whose ports an FMU may have
    like : name of the component to compare with; None: the one that the FMU resembles
    behind : adapter behind which the FMUs are compared
    """
    from lockstep.check.check_fmu import check_fmu
    from lockstep.check.contract import named
    from lockstep.check.report.check_report import as_json, fails
    from lockstep.check.report.report_text import print_report, show_checks

    file = None if options.json == PRINTED else options.json
    outputs = {"--html": options.html, "--json": file, "--junit": options.junit}
    _refuse(options.fmus, outputs)
    offered = contracts()
    if like is not None:
        named(offered, like)
    reports: list[CheckReport] = []
    for path in options.fmus:
        with show_checks(str(path)) as progress:
            others = [other for other in options.fmus if other.resolve() != path.resolve()][:_NEIGHBOURS]
            found = check_fmu(
                path,
                dynamic=not options.static,
                contracts=offered,
                like=like,
                behind=behind,
                others=others,
                report=progress,
            )
        with redirect_stdout(sys.stderr if options.json == PRINTED else sys.stdout):
            print_report(found)
        reports.append(found)
        _write(outputs, reports, options.strict)  # after each: what is done survives an interruption
    if options.json == PRINTED:
        print(as_json(reports), end="")
    else:
        wrote(*(path for path in outputs.values() if path is not None))
    return 1 if fails(reports, options.strict) else 0


def _refuse(paths: Sequence[Path], outputs: dict[str, Path | None]) -> None:
    from lockstep.check.static.fmu_archive import read_archive

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
    from lockstep.check.report.check_report import as_json, as_junit, write_text
    from lockstep.check.report.report_html import as_html

    html, json, junit = outputs["--html"], outputs["--json"], outputs["--junit"]
    if html is not None:
        write_text(html, as_html(reports))
    if json is not None:
        write_text(json, as_json(reports))
    if junit is not None:
        write_text(junit, as_junit(reports, strict))
