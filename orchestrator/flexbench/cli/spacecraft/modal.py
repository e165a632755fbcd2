"""The command `flexsat modal`."""

from __future__ import annotations

import sys
from pathlib import Path

import click

from lockstep.cli.command import command
from lockstep.cli.options import out_option
from lockstep.cli.outcome import keep_table, wrote
from lockstep.cli.parameter_types import PATH
from lockstep.errors import InputError

_GIVE = "give a modal file (.npz), a folder of CSV tables, or results of CalculiX (.frd) or NASTRAN (.op2)"
_EXAMPLES = """
exit code: 0 the data fit together, 1 they do not, 2 bad input

examples:
  {program} modal array.npz
  {program} modal array.frd --out array.npz
  {program} modal tables --out array.npz
  {program} modal array.op2 --nastran-python nastran/bin/python --out array.npz
"""


@command("modal", _EXAMPLES, then="{program} new my.toml    # then name the modal file in it: docs/modal_files.md",
         tables=True)  # fmt: skip
@click.argument("source", type=PATH, metavar="SOURCE",
                help="a modal file (.npz), a folder of CSV tables, results of CalculiX (.frd) or of NASTRAN"
                     " (.op2)")  # fmt: skip
@out_option("modal file to write (default: none)", metavar="FILE")
@click.option("--nastran-python", type=PATH, metavar="FILE",
              help="Python with pyNastran, which reads .op2: nastran/bin/python after `python3 -m venv nastran` and"
                   " `nastran/bin/pip install pyNastran`")  # fmt: skip
def modal(source: Path, out: Path | None, nastran_python: Path | None) -> int:
    """Check modal data of a structure: participation, mass, inertia, orthogonality, what is missing; convert them."""
    from flexsat.structure.modal_checks import modal_checks
    from flexsat.structure.modal_file import modal_bytes
    from flexsat.structure.modal_sources import read_modal_source
    from lockstep.whole_file import write_whole

    from .nastran_process import ENDING, read_nastran

    if source.suffix != ENDING and nastran_python is not None:
        raise InputError(f"--nastran-python: has no effect on {source}; it reads results of NASTRAN ({ENDING})")
    if not source.exists():
        raise InputError(f"{source}: no such file; {_GIVE}")
    try:
        data = read_nastran(source, nastran_python) if source.suffix == ENDING else read_modal_source(source)
        checks = modal_checks(data)
    except OSError as error:
        raise InputError(f"{error.filename or source}: cannot be read ({error.strerror}); {_GIVE}") from None
    except InputError:
        raise
    except ValueError as error:
        raise InputError(f"{source}: {error}") from None
    for check in checks:
        print(check.text if check.right else f"WRONG: {check.text}")
    keep_table(("check", "right"), ((check.text, check.right) for check in checks), "checks")
    keep_table(("quantity", "value", "unit"), (number for check in checks for number in check.numbers), "numbers")
    if out is not None:
        write_whole(out, modal_bytes(data))
        wrote(out)
    wrong = [check.text for check in checks if not check.right]
    if wrong:
        print(f"flexsat: {source}: {wrong[0]}", file=sys.stderr)
    return 1 if wrong else 0
