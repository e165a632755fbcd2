"""Run README and tutorials as written, top to bottom: blocks of `sh` and of Python; those marked `text` show output.

A comment before a block says the exit code where that is the point. Each page has a test file of its own, as files are
what the workers of the tests share out, and a page takes a minute or two.

Each command is a process of its own. On a page of many, `flexsat` is a copy of one that has imported the libraries that
it needs, and none of its own modules: these would load each other, and one that a command lacks would not be missed.
"""

import os
import re
import shlex
import subprocess
import sys
from contextlib import closing
from pathlib import Path

from copied_process import Copies

ROOT = Path(__file__).parents[2]
PROGRAMS = Path(sys.executable).parent
BLOCK = re.compile(r"^(?:<!-- exit code (\d) -->\n)?```(sh|python)\n(.*?)^```", re.DOTALL | re.MULTILINE)
COMMAND = re.compile(r"^(flexsat .*\n)", re.MULTILINE)
LIBRARIES = ("control", "fmpy", "lxml.etree", "matplotlib.backends.backend_agg", "matplotlib.backends.backend_svg",
             "matplotlib.figure", "pyarrow.parquet", "rich.console", "scipy.optimize", "scipy.signal")  # fmt: skip
BUILD = re.compile(r"^flexsat build( +#.*)?\n", re.MULTILINE)  # done once for all tests


def run_with_fmus(page: str, delivered: Path, folder: Path) -> None:
    """Run a page in a folder with the built FMUs and the examples."""
    (folder / "fmus").symlink_to(delivered)
    (folder / "examples").symlink_to(ROOT / "examples")
    run_as_written(page, folder)


def run_as_written(page: str, folder: Path) -> None:
    """Run the blocks of a page in a folder."""
    environment = _environment()
    for expected, language, code in _blocks(page):
        code = BUILD.sub("", code)
        command = ["bash", "-e", "-c", code] if language == "sh" else [sys.executable, "-c", code]
        done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False)
        assert done.returncode == int(expected or 0), f"{code}{done.stdout}{done.stderr}"


def run_in_copies(page: str, folder: Path) -> None:
    """Run the blocks of a page of many commands in a folder: those of `flexsat` one by one, what is between in Bash."""
    environment = _environment()
    with closing(Copies(LIBRARIES, environment)) as copies:
        for _, language, code in _blocks(page):
            assert language == "sh"
            for piece in COMMAND.split(code):
                if COMMAND.match(piece):
                    words = shlex.split(piece, comments=True)
                    assert not {"|", ">", "&&", ";"} & set(words), "this needs a shell"
                    program = ["flexbench.cli.parser:program", str(PROGRAMS / words[0]), *words[1:]]
                    done = copies.run(program, timeout=900.0, cwd=folder)
                else:
                    command = ["bash", "-e", "-c", piece]
                    done = subprocess.run(
                        command, cwd=folder, env=environment, capture_output=True, text=True, check=False
                    )
                assert done.returncode == 0, f"{piece}{done.stdout}{done.stderr}"


def _blocks(page: str) -> list[tuple[str, str, str]]:
    """Return expected exit code, language and text of each block of a page."""
    blocks = BLOCK.findall((ROOT / f"{page}.md").read_text(encoding="utf-8"))
    assert len(blocks) > 1
    return blocks


def _environment() -> dict[str, str]:
    return os.environ | {"PATH": f"{PROGRAMS}{os.pathsep}{os.environ['PATH']}"}
