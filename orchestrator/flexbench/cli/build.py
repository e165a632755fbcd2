"""The command `flexsat build`."""

from __future__ import annotations

from pathlib import Path
from time import perf_counter

import click

from lockstep.cli.command import command
from lockstep.cli.options import out_option

from .options import configuration_option, configurations

_EXAMPLES = """
examples:
  {program} build
  {program} build --configuration distributed --flat --out fmus
"""


@command("build", _EXAMPLES)
@configuration_option
@out_option("folder to fill", default="fmus")
@click.option("--flat", is_flag=True, help="also with flat variable names such as wheel_torque_1, into DIR/NAME/flat")
@click.option(
    "--needs-execution-tool",
    "execution_tool",
    is_flag=True,
    help='declare needsExecutionTool="true", to warn receivers of Python; some hosts refuse such FMUs',
)
@click.option(
    "--fmi3", is_flag=True, help="also FMUs of FMI 3.0 in C, with arrays as variables, in DIR/NAME/native/fmi3"
)
@click.option("--no-native", is_flag=True, help="without the FMUs in C, which need no Python, in DIR/NAME/native")
def build(
    configuration: tuple[str, ...], out: Path, flat: bool, execution_tool: bool, fmi3: bool, no_native: bool
) -> int:
    """Build the FMUs, system files, packages and the interface document of each configuration."""
    from ..loop.build import build_all

    started = perf_counter()
    build_all(
        configurations(configuration), out, flat=flat, execution_tool=execution_tool, native=not no_native, fmi3=fmi3
    )
    print(f"built in {perf_counter() - started:.1f} s")
    return 0
