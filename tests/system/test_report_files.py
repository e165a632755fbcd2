"""Files of the report: parts of arrays, PDF, refused input, and the example that loads a run."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from browser_pages import needs_browser
from flexbench.cli.parser import main
from flexbench.report import pdf, study_sections, write_report

ROOT = Path(__file__).parents[2]
SHORT = ("run", "--native", "--accept-infeasible")  # ends before the slew


@pytest.fixture(scope="module")
def runs(slews):
    """Return the folder of two runs of 8 s."""
    return slews


@pytest.fixture
def report(monkeypatch):
    """Return a function that writes a page without the sections of the studies, which take seconds each."""
    monkeypatch.setattr(study_sections, "SECTIONS", ())
    return write_report


def test_run_with_parts_of_arrays_has_a_page_of_these(tmp_path, fmus, flexsat, report):
    parts = ["plant.modal.displacement[3]", "plant.wheel.speed[2]", "plant.attitude.mrp[1]", "controller.reference.mrp"]
    record = [word for part in parts for word in ("--record", part)]
    ran = flexsat(*SHORT, fmus / "centralised" / "slew.ssd", "--stop-time", "0.5", *record, "--out", tmp_path / "run")
    assert ran.returncode == 0, ran.stderr

    report([tmp_path / "run"])

    text = (tmp_path / "run" / "report.html").read_text(encoding="utf-8")
    result = json.loads(text.partition('id="contents">')[2].partition("</script>")[0])
    assert result["runs"][0]["motion"] is None
    assert set(result["panels"]) == {part.partition("[")[0] for part in parts}  # no norm of a part of an array


@needs_browser
def test_pdf_on_request(runs, report, tmp_path):
    written = report([runs / "centralised-slew"], tmp_path / "page.html", pdf=True)

    assert written == [tmp_path / "page.html", tmp_path / "page.pdf"]
    content = written[1].read_bytes()
    assert content.startswith(b"%PDF-")
    assert len(content) > 100_000  # with its pictures
    assert sorted(path.name for path in tmp_path.iterdir()) == ["page.html", "page.pdf"]


def test_pdf_without_a_browser_is_refused_and_nothing_is_written(runs, report, tmp_path, monkeypatch):
    monkeypatch.setattr(pdf, "BROWSERS", ("no-such-browser",))
    with pytest.raises(ValueError, match="install chromium"):
        report([runs / "centralised-slew"], tmp_path / "page.html", pdf=True)
    assert list(tmp_path.iterdir()) == []


def test_bad_input_gives_one_line(runs, capsys, tmp_path):
    for arguments, message in (
        (("report", tmp_path / "none"), "no such folder"),
        (("report", tmp_path), "holds no run.toml"),
        (("report", runs / "centralised-slew", runs / "centralised-slew"), "given twice"),
        (("report", runs / "centralised-slew", "--out", tmp_path), "is a folder"),
        (("report",), "RESULTS"),
        (("export", runs / "centralised-slew"), "--format"),
        (("export", runs / "centralised-slew", "--format", "csv", "--signals", "plant.rat"), "did you mean plant.rate"),
    ):
        code = main([str(argument) for argument in arguments])
        error = capsys.readouterr().err
        assert code == 2, arguments
        assert len(error.splitlines()) == 1, error
        assert message in error
    assert list(tmp_path.iterdir()) == []


def test_example_script_runs(runs):
    done = subprocess.run(
        [sys.executable, ROOT / "examples" / "look_at_a_run.py", runs / "distributed-slew"],
        check=False, capture_output=True, text=True,
    )  # fmt: skip

    assert done.returncode == 0, done.stderr
    assert "plant.wheel.speed" in done.stdout
    assert "33 wheel" in done.stdout
