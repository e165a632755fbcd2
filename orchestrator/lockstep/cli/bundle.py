"""The command `bundle`: a system becomes one FMU."""

from __future__ import annotations

import sys
from pathlib import Path

import click

from lockstep.bundle.platforms import PLATFORMS
from lockstep.cli.command import command
from lockstep.cli.options import assignments, out_option, set_option, system_argument
from lockstep.cli.outcome import wrote
from lockstep.cli.parameter_types import SomeOf
from lockstep.cli.timing_options import TimingOptions, timing_options, with_delays
from lockstep.errors import InputError
from lockstep.whole_file import write_whole

_EXAMPLES = """
examples:
  {program} bundle fmus/distributed/native/fine_pointing.ssd --out closed_loop.fmu
  {program} bundle fmus/distributed/native/fine_pointing.ssd --input 'plant.external.*' --output plant.rate \\
      --platforms linux64,win64 --out loop.fmu

  The FMU is one for co-simulation (FMI 2.0, or 3.0 with --fmi3) with the FMUs of the system in its resources; each is
  stepped at its own period, with the delays of the system. Without options its inputs and outputs are the connectors
  of the system, or, if there are none, all outputs and no input; its parameters are those of all components, with the
  values of the system.
  A C compiler is needed, or Zig (pip install ziglang) with --platforms.
"""


@command("bundle", _EXAMPLES, then="{program} check {out}    # the acceptance check that any FMU gets")
@system_argument
@out_option("FMU to write", metavar="FILE", required=True)
@click.option(
    "--input",
    "inputs",
    multiple=True,
    metavar="PATTERN",
    help="inputs: connectors of the system, or unconnected inputs of components (all, none)",
)
@click.option(
    "--output",
    "outputs",
    multiple=True,
    metavar="PATTERN",
    help="outputs: connectors of the system, or outputs of components (all, none)",
)
@click.option(
    "--parameter", "parameters", multiple=True, metavar="PATTERN", help="parameters of components (default: all; none)"
)
@click.option(
    "--multiple-of",
    metavar="S",
    help="the FMU accepts steps that are multiples of it, in seconds (default: the tick of the system)",
)
@click.option(
    "--platforms",
    type=SomeOf(PLATFORMS),
    default=(),
    metavar="NAMES",
    help=f"binaries to build, with Zig: {', '.join(PLATFORMS)} (default: this machine's, without Zig)",
)
@click.option("--fmi3", is_flag=True, help="write an FMU of FMI 3.0 instead of 2.0, with whole arrays as variables")
@set_option
@timing_options
def bundle(
    system: Path,
    out: Path,
    inputs: tuple[str, ...],
    outputs: tuple[str, ...],
    parameters: tuple[str, ...],
    multiple_of: str | None,
    platforms: tuple[str, ...],
    fmi3: bool,
    settings: tuple[str, ...],
    timing: TimingOptions,
) -> int:
    """Write a system as one FMU."""
    from lockstep.bundle.contents import contents
    from lockstep.bundle.ports import Choice
    from lockstep.bundle.write import bundle_bytes
    from lockstep.ssp.load import load_system
    from lockstep.system.clock import positive_nanoseconds

    if out.suffix != ".fmu":
        raise InputError(f"--out {out}: the file of an FMU ends with .fmu")
    loaded = with_delays(load_system(system, timing.timing()), timing.delay)
    choice = Choice(inputs=inputs or None, outputs=outputs or None, parameters=parameters or None)
    step = None if multiple_of is None else positive_nanoseconds(multiple_of, "--multiple-of")
    made = contents(loaded, assignments(settings), choice, step)
    content = bundle_bytes(made, platforms, "3.0" if fmi3 else "2.0")
    try:
        write_whole(out, content)
    except OSError as error:
        raise InputError(f"{out}: cannot be written ({error.strerror or error})") from None
    for note in made.notes:
        print(f"note: {note}", file=sys.stderr)
    wrote(out)
    return 0
