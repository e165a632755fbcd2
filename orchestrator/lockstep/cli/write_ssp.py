"""The command `write-ssp`: an adapter becomes connections and parameters of standard SSP."""

from __future__ import annotations

import re
import sys
from collections.abc import Iterable
from pathlib import Path

import click

from lockstep.cli.command import command
from lockstep.cli.options import (
    adapter_option,
    delay_option,
    out_option,
    replace_option,
    step_size_option,
    system_argument,
)
from lockstep.cli.outcome import wrote
from lockstep.cli.timing_options import with_delays, with_step_sizes
from lockstep.errors import InputError
from lockstep.whole_file import write_whole

_EXAMPLES = """
example:
  {program} write-ssp fmus/centralised/fine_pointing.ssd --replace controller=vendor.fmu \\
      --adapter vendor.toml --source star_tracker.mrp=sensors.star_tracker.quaternion --out vendor.ssp

  An adapter becomes connections (names, order), linear transformations on them (unit, scale, offset, sign), mapping
  transformations (flags), a parameter mapping .ssm (from parameters of the interface to those of the foreign FMU) and
  values .ssv (constants, parameters). SSP can neither mix elements (MRP to quaternion, frames that are not signed
  permutations) nor hold values. Such entries are listed, and the system is refused (exit code 2), or written without
  them with --partial.
"""


@command("write-ssp", _EXAMPLES, then="{program} run {out}")
@system_argument
@replace_option
@adapter_option
@click.option("--source", multiple=True, metavar="ARRAY=C.ARRAY",
              help="outputs of C that hold, as a scalar-last quaternion (body from inertial), the attitude that the "
                   "adapter's interface port ARRAY holds as an MRP")  # fmt: skip
@delay_option
@step_size_option
@click.option("--partial", is_flag=True, help="leave out what SSP cannot express, and list it")
@out_option(".ssp file to write", metavar="FILE", required=True)
def write_ssp(
    system: Path,
    replace: tuple[str, ...],
    adapter: tuple[str, ...],
    source: tuple[str, ...],
    delay: tuple[str, ...],
    step_size: tuple[str, ...],
    partial: bool,
    out: Path,
) -> int:
    """Write a system with a foreign FMU as standard SSP, its adapter included."""
    from lockstep.adapter.component import with_replacements
    from lockstep.ssp.adapted_package import standard_package
    from lockstep.ssp.load import load_system

    if out.suffix != ".ssp":
        raise InputError(f"--out {out}: a system package ends with .ssp")
    changed = with_replacements(load_system(system), replace, adapter)
    changed = with_step_sizes(with_delays(changed, delay), step_size)
    content, problems = standard_package(changed, _sources(source))
    for problem in problems:
        print(f"{'left out' if partial else 'not in SSP'}: {problem}", file=sys.stderr)
    if problems and not partial:
        number = f"{len(problems)} entr{'ies' if len(problems) > 1 else 'y'}"
        raise InputError(f"{out}: not written: SSP cannot express {number} of an adapter; --partial leaves them out")
    try:
        write_whole(out, content)
    except OSError as error:
        raise InputError(f"{out}: cannot be written ({error.strerror or error})") from None
    wrote(out)
    return 0


def _sources(texts: Iterable[str]) -> dict[str, tuple[str, str]]:
    found: dict[str, tuple[str, str]] = {}
    for text in texts:
        match = re.fullmatch(r"([^=]+)=([^.=]+)\.([^=]+)", text)
        if match is None:
            raise InputError(
                f"--source {text}: write ARRAY=COMPONENT.ARRAY, for example "
                "star_tracker.mrp=sensors.star_tracker.quaternion"
            )
        found[match[1]] = (match[2], match[3])
    return found
