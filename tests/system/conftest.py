"""The built FMUs of the spacecraft, and programs in fresh processes: an FMU may take its process down."""

import json
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

COMMAND = Path(sys.executable).with_name("flexsat")
# warnings are errors in the programs too, their workers included; one thread each, as two run at a time
ENVIRONMENT = os.environ | {"PYTHONWARNINGS": "error", "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}

RunCli = Callable[..., "subprocess.CompletedProcess[str]"]
RunScript = Callable[..., Any]


@pytest.fixture(scope="session")
def flexsat() -> RunCli:
    """Return a function that runs the command `flexsat` as a user does."""

    def run(*arguments: object, timeout: float = 120.0, **options: Any) -> "subprocess.CompletedProcess[str]":
        command = [str(COMMAND), *map(str, arguments)]
        return subprocess.run(
            command, capture_output=True, text=True, check=False, timeout=timeout, env=ENVIRONMENT, **options
        )

    return run


@pytest.fixture(scope="session")
def start_flexsat() -> Callable[..., "subprocess.Popen[str]"]:
    """Return a function that starts the command `flexsat` in a process group of its own."""

    def start(*arguments: object, **options: Any) -> "subprocess.Popen[str]":
        command = [str(COMMAND), *map(str, arguments)]
        return subprocess.Popen(
            command,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            env=ENVIRONMENT,
            start_new_session=True,
            **options,
        )

    return start


@pytest.fixture(scope="session")
def python() -> RunScript:
    """Return a function that runs a script in a fresh process, arguments in `given`, and returns its `result`."""

    def run(script: str, *arguments: object, timeout: float = 300.0) -> Any:
        text = f"import json, sys\nfrom pathlib import Path\ngiven = json.loads(sys.argv[1])\n{script}\n"
        text += "print('result:' + json.dumps(result))\n"
        given = json.dumps([str(a) if isinstance(a, Path) else a for a in arguments])
        done = subprocess.run(
            [sys.executable, "-c", text, given],
            capture_output=True,
            text=True,
            check=False,
            timeout=timeout,
            env=ENVIRONMENT,
        )
        assert done.returncode == 0, f"exit code {done.returncode}\n{done.stdout}\n{done.stderr}"
        return json.loads(done.stdout.rpartition("result:")[2])

    return run


@pytest.fixture(scope="session")
def fmus(delivered: Path) -> Path:
    """Return a folder with the FMUs and systems of both configurations, for reading only."""
    return delivered


@pytest.fixture(scope="session")
def study(flexsat: RunCli, once: Callable[[str, Callable[[Path], None]], Path]) -> tuple[Path, str]:
    """Return the results folder of the paper's study with one seed, both variants, and what the command printed.

    Without the runs through native FMUs, for time: `tests/flexbench/studies/paper/test_native.py` has one of them.

    Run once for all workers; for reading only.
    """

    def run(folder: Path) -> None:
        folder.mkdir()
        done = flexsat(
            "paper", "--python", "--fmus", folder / "fmus", "--out", folder / "results", timeout=2700.0, cwd=folder
        )
        assert done.returncode == 0, done.stderr
        assert sorted(path.name for path in folder.iterdir()) == ["fmus", "results"]
        (folder / "printed.txt").write_text(done.stdout, encoding="utf-8")

    folder = once("study", run)
    return folder / "results", (folder / "printed.txt").read_text(encoding="utf-8")
