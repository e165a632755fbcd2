"""The command `flexsat check`."""

from __future__ import annotations

import sys

import click

from lockstep.cli.check import EXIT_CODES, CheckOptions, check_fmus, check_options
from lockstep.cli.command import command
from lockstep.interrupt import exit_code

_EXAMPLES = f"""
{EXIT_CODES}

example:
  {{program}} check vendor.fmu --like controller --html report.html --junit report.xml
"""


@command("check", _EXAMPLES)
@check_options
@click.option("--like", metavar="NAME",
              help="compare its ports with controller, plant or sensors, or with controller:distributed and so on "
                   "(default: with the one it resembles)")  # fmt: skip
def check(options: CheckOptions, like: str | None) -> int:
    """Accept or refuse FMUs of any maker: the file, how it runs, and which interface ports it can serve."""
    from ..adapt.contracts import contracts

    try:
        return check_fmus(options, contracts, like)
    except KeyboardInterrupt as error:
        print("flexsat: interrupted; the reports hold the FMUs that were checked", file=sys.stderr)
        return exit_code(error)
