"""Runs and checks where the temporary folder's path has blanks and letters outside ASCII."""

import os
import subprocess
import sys
from pathlib import Path

import pytest


@pytest.fixture
def environment(tmp_path: Path) -> dict[str, str]:
    """Return an environment with such a temporary folder."""
    folder = tmp_path / "Größe und Maß"
    folder.mkdir()
    return os.environ | {"TMPDIR": str(folder), "OPENBLAS_NUM_THREADS": "1"}


def test_a_run_where_temporary_files_lie_on_a_path_with_umlauts(fmus, tmp_path, environment):
    system = fmus / "distributed" / "fine_pointing.ssd"
    command = [
        sys.executable,
        "-m",
        "lockstep",
        "run",
        str(system),
        "--stop-time",
        "0.1",
        "--out",
        str(tmp_path / "out"),
    ]

    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False, timeout=120)

    assert done.returncode == 0, done
    assert (tmp_path / "out" / "signals.parquet").is_file()
    assert list(Path(environment["TMPDIR"]).iterdir()) == []


def test_a_check_there_finds_nothing(fmus, environment):
    script = """
import sys
from pathlib import Path
from lockstep.check.dynamic_checks import dynamic_checks
found = dynamic_checks(Path(sys.argv[1]), print, only=["dynamic.repeat", "dynamic.resource_location"])
assert {f.status for f in found} == {"pass"}, found
"""
    command = [sys.executable, "-c", script, str(fmus / "distributed" / "sensors.fmu")]

    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False, timeout=120)

    assert done.returncode == 0, done
