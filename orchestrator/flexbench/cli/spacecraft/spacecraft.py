"""The command `flexsat spacecraft`."""

from __future__ import annotations

from pathlib import Path

import click

from lockstep.cli.command import command
from lockstep.cli.outcome import remark, show_table, suggest, wrote
from lockstep.cli.parameter_types import COUNT, PATH
from lockstep.errors import InputError

_EXAMPLES = """
examples:
  {program} spacecraft my.toml
  {program} spacecraft distributed --list-modes 40
  {program} spacecraft centralised --file
  {program} spacecraft my.toml --draw my.svg
  {program} spacecraft --schema
"""
FORMATS = (".png", ".svg")  # of figures


@command("spacecraft", _EXAMPLES, then="{program} build {spacecraft}    # its FMUs and systems", tables=True)
@click.argument(
    "spacecraft", required=False, metavar="[SPACECRAFT]", help="a spacecraft's file, or the name of a built-in one"
)
@click.option("--list-modes", "modes", type=COUNT, default=12, metavar="N", help="modes to list (default: 12)")
@click.option("--file", "show_file", is_flag=True, help="print the spacecraft file")
@click.option("--schema", "show_schema", is_flag=True, help="print all keys of a file: units, defaults, ranges")
@click.option(
    "--draw", "drawing", type=PATH, metavar="FILE", help="draw wheels, envelopes and modes, to a file .png or .svg"
)
def spacecraft(spacecraft: str | None, modes: int, show_file: bool, show_schema: bool, drawing: Path | None) -> int:
    """Show mass, modes and their coupling to wheels and gyros, nominal wheel speeds, torque and momentum envelopes."""
    from flexsat.description.built_in import CONFIGURATIONS, built_in
    from flexsat.description.schema import schema_markdown

    from ...loop.properties import MODES_HEADER, mode_rows, properties_of, property_lines
    from ...loop.spacecraft import read_file

    if show_schema:
        print(schema_markdown(), end="")
        return 0
    if spacecraft is None:
        raise InputError("SPACECRAFT is missing: a spacecraft's file, or the name of a built-in one; or give --schema")
    if drawing is not None and drawing.suffix not in FORMATS:
        raise InputError(f"--draw {drawing}: a figure is written to a file that ends in {' or '.join(FORMATS)}")
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
    remark(*property_lines(found))
    show_table(MODES_HEADER, mode_rows(found, modes))
    if drawing is not None:
        from ...figures.drawing import write_figure
        from ...figures.spacecraft import spacecraft_figure

        write_figure(spacecraft_figure(found), drawing)
        wrote(drawing)
    if spacecraft in CONFIGURATIONS:
        suggest("{program} build --configuration {spacecraft}    # its FMUs and systems")
    return 0
