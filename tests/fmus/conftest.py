"""FMUs as `flexsat build --flat` leaves them, built once for all tests that only read them."""

import subprocess
import sys
from pathlib import Path

import pytest


@pytest.fixture(scope="session")
def delivered(tmp_path_factory):
    """Return a folder with the twelve FMUs: both configurations, structured and flat names."""
    folder = tmp_path_factory.mktemp("delivered")
    program = Path(sys.executable).with_name("flexsat")
    subprocess.run([program, "build", "--flat", "--out", folder], check=True, capture_output=True)
    return folder
