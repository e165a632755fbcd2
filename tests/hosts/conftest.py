"""The FMUs for all hosts, and what several hosts are compared with."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))
from hosting import Bench, NativeBench


@pytest.fixture(scope="session")
def bench(delivered, tmp_path_factory):
    """Return the built FMUs, and the reference runs of this worker."""
    return Bench(delivered, tmp_path_factory.mktemp("hosts"))


@pytest.fixture(scope="session")
def native(delivered, tmp_path_factory):
    """Return a bench of the native FMUs."""
    return NativeBench(delivered, tmp_path_factory.mktemp("native"))
