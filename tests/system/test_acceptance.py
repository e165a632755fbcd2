"""`flexsat check` on the FMUs of the study, as a receiver would run it on what he gets."""

import contextlib
import os
import shutil
import signal
import subprocess
import time
from collections.abc import Callable
from pathlib import Path

import psutil
import pytest

from fmus.bad.bad_fmus import bad_fmu
from lockstep.check.report.check_report import CheckReport, from_json

from .conftest import RunCli

COMPONENTS, CONFIGURATIONS = ("plant", "sensors", "controller"), ("centralised", "distributed")


@pytest.fixture(scope="module")
def reports(fmus: Path, flexsat: RunCli, tmp_path_factory: pytest.TempPathFactory) -> dict[str, CheckReport]:
    """Return the static report of all six FMUs, checked in one call that warnings would fail."""
    paths = [fmus / name / f"{component}.fmu" for name in CONFIGURATIONS for component in COMPONENTS]
    written = tmp_path_factory.mktemp("report") / "report.json"
    done = flexsat("check", *paths, "--static", "--strict", "--json", written)
    assert done.returncode == 0, done.stdout
    found = from_json(written.read_text(encoding="utf-8"))
    assert [report.file for report in found] == [str(path) for path in paths]
    return {f"{Path(r.file).parent.name}/{Path(r.file).stem}": r for r in found}


@pytest.mark.parametrize("name", [f"{name}/{component}" for name in CONFIGURATIONS for component in COMPONENTS])
def test_our_fmus_have_nothing_to_object_to(reports: dict[str, CheckReport], name: str) -> None:
    findings = {finding.check: finding for finding in reports[name].findings}
    configuration, component = name.split("/")

    assert {f.status for f in findings.values()} <= {"pass", "info"}
    # what is worth knowing: it needs Python in its host, and modal coordinates have no base units in FMI
    assert {check for check, f in findings.items() if f.status == "info"} <= {"static.dependencies", "static.units"}
    assert findings["contract.direct"].message.startswith(f"{component}:{configuration}: ")
    assert findings["contract.direct"].numbers["missing"] == findings["contract.direct"].numbers["adapter"] == 0


def test_a_controller_of_the_other_size_misses_wheels(fmus: Path, flexsat: RunCli) -> None:
    path = fmus / "centralised" / "controller.fmu"
    done = flexsat("check", path, "--static", "--like", "controller:distributed")

    assert done.returncode == 1
    assert "error    contract.missing" in done.stdout
    assert "needed: wheel.torque[7..33]" in done.stdout


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (("nowhere.fmu",), "nowhere.fmu: no such file"),
        (("controller.fmu", "--like", "thruster"), "--like thruster: no such contract; there are plant"),
    ],
)
def test_bad_input_gets_one_line(
    fmus: Path, flexsat: RunCli, tmp_path: Path, arguments: tuple[str, ...], says: str
) -> None:
    shutil.copy(fmus / "centralised" / "controller.fmu", tmp_path)
    done = flexsat("check", *arguments, cwd=tmp_path)

    assert (done.returncode, done.stdout) == (2, "")
    assert says in done.stderr
    assert done.stderr.count("\n") == 1


def test_help_has_an_example_and_the_exit_codes(flexsat: RunCli) -> None:
    done = flexsat("check", "--help")

    assert "flexsat check vendor.fmu --like controller" in done.stdout
    assert "exit code: 0 no error" in done.stdout


def runs_a_probe(pid: int) -> bool:
    """Return whether a process has a child for the dynamic checks of an FMU."""
    for child in psutil.Process(pid).children(recursive=True):
        with contextlib.suppress(psutil.NoSuchProcess):
            if "probe_process" in " ".join(child.cmdline()):
                return True
    return False


@pytest.mark.skipif(shutil.which("gcc") is None, reason="the bad FMU is compiled with gcc")
def test_an_interrupted_check_ends_with_one_line(
    start_flexsat: "Callable[..., subprocess.Popen[str]]", tmp_path: Path
) -> None:
    path = bad_fmu(tmp_path / "built", "HANGS")
    # quiet: the signal may come between the opening of a file and the block that closes it
    with start_flexsat("check", path, "--json", tmp_path / "report.json", quiet=True) as process:
        while not runs_a_probe(process.pid):  # until the dynamic checks have begun; the second of them waits for 60 s
            assert process.poll() is None
            time.sleep(0.05)
        os.killpg(process.pid, signal.SIGINT)
        out, err = process.communicate(timeout=30)

    assert process.returncode == 130
    assert out == ""
    assert err.splitlines()[-1] == "flexsat: interrupted; the reports hold the FMUs that were checked"
    assert "Traceback" not in err
    assert [left.name for left in tmp_path.iterdir()] == ["built"]
