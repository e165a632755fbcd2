"""The whole acceptance check on FMUs with one defect in the model description, and what an interrupted one leaves."""

import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from fmus.bad.bad_fmus import XML, bad_fmu
from lockstep.check.check_fmu import check_fmu

pytestmark = pytest.mark.skipif(shutil.which("gcc") is None, reason="the bad FMUs are compiled with gcc")


def of_note(path: Path) -> dict[str, str]:
    """Return the static findings that a receiver would look at: message by check."""
    findings = check_fmu(path, dynamic=False).findings
    return {found.check: found.message for found in findings if found.status in ("warning", "error")}


def edited(*edits: tuple[str, str]) -> str:
    """Return the good model description with some texts replaced, each of which stands there once."""
    text = XML
    for old, new in edits:
        assert text.count(old) == 1
        text = text.replace(old, new)
    return text


def test_the_good_one_has_no_finding_of_note(tmp_path):
    assert of_note(bad_fmu(tmp_path)) == {}


@pytest.mark.parametrize(
    ("edit", "words"),
    [
        (('<Unit name="1">', '<Unit name="N"><BaseUnit kg="1" m="1" s="-2"/></Unit><Unit name="1">'), "'N'"),
        (('<BaseUnit m="1" s="-1"/>', '<BaseUnit m="1" s="-2"/>'), "'m/s'"),
    ],
)
def test_stale_units_are_found_and_nothing_else(tmp_path, edit, words):
    found = of_note(bad_fmu(tmp_path, xml=edited(edit)))

    assert list(found) == ["static.units"]
    assert words in found["static.units"]


def test_missing_unknowns_are_found_and_nothing_else(tmp_path):
    lines = (
        '      <Unknown index="5" dependencies=""/>\n      <Unknown index="6" dependencies=""/>\n    </InitialUnknowns>'
    )

    found = of_note(bad_fmu(tmp_path, xml=edited((lines, "    </InitialUnknowns>"))))

    assert set(found) == {"static.unknowns"}  # the library that we also ask says the same, which is one cause
    assert "lacks 2 of 3: filtered, count" in found["static.unknowns"]


def processes_with(word: str) -> list[int]:
    """Return the running processes whose environment holds a word."""
    return [int(path.parent.name) for path in Path("/proc").glob("[0-9]*/environ") if word.encode() in read(path)]


def read(path: Path) -> bytes:
    """Return a file's content; nothing if it has gone, or belongs to another user."""
    try:
        return path.read_bytes()
    except OSError:
        return b""


def test_an_interrupted_check_leaves_nothing(tmp_path):
    scratch = tmp_path / "scratch"
    scratch.mkdir()
    command = [sys.executable, "-m", "lockstep", "check", str(bad_fmu(tmp_path, "HANGS"))]
    environment = os.environ | {"TMPDIR": str(scratch)}
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, env=environment, text=True)
    while not any(b"fmi2DoStep" in read(path) for path in scratch.glob("*/results/last_call")):
        assert process.poll() is None, process.communicate()
        time.sleep(0.05)
    assert (
        len(processes_with(str(scratch))) == 4
    )  # the check, what its probes are copies of, the guard of a probe, and the probe

    process.send_signal(signal.SIGINT)
    _, result = process.communicate(timeout=60.0)

    assert process.returncode == 130
    assert "Traceback" not in result
    assert list(scratch.iterdir()) == []
    assert processes_with(str(scratch)) == []
