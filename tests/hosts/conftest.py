"""The FMUs for all hosts, built once a worker."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))
from hosting import Bench


@pytest.fixture(scope="session")
def bench(tmp_path_factory):
    """Return the built FMUs of both configurations, and the reference runs."""
    return Bench(tmp_path_factory.mktemp("hosts"), ("centralised", "distributed"))
