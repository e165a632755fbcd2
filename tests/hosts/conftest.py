"""The FMUs for all hosts, built once for all workers."""

import fcntl
import os
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))
from hosting import Bench, build


@pytest.fixture(scope="session")
def bench(tmp_path_factory):
    """Return the built FMUs, and the reference runs of this worker."""
    base = tmp_path_factory.getbasetemp()
    shared = base.parent if "PYTEST_XDIST_WORKER" in os.environ else base  # of the session, above that of a worker
    fmus, built = shared / "hosts-fmus", shared / "hosts-built"
    with (shared / "hosts-lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not built.exists():
            build(fmus)
            built.touch()
    return Bench(fmus, tmp_path_factory.mktemp("hosts"))
