"""The pages build with Sphinx without a warning, and lead from the first page to every other."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("sphinx", reason="the pages are built with Sphinx, of the dependency group docs")
ROOT = Path(__file__).parents[1]
BESIDE = ("README.md", "CHANGELOG.md", "pyproject.toml")


@pytest.fixture(scope="module")
def built(tmp_path_factory, delivered):
    """Return the pages, built from a copy: what is written while building stays out of the repository."""
    folder = tmp_path_factory.mktemp("docs")
    left_out = shutil.ignore_patterns("build", "reference", "__pycache__")
    shutil.copytree(ROOT / "docs", folder / "docs", ignore=left_out)
    shutil.copytree(ROOT / "orchestrator" / "flexbench" / "figures", folder / "orchestrator" / "flexbench" / "figures",
                    ignore=shutil.ignore_patterns("*.py", "__pycache__"))  # fmt: skip
    for name in BESIDE:
        shutil.copy(ROOT / name, folder / name)
    command = [sys.executable, "-m", "sphinx", "-q", "-W", "--keep-going", "-b", "html", "docs", "html"]
    environment = os.environ | {"FLEXSAT_FMUS": str(delivered)}
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout + done.stderr) == (0, "")
    return folder / "html"


def test_every_page_is_in_a_table_of_contents(built):
    """A page in no table of contents is a warning of Sphinx, which would have failed the build."""
    names = {path.stem for path in (ROOT / "docs").glob("*.md")}

    assert names <= {path.stem for path in built.glob("*.html")}


def test_the_reference_is_made_from_the_code(built):
    commands = (built / "reference" / "flexsat_commands.html").read_text(encoding="utf-8")
    assert "--switchover" in commands
    ports = (built / "reference" / "ports.html").read_text(encoding="utf-8")
    assert "star_tracker.mrp" in ports
    models = (built / "reference" / "models.html").read_text(encoding="utf-8")
    assert "body rate w; N_i the slope of the modes" in models
    python = (built / "python.html").read_text(encoding="utf-8")
    assert "lockstep.simulate" in python
    assert "Raises" in python


def test_the_readme_is_a_page_whose_links_stay_within_the_pages(built):
    text = (built / "reference" / "readme.html").read_text(encoding="utf-8")

    assert 'href="../results.html"' in text
    assert "slew-seed1.png" in text
