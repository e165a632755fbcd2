"""The command `flexsat check`."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import click

from lockstep.cli.check import EXIT_CODES, CheckOptions, check_fmus, check_options
from lockstep.cli.command import command
from lockstep.cli.parameter_types import PATH
from lockstep.errors import InputError
from lockstep.interrupt import exit_code

if TYPE_CHECKING:
    from lockstep.check.adapted_findings import Behind
    from lockstep.system.adapter_file import Adapter

_EXAMPLES = f"""
{EXIT_CODES}

example:
  {{program}} check vendor.fmu --like controller --html report.html --junit report.xml
  {{program}} check vendor.fmu --like controller --adapter vendor.toml
"""


@command(
    "check",
    _EXAMPLES,
    then="{program} probe-latency {fmus[0]}    # delay and feedthrough from each input to each output",
)
@check_options
@click.option("--like", metavar="NAME",
              help="compare its ports with controller, plant or sensors, or with controller:distributed, "
                   "controller:fmus/my and so on (default: with the one it resembles)")  # fmt: skip
@click.option("--adapter", type=PATH, metavar="FILE",
              help="check the FMU with this adapter: the ports that both serve together, and a controller's "
                   "conventions, as check-adapter does")  # fmt: skip
def check(options: CheckOptions, like: str | None, adapter: Path | None) -> int:
    """Check FMUs from any tool: the file, how it runs, and which interface ports it can serve."""
    from ..adapt.contracts import contracts

    behind = None if adapter is None else _behind(adapter, options.fmus)
    try:
        return check_fmus(options, partial(contracts, like), like, behind)
    except KeyboardInterrupt as error:
        print("flexsat: interrupted; the reports hold the FMUs that were checked", file=sys.stderr)
        return exit_code(error)


def _behind(path: Path, fmus: Sequence[Path]) -> Behind:
    """Return an adapter with what judges its conventions, or raise InputError."""
    from lockstep.adapter.read import read_adapter
    from lockstep.check.adapted_findings import Behind

    from ..adapt.excitation_of_design import excitation_for
    from ..adapt.verdict import check_adapter
    from ..adapt.verdict_text import describe_verdict

    if len(fmus) > 1:
        raise InputError(f"--adapter {path}: is for one FMU, and {len(fmus)} are given; check each by itself")

    def judge(fmu: Path, adapter: Adapter, component: str) -> tuple[bool, list[str]]:
        excitation = excitation_for(adapter, fmu, component)
        verdict = check_adapter(fmu, adapter, excitation)
        return verdict.right, describe_verdict(verdict, excitation, fmu, path)

    return Behind(adapter=read_adapter(path), judge=judge)
