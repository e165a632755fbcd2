"""A system of four cells, and the FMU that they are."""

import shutil
from pathlib import Path

import pytest

from fmus.cell.cell_fmu import cell_fmu
from fmus.cell.four_cells import four_cells
from lockstep import System

COMPILER = "" if shutil.which("cc") else "no C compiler: `cc` is not on the path"


def pytest_collection_modifyitems(items):
    """Skip all tests of this folder where nothing can be compiled."""
    for item in items:
        if COMPILER and Path(__file__).parent in item.path.parents:
            item.add_marker(pytest.mark.skip(COMPILER))


@pytest.fixture(scope="session")
def cells(tmp_path_factory) -> System:
    """Return the system; its components have one FMU."""
    return four_cells(cell_fmu(tmp_path_factory.mktemp("cell")))
