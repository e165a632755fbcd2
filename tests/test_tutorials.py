"""README and tutorials run as written, top to bottom: blocks of `sh` and of Python; those marked `text` show output.

A comment before a block says the exit code where that is the point.
"""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
TUTORIALS = ("README", "docs/first_run", "docs/controller_in_the_loop", "docs/fmus_for_other_tools")
BLOCK = re.compile(r"^(?:<!-- exit code (\d) -->\n)?```(sh|python)\n(.*?)^```", re.DOTALL | re.MULTILINE)
BUILD = re.compile(r"^flexsat build( +#.*)?\n", re.MULTILINE)  # done once for all tests


@pytest.mark.parametrize("name", TUTORIALS)
def test_a_tutorial_runs_top_to_bottom(name, delivered, tmp_path):
    (tmp_path / "fmus").symlink_to(delivered)
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    run_as_written(name, tmp_path)


def test_a_spacecraft_of_ones_own_flies_from_an_empty_folder_to_its_studies(tmp_path):
    """Four wheels, two gyros and seven modes, from tables: all studies run on it as on the paper's spacecraft."""
    run_as_written("docs/own_spacecraft_first_hour", tmp_path)
    assert (tmp_path / "results" / "my" / "report.html").is_file()
    assert (tmp_path / "fmus" / "my" / "array.npz").read_bytes() == (tmp_path / "array.npz").read_bytes()


def run_as_written(name, folder):
    programs = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    environment = os.environ | {"PATH": programs}
    blocks = BLOCK.findall((ROOT / f"{name}.md").read_text(encoding="utf-8"))

    assert len(blocks) > 1
    for expected, language, code in blocks:
        code = BUILD.sub("", code)
        command = ["bash", "-e", "-c", code] if language == "sh" else [sys.executable, "-c", code]
        done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False)
        assert done.returncode == int(expected or 0), f"{code}{done.stdout}{done.stderr}"
