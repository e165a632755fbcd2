"""The command `flexsat check-adapter`."""

from __future__ import annotations

from pathlib import Path

import click

from lockstep.cli.command import command
from lockstep.cli.outcome import keep_table, remark
from lockstep.cli.parameter_types import PATH

_EXAMPLES = """
exit code: 0 the conventions are right, 1 they are not, 2 bad input

example:
  {program} check-adapter vendor.fmu --adapter vendor.toml --like controller:centralised
"""


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
def check_adapter(fmu: Path, adapter: Path, like: str | None) -> int:
    """Measure a controller's static response to attitude and rate errors, and judge its adapter's conventions."""
    from lockstep.adapter.read import read_adapter

    from ..adapt.excitation_of_design import excitation_for
    from ..adapt.judge import AXES
    from ..adapt.verdict import check_adapter as judge
    from ..adapt.verdict_text import describe_findings, describe_response

    read = read_adapter(adapter)
    excitation = excitation_for(read, fmu, like or "controller")
    verdict = judge(fmu, read, excitation)
    print("\n".join(describe_response(verdict, excitation, fmu, adapter)))
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
    return 0 if verdict.right else 1
