"""Run README and tutorials as written, top to bottom: blocks of `sh` and of Python; those marked `text` show output.

A comment before a block says the exit code where that is the point. Each page has a test file of its own, as files are
what the workers of the tests share out, and a page takes a minute or two.
"""

import os
import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
BLOCK = re.compile(r"^(?:<!-- exit code (\d) -->\n)?```(sh|python)\n(.*?)^```", re.DOTALL | re.MULTILINE)
BUILD = re.compile(r"^flexsat build( +#.*)?\n", re.MULTILINE)  # done once for all tests


def run_with_fmus(page: str, delivered: Path, folder: Path) -> None:
    """Run a page in a folder with the built FMUs and the examples."""
    (folder / "fmus").symlink_to(delivered)
    (folder / "examples").symlink_to(ROOT / "examples")
    run_as_written(page, folder)


def run_as_written(page: str, folder: Path) -> None:
    """Run the blocks of a page in a folder."""
    programs = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    environment = os.environ | {"PATH": programs}
    blocks = BLOCK.findall((ROOT / f"{page}.md").read_text(encoding="utf-8"))

    assert len(blocks) > 1
    for expected, language, code in blocks:
        code = BUILD.sub("", code)
        command = ["bash", "-e", "-c", code] if language == "sh" else [sys.executable, "-c", code]
        done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False)
        assert done.returncode == int(expected or 0), f"{code}{done.stdout}{done.stderr}"
