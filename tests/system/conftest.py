"""The built FMUs of the spacecraft, and programs in fresh processes: an FMU may take its process down."""

import json
import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from browser_pages import WATCH_CANVASES, WIDE, chromium, settle
from copied_process import Copies
from flexbench.cli.parser import main
from lockstep import Signals, read_signals

COMMAND = Path(sys.executable).with_name("flexsat")
# warnings are errors in the programs too, their workers included; one thread each, as two run at a time
ENVIRONMENT = os.environ | {"PYTHONWARNINGS": "error", "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}

# `flexsat paper` without its build, with native FMUs in every run, and with a coarse Campbell diagram: that of
# `flexsat figures` has all its points
NATIVE_STUDY = """
from contextlib import redirect_stdout
from dataclasses import replace
from io import StringIO
from flexbench.cli.parser import main
from flexbench.figures import campbell
from flexbench.loop import build
from flexbench.studies.paper import paper
fmus, results = given
planned = paper.plan_jobs
paper.plan_jobs = lambda *options: {key: replace(job, native=True) for key, job in planned(*options).items()}
build.build_all = lambda *_, **__: None
campbell.MAP_SPEEDS, campbell.EVEN = campbell.MAP_SPEEDS[::8], 40
with redirect_stdout(StringIO()) as printed:
    assert main(["paper", "--python", "--fmus", fmus, "--out", results]) == 0
result = printed.getvalue()
"""

RunCli = Callable[..., "subprocess.CompletedProcess[str]"]
RunScript = Callable[..., Any]


IMPORTED = ("flexbench.cli.parser", "flexbench.loop.build", "flexbench.report.paper_pages", "flexsat.closed_loop",
            "lockstep.simulation", "lockstep.check.check_fmu", "robust_designs")  # fmt: skip


@pytest.fixture(scope="session")
def copies() -> Iterator[Copies]:
    """Return a process that has imported the packages and made the designs, whose copies run programs."""
    started = Copies(IMPORTED, os.environ | ENVIRONMENT)
    yield started
    started.close()


@pytest.fixture(scope="session")
def flexsat(copies: Copies) -> RunCli:
    """Return a function that runs the command `flexsat` in a copy of a process that is there.

    A new process runs it where it gets limits, and runs a script in its place.
    """

    def run(
        *arguments: object, timeout: float = 120.0, script: Path | None = None, **options: Any
    ) -> "subprocess.CompletedProcess[str]":
        words = list(map(str, arguments))
        if script is None and options.keys() <= {"cwd"}:
            return copies.run(["flexbench.cli.parser:program", str(COMMAND), *words], timeout=timeout, **options)
        command = [*([str(COMMAND)] if script is None else [sys.executable, str(script)]), *words]
        return subprocess.run(
            command,
            capture_output=True,
            text=True,
            check=False,
            timeout=timeout,
            env=os.environ | ENVIRONMENT,
            **options,
        )

    return run


@pytest.fixture(scope="session")
def start_flexsat() -> Callable[..., "subprocess.Popen[str]"]:
    """Return a function that starts the command `flexsat`, or a script, in a process group of its own.

    With `quiet`, Python's own warnings are as a user has them, not errors.
    """

    def start(
        *arguments: object, script: str | None = None, quiet: bool = False, **options: Any
    ) -> "subprocess.Popen[str]":
        program = [str(COMMAND)] if script is None else [sys.executable, "-c", script]
        command = [*program, *map(str, arguments)]
        return subprocess.Popen(
            command,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            env=ENVIRONMENT | ({"PYTHONWARNINGS": ""} if quiet else {}),
            start_new_session=True,
            **options,
        )

    return start


@pytest.fixture(scope="session")
def python(copies: Copies) -> RunScript:
    """Return a function that runs a script in a process of its own, arguments in `given`, and returns its `result`.

    The process is a copy of one that is there, or a new one with `fresh`.
    """

    def run(script: str, *arguments: object, timeout: float = 300.0, fresh: bool = False) -> Any:
        text = f"import json, sys\nfrom pathlib import Path\ngiven = json.loads(sys.argv[1])\n{script}\n"
        text += "print('result:' + json.dumps(result))\n"
        given = json.dumps([str(a) if isinstance(a, Path) else a for a in arguments])
        if fresh:
            command = [sys.executable, "-c", text, given]
            done = subprocess.run(
                command, capture_output=True, text=True, check=False, timeout=timeout, env=os.environ | ENVIRONMENT
            )
        else:
            done = copies.run(["-c", text, given], timeout=timeout)
        assert done.returncode == 0, f"exit code {done.returncode}\n{done.stdout}\n{done.stderr}"
        return json.loads(done.stdout.rpartition("result:")[2])

    return run


@pytest.fixture(scope="session")
def fmus(delivered: Path) -> Path:
    """Return a folder with the FMUs and systems of both configurations, for reading only."""
    return delivered


@pytest.fixture(scope="session")
def study(fmus: Path, python: RunScript, once: Callable[[str, Callable[[Path], None]], Path]) -> tuple[Path, str]:
    """Return the results folder of the paper's study with one seed, both variants, and what the command printed.

    Its runs of 300 s have native FMUs, which take a sixth of the time. Run once for all workers; for reading only.
    """

    def run(folder: Path) -> None:
        folder.mkdir()
        (folder / "printed.txt").write_text(python(NATIVE_STUDY, fmus, folder / "results", timeout=1500.0))
        assert sorted(path.name for path in folder.iterdir()) == ["printed.txt", "results"]

    folder = once("study", run)
    return folder / "results", (folder / "printed.txt").read_text(encoding="utf-8")


@pytest.fixture(scope="session")
def missions(delivered: Path, once: Callable[[str, Callable[[Path], None]], Path]) -> Callable[[str], Path]:
    """Return a function that returns the missions of a layout, as `flexsat build --missions` leaves them."""

    def of(name: str) -> Path:
        def build(folder: Path) -> None:
            from flexbench.loop import build as stock

            target = folder / name
            for kind in ("", "native"):
                (target / kind).mkdir(parents=True, exist_ok=True)
                for component in ("plant", "sensors", "controller"):
                    os.link(delivered / name / kind / f"{component}.fmu", target / kind / f"{component}.fmu")
            given = stock.build_all
            stock.build_all = lambda *_, **__: None  # they are there
            try:
                assert main(["build", "--missions", "--configuration", name, "--out", str(folder)]) == 0
            finally:
                stock.build_all = given

        return once(f"missions-{name}", build) / name / "missions"

    return of


@pytest.fixture
def fly_from(tmp_path: Path) -> Callable[..., Signals]:
    """Return what runs a system in a folder of missions and returns its signals; files are given as texts."""

    def run(
        folder: Path, stop: float, *words: str, mission: str | None = None, faults: str | None = None,
        name: str = "run", system: str = "mission", native: bool = True,
    ) -> Signals:  # fmt: skip
        out = tmp_path / name
        command = ["run", str(folder / f"{system}.ssd"), "--stop-time", str(stop), "--out", str(out), *words]
        command += ["--native"] if native else []
        for option, text in (("--mission", mission), ("--faults", faults)):
            if text is not None:
                path = tmp_path / f"{name}{option}.toml"
                path.write_text(text)
                command += [option, str(path)]
        assert main(command) == 0
        return read_signals(out)

    return run


@pytest.fixture(scope="session")
def browser() -> Iterator[Any]:
    """Return a browser for the pages of all tests."""
    with chromium() as started:
        yield started


@pytest.fixture
def open_page(browser: Any) -> Iterator[Callable[..., Any]]:
    """Return a function that opens a page; at the end it must have reported no error and asked for no other file."""
    complaints: list[str] = []
    asked: list[str] = []
    opened: list[Any] = []

    def open_(file: Path, viewport: Any = WIDE, scheme: str = "light") -> Any:
        page = browser.new_page(viewport=viewport, color_scheme=scheme)
        opened.append(page)
        page.add_init_script(f"({WATCH_CANVASES})()")
        page.on("console", lambda message: message.type in ("error", "warning") and complaints.append(message.text))
        page.on("pageerror", lambda error: complaints.append(str(error)))
        page.on("request", lambda request: asked.append(request.url.partition(",")[0]))
        page.goto(file.resolve().as_uri())
        page.wait_for_selector("html[data-ready]", state="attached")
        settle(page)
        return page

    yield open_
    for page in opened:
        page.close()
    assert complaints == []
    assert [url for url in asked if not url.startswith(("file:", "data:"))] == []


@pytest.fixture(scope="session")
def slews(fmus: Path, flexsat: RunCli, once: Callable[[str, Callable[[Path], None]], Path]) -> Path:
    """Return a folder of two slews of both layouts that end after 8 s, the first with its page; for reading only."""

    def run(folder: Path) -> None:
        for name in ("distributed", "centralised"):
            words = ("--native", "--accept-infeasible", "--stop-time", "8", "--seed", "1")
            done = flexsat("run", fmus / name / "slew.ssd", *words, "--out", folder / f"{name}-slew")
            assert done.returncode == 0, done.stderr
        done = flexsat("report", folder / "distributed-slew", timeout=300.0)
        page = folder / "distributed-slew" / "report.html"
        assert (done.returncode, done.stderr) == (0, "")
        assert done.stdout.split() == [str(page)]

    return once("slews", run)
