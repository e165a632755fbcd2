"""The command `flexsat adapt`."""

from __future__ import annotations

from pathlib import Path

import click

from lockstep.cli.command import command
from lockstep.cli.options import out_option
from lockstep.cli.outcome import note, wrote
from lockstep.cli.parameter_types import PATH
from lockstep.errors import InputError

_EXAMPLES = """
example:
  {program} adapt vendor.fmu --like controller --out vendor.toml
"""


@command("adapt", _EXAMPLES, then="{program} check-adapter {fmu} --adapter {out}    # after editing what is undecided")
@click.argument("fmu", type=PATH, metavar="FMU", help="the foreign FMU")
@click.option("--like", required=True, metavar="NAME",
              help="the component that it is to replace: controller, plant or sensors, or controller:distributed, "
                   "controller:fmus/my and so on")  # fmt: skip
@out_option("file to write (default: print it)", metavar="FILE")
def adapt(fmu: Path, like: str, out: Path | None) -> int:
    """Draft the adapter of a foreign FMU from names, units and array sizes, and list the open decisions."""
    from lockstep.whole_file import write_whole

    from ..adapt.draft import draft_for

    if not fmu.is_file():
        raise InputError(f"{fmu}: {'is no file' if fmu.exists() else 'no such file'}; give the path of an .fmu file")
    text, doubts = draft_for(fmu, like)
    if out is None:
        print(text, end="")
    else:
        write_whole(out, text.encode())
        wrote(out)
    for doubt in doubts:
        note(f"undecided: {doubt}")
    return 0
