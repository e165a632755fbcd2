"""The command `flexsat export-c`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, cast

import click

from lockstep.cli.command import command
from lockstep.cli.options import out_option
from lockstep.cli.outcome import wrote
from lockstep.cli.parameter_types import OneOf

from .options import fmus_option, spacecraft_option

if TYPE_CHECKING:
    from flexsat.controller_weights import ControllerDesign
    from flexsat.fmu.embedded.header import Precision

COMPONENTS = ("controller",)  # the plant and the sensors are hardware
DESIGNS = ("robust", "published")  # as in flexsat.parameters, which the help does not wait for
PRECISIONS = ("double", "float")  # as in flexsat.fmu.embedded.header

_EXAMPLES = """
example:
  {program} export-c controller --configuration distributed --precision float --out flight
"""


@command("export-c", _EXAMPLES, then="make -C {path}    # compiles the example of its use")
@click.argument("component", type=OneOf(COMPONENTS), metavar="COMPONENT", help="controller")
@spacecraft_option
@click.option("--design", type=OneOf(DESIGNS), default=DESIGNS[0], metavar="NAME",
              help="gains: robust or published (default: robust)")  # fmt: skip
@click.option("--precision", type=OneOf(PRECISIONS), default=PRECISIONS[0], metavar="KIND",
              help="floating-point type of a step: double or float (default: double)")  # fmt: skip
@out_option("folder for a folder NAME of each configuration", default="flight")
@fmus_option
def export_c(
    component: str,  # noqa: ARG001 (there is one)
    configuration: tuple[str, ...],
    design: str,
    precision: str,
    out: Path,
    fmus: Path,
) -> int:
    """Write the flight controller alone as C99 with five functions, for flight software: without FMI, heap or files."""
    from ..loop.chosen_spacecraft import choose
    from ..loop.exported_controller import export_controller

    for spacecraft in choose(configuration, fmus):
        name, folder = spacecraft.name, out / spacecraft.name
        written = export_controller(
            spacecraft.root, name, cast("ControllerDesign", design), cast("Precision", precision), folder
        )
        print(f"{written} files; interface in flexsat_controller.h, use in README.md:")
        wrote(folder)
    return 0
