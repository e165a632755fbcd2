"""The command `flexsat new`."""

from __future__ import annotations

from pathlib import Path

import click

from lockstep.cli.command import command
from lockstep.cli.outcome import wrote
from lockstep.cli.parameter_types import PATH

_EXAMPLES = """
example:
  {program} new my.toml
  {program} spacecraft my.toml
  {program} build my.toml
"""


@command("new", _EXAMPLES, then="change the file, then {program} spacecraft {file}; {program} build {file}")
@click.argument("file", type=PATH, metavar="FILE", help="file to write, such as my.toml; its name is the spacecraft's")
def new(file: Path) -> int:
    """Write a commented spacecraft file as a start: four wheels in a pyramid, two gyros."""
    from ...loop.spacecraft import write_start

    write_start(file)
    wrote(file)
    return 0
