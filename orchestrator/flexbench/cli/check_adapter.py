"""The command `flexsat check-adapter`."""

from __future__ import annotations

import sys
from pathlib import Path

import click

from lockstep.cli.command import command
from lockstep.cli.outcome import keep, keep_table, remark
from lockstep.cli.parameter_types import PATH
from lockstep.whole_file import write_whole

_EXAMPLES = """
exit code: 0 the conventions are right, or corrected by --apply; 1 they are not; 2 bad input

examples:
  {program} check-adapter vendor.fmu --adapter vendor.toml --like controller:centralised
  {program} check-adapter vendor.fmu --adapter vendor.toml --apply    # correct vendor.toml, if one correction is right
"""
_WHY = ("no correction was found", "several corrections are right, and the measurement cannot decide between them")


@command(
    "check-adapter",
    _EXAMPLES,
    then="{program} run fmus/centralised/fine_pointing.ssd --replace controller={fmu} --adapter {adapter}",
    tables=True,
)
@click.argument("fmu", type=PATH, metavar="FMU", help="the foreign controller")
@click.option("--adapter", type=PATH, required=True, metavar="FILE", help="TOML file to check")
@click.option("--like", metavar="NAME",
              help="controller:centralised, controller:fmus/my and so on (default: what the adapter fits)")  # fmt: skip
@click.option("--apply", is_flag=True, help="write the correction into the file, if exactly one is right")
def check_adapter(fmu: Path, adapter: Path, like: str | None, apply: bool) -> int:
    """Measure a controller's static response to attitude and rate errors, and judge its adapter's conventions."""
    from lockstep.adapter.read import read_adapter

    from ..adapt.corrected_file import corrected
    from ..adapt.excitation_of_design import excitation_for
    from ..adapt.judge import AXES
    from ..adapt.verdict import check_adapter as judge
    from ..adapt.verdict_text import describe_findings, describe_response

    read = read_adapter(adapter)
    excitation = excitation_for(read, fmu, like or "controller")
    verdict = judge(fmu, read, excitation)
    title, *response = describe_response(verdict, excitation, fmu, adapter)
    remark(title)
    print("\n".join(response))
    remark(*describe_findings(verdict, fmu))
    keep_table(
        ("error", "about", *(f"torque {axis}" for axis in AXES), "judged"),
        (
            (name, axis, *map(float, shares[:, k]), measured)
            for name, shares, judged in (
                ("attitude", verdict.judgement.attitude, (True, True, True)),
                ("rate", verdict.judgement.rate, verdict.judgement.measured),
            )
            for k, (axis, measured) in enumerate(zip(AXES, judged, strict=True))
        ),
        "torque as a share of that of flexsat's LQG",
    )
    if not apply or verdict.right:
        return 0 if verdict.right else 1
    if len(verdict.cures) != 1:
        why = _WHY[bool(verdict.cures)]
        print(f"flexsat: --apply: {adapter} is unchanged: {why}; edit it by hand", file=sys.stderr)
        return 1
    changes = verdict.cures[0]
    write_whole(adapter, corrected(adapter.read_text(encoding="utf-8"), changes, str(adapter)).encode())
    remark(f"{adapter} is corrected, and the response is right with it: {', '.join(c.remedy for c in changes)}")
    keep(adapter)
    return 0
