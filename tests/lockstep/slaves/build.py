"""Build the toy FMUs: run as a program, because pythonfmu leaves modules and paths behind in its process.

The script gets what pythonfmu leaves out: a reference to its own module (it drops one too many at each load)
and units in the model description.
"""

import shutil
import sys
import tempfile
import warnings
from pathlib import Path

from pythonfmu import FmuBuilder

KEEP = "\nimport ctypes as _ctypes\n\n_ctypes.pythonapi.Py_IncRef(_ctypes.py_object(globals()))\n"


def build(folder: Path) -> None:
    for script in sorted(Path(__file__).parent.glob("toy_*.py")):
        with tempfile.TemporaryDirectory() as temporary:
            copy = Path(temporary, script.name)
            copy.write_text(script.read_text() + KEEP)
            built = FmuBuilder.build_FMU(copy, dest=temporary)
            shutil.copy(built, folder / f"{script.stem}.fmu")


if __name__ == "__main__":
    warnings.simplefilter("ignore")
    build(Path(sys.argv[1]))
