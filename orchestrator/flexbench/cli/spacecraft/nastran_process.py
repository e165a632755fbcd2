"""Read NASTRAN results with pyNastran, in a Python of its own: it needs another numpy than flexsat."""

from __future__ import annotations

import re
import shutil
import subprocess
from collections.abc import Sequence
from pathlib import Path

import numpy as np

import flexsat.structure
from flexsat.structure.modal_data import ModalData
from flexsat.structure.nastran import bulk_data_beside, nastran_data
from lockstep.errors import InputError
from lockstep.fmi.temporary_folder import temporary_folder

ENDING = ".op2"
_SCRIPT = Path(flexsat.structure.__file__).with_name("nastran_extract.py")
_EXCEPTION = re.compile(r"[\w.]+(Error|Exception): ")
_REMEDY = "python3 -m venv nastran; nastran/bin/pip install pyNastran; then --nastran-python nastran/bin/python"


def read_nastran(op2: Path, python: Path | None) -> ModalData:
    """Return the modal data of a run of SOL 103 and the model beside it.

    Parameters
    ----------
    op2 : results
    python : an interpreter that has pyNastran; None is refused with the remedy

    Raises
    ------
    InputError, ValueError
        If pyNastran cannot be used, or the files do not have what is needed.
    """
    if python is None:
        raise InputError(f"{op2}: results of NASTRAN are read by pyNastran, in a Python of its own: {_REMEDY}")
    program = shutil.which(python)
    if program is None:
        raise InputError(f"--nastran-python {python}: no such program; {_REMEDY}")
    bulk = bulk_data_beside(op2)
    op2.stat()  # OSError if it is not there
    with temporary_folder("nastran") as folder:
        out = folder / "arrays.npz"
        done = subprocess.run(
            [Path(program).absolute(), "-I", "-W", "ignore", _SCRIPT, op2.absolute(), bulk.absolute(), out],
            capture_output=True,
            text=True,
            cwd=folder,
            check=False,
        )
        lines = done.stderr.strip().splitlines()
        if "No module named 'pyNastran'" in done.stderr:
            raise InputError(f"--nastran-python {python}: has no pyNastran; {python} -m pip install pyNastran")
        if done.returncode or not out.is_file():
            raise InputError(f"{op2}: not read by pyNastran: {_reason(lines) or f'exit code {done.returncode}'}")
        with np.load(out) as arrays:
            return nastran_data(dict(arrays), op2.with_suffix(".toml"))


def _reason(lines: Sequence[str]) -> str:
    """Return the line that says what went wrong: of an exception its first, as pyNastran adds lists of paths."""
    raised = [line for line in lines if _EXCEPTION.match(line)]
    return raised[-1] if raised else "".join(lines[-1:])
