"""The command `flexsat build`."""

from __future__ import annotations

from pathlib import Path
from time import perf_counter

import click

from lockstep.cli.command import command
from lockstep.cli.options import out_option
from lockstep.cli.outcome import remark, suggest
from lockstep.cli.parameter_types import PATH, SomeOf
from lockstep.errors import InputError

from .options import configurations, spacecraft_option

ALL = "all"
PLATFORMS = ("linux64", "win64", "aarch64-linux", "darwin64")  # as in flexsat.fmu.native.platforms

_EXAMPLES = """
examples:
  {program} build
  {program} build --configuration distributed --flat --out fmus
  {program} build my.toml
  {program} build --platforms linux64,win64
"""


@command("build", _EXAMPLES)
@click.argument(
    "files", type=PATH, nargs=-1, metavar="[FILE...]", help="spacecraft files (default: the built-in spacecraft)"
)
@spacecraft_option
@out_option("folder to fill", default="fmus")
@click.option(
    "--flat", is_flag=True, help="also write FMUs with flat variable names such as wheel_torque_1, in DIR/NAME/flat"
)
@click.option(
    "--needs-execution-tool",
    "execution_tool",
    is_flag=True,
    help='declare needsExecutionTool="true", to warn receivers that Python is needed; some hosts refuse such FMUs',
)
@click.option(
    "--fmi3", is_flag=True, help="also write FMUs of FMI 3.0 in C, with arrays as variables, in DIR/NAME/native/fmi3"
)
@click.option(
    "--platforms",
    type=SomeOf((ALL, *PLATFORMS)),
    default=(),
    metavar="NAMES",
    help=f"platforms of the FMUs in C, compiled with Zig: {', '.join(PLATFORMS)}, or all, separated by commas "
    "(default: linux64, with this machine's compiler)",
)
@click.option(
    "--missions",
    is_flag=True,
    help="also write environment, thrusters, mission manager and their systems, in DIR/NAME/missions",
)
@click.option("--no-native", is_flag=True, help="omit the FMUs in C, which need no Python, in DIR/NAME/native")
def build(
    files: tuple[Path, ...],
    configuration: tuple[str, ...],
    out: Path,
    flat: bool,
    execution_tool: bool,
    fmi3: bool,
    platforms: tuple[str, ...],
    missions: bool,
    no_native: bool,
) -> int:
    """Build the FMUs, system files, packages and the interface document of each configuration, or spacecraft's file."""
    from ..loop.build import build_all, build_files
    from ..loop.build_manifest import earlier_folders
    from ..loop.build_options import BuildOptions
    from ..studies.margins.design_notes import design_notes

    if platforms and no_native and not fmi3:
        raise InputError("--platforms concerns the FMUs in C, which --no-native omits; leave out one of the two")
    if files and configuration:
        raise InputError("--configuration chooses among the built-in spacecraft; leave out it or the files")
    started = perf_counter()
    options = BuildOptions(
        in_c=(*(() if no_native else ("2.0",)), *(("3.0",) if fmi3 else ())),
        platforms=PLATFORMS if ALL in platforms else platforms,
        flat=flat,
        execution_tool=execution_tool,
    )
    if files:
        build_files(files, out, options=options, notes=design_notes)
    else:
        build_all(configurations(configuration), out, options=options)
    if missions:
        from ..loop.missions import write_all_missions

        write_all_missions(configurations(configuration), files, out, options=options)
    for left in earlier_folders(out):
        remark(f"{left}: FMUs of an earlier build, unchanged; build with the same options to renew them")
    print(f"built in {perf_counter() - started:.1f} s")
    first = files[0].stem if files else configurations(configuration)[-1]
    native_run = "" if no_native else " --native"
    suggest(f"{{program}} run {out / first}/fine_pointing.ssd{native_run} --stop-time 30 --out results/first")
    return 0
