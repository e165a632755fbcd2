"""The command `flexsat spacecraft`."""

from __future__ import annotations

from pathlib import Path

import click

from lockstep.cli.command import command
from lockstep.cli.parameter_types import COUNT
from lockstep.cli.print_table import print_table
from lockstep.errors import InputError

_EXAMPLES = """
examples:
  {program} spacecraft my.toml
  {program} spacecraft distributed --list-modes 40
  {program} spacecraft centralised --file
"""


@command("spacecraft", _EXAMPLES)
@click.argument("spacecraft", metavar="SPACECRAFT", help="a spacecraft's file, or the name of a built-in one")
@click.option("--list-modes", "modes", type=COUNT, default=12, metavar="N", help="modes to list (default: 12)")
@click.option("--file", "show_file", is_flag=True, help="print the file itself")
def spacecraft(spacecraft: str, modes: int, show_file: bool) -> int:
    """Show mass, modes and how wheels and gyros reach them, nominal wheel speeds, torque and momentum envelopes."""
    from flexsat.description.built_in import CONFIGURATIONS, built_in

    from ...loop.properties import MODES_HEADER, mode_rows, properties_of, property_lines
    from ...loop.spacecraft import read_file

    if spacecraft not in CONFIGURATIONS and not Path(spacecraft).is_file():
        known = ", ".join(CONFIGURATIONS)
        raise InputError(
            f"{spacecraft}: no such file, and no built-in spacecraft ({known}); `flexsat new` writes a file"
        )
    given = built_in(spacecraft) if spacecraft in CONFIGURATIONS else read_file(Path(spacecraft))
    if show_file:
        print(given.text, end="")
        return 0
    found = properties_of(given, spacecraft)
    print("\n".join(property_lines(found)))
    print_table(MODES_HEADER, mode_rows(found, modes))
    return 0
