"""The command `flexsat campaign`: a campaign of a small FMU, one of its runs again, and what it refuses."""

import json
import re
from pathlib import Path

import pytest

from flexbench.cli.parser import main
from flexbench.engine import fingerprint
from fmus.wanderer.wanderer import wanderer
from lockstep import Component, System, read_signals, write_ssd

REQUIREMENT = """
[[requirement]]
name = "small"
metric = "largest"
most = 1e6
probability = 0.9
"""
START = {"offset": 0.0, "number": 0, "flag": False}
FILE = """
[campaign]
cases = 3
sampling = "random"
[systems]
toy = "toy.ssd"
[input.u]
parameter = "a.u"
distribution = "uniform"
[metric.largest]
of = "a.y"
take = "max"
unit = "um"
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Return a folder with a system of one FMU and a campaign."""
    folder = tmp_path_factory.mktemp("campaign")
    part = Component(name="a", source=wanderer(folder, "toy"), period=1_000_000, kind="sampled", parameters=START,
                     isolated=False)  # fmt: skip
    write_ssd(System(name="toy", tick=1_000_000, stop_time=10**7, components=(part,), connections=()),
              folder / "toy.ssd")  # fmt: skip
    (folder / "toy.toml").write_text(FILE)
    return folder


def test_a_campaign_is_run_and_one_of_its_runs_repeated(folder, tmp_path, capsys):
    assert main(["campaign", str(folder / "toy.toml"), "--out", str(tmp_path / "out"), "--jobs", "3"]) == 0
    captured = capsys.readouterr()
    assert "toy: 3 runs, 3 processes" in captured.out
    assert f"3 runs, 0 failed: {tmp_path / 'out'}" in captured.out
    assert "toy: 3 of 3 runs, 0 failed" in captured.err

    words = [
        "campaign",
        "rerun",
        str(tmp_path / "out"),
        "2",
        "--out",
        str(tmp_path / "again"),
        "--record",
        "inputs:a.u",
    ]
    assert main(words) == 0
    said = capsys.readouterr().out
    assert f"{tmp_path / 'again'}: same rows as in the campaign" in said
    assert re.search(r"^u = 0\.\d+\nlargest: -?\d+(\.\d+)?(e-\d+)? um$", said, re.MULTILINE), said
    assert set(read_signals(tmp_path / "again")) == {"a.y", "a.began", "a.steps", "a.odd", "a.u"}


def test_the_end_of_a_campaign_has_tables_a_page_and_numbers(folder, tmp_path, capsys):
    path, out = folder / "rule.toml", tmp_path / "out"
    path.write_text(FILE.replace("cases = 3", "cases = 70") + REQUIREMENT)
    words = ["campaign", str(path), "--out", str(out), "--stop-when", "probability(small) within 10 %"]
    assert main([*words, "--json", str(tmp_path / "numbers.json")]) == 0
    said = capsys.readouterr().out
    assert "50 runs: probability(small) within 10 %, toy: within 3.5" in said
    assert "ended after 50 runs" in said
    assert "small: met in 50 of 50 runs, a probability of 92.9 % to 100 %; 90.0 % is required and shown." in said
    assert (out / "report.html").is_file()
    numbers = json.loads((tmp_path / "numbers.json").read_text())
    assert numbers["systems"][0]["requirements"][0]["verdict"] == "shown"

    assert main(["campaign", "report", str(out), "--out", str(tmp_path / "page.html"), "--json", "-"]) == 0
    assert json.loads(capsys.readouterr().out) == numbers
    assert (tmp_path / "page.html").read_bytes() == (out / "report.html").read_bytes()
    assert main(["campaign", str(path), "--out", str(out), "--stop-when", "p95(small) within 5 %"]) == 2
    assert "no metric `small`; the campaign has largest" in capsys.readouterr().err


def test_the_probability_of_a_rare_event_is_printed_and_written(folder, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr("lockstep.cli.outcome.on_terminal", lambda: True)
    path = folder / "rare.toml"
    path.write_text(FILE.replace("cases = 3", "cases = 20"))
    assert main(["campaign", "rare", str(path), "largest > 0.2", "--out", str(tmp_path / "out")]) == 0
    said, hint = capsys.readouterr()
    assert "largest > 0.2: probability" in said
    assert f"next: flexsat campaign report {tmp_path / 'out'}" in hint
    assert main(["campaign", "rare", str(path), "largest > 0.2", "--out", str(tmp_path / "out"), "--json", "-"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert f"probability {found['probability']:.2g}, 95 % bounds" in said


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("[metric.largest]", "[metric.x]\nof = 'a.z'\n[metric.largest]"), r"systems.toy: .*a.z"),
        (('parameter = "a.u"', 'parameter = "a.v"'), r"systems\.toy: .*a\.v|systems.toy: a: v"),
        (("uniform", "unifrom"), r"input\.u: distribution = 'unifrom': scipy\.stats has none .*uniform"),
        (
            ('distribution = "uniform"', 'distribution = "uniform"\nwidth = 2'),
            "input.u: width: no parameter of uniform",
        ),
        (("cases = 3", "cases = 0"), "campaign: cases: missing; give how many"),
        (('"random"', '"sobol"'), "cases = 3: Sobol sequences need a power of 2, such as 4"),
        (('"random"', '"grid"'), "campaign: cases: 3: leave it out, with sampling = 'grid'"),
        (('"max"', '"most"'), r"metric\.largest: take = 'most': must be rms, mean"),
        (
            ("[metric.largest]", "[input.again]\nparameter = 'a.u'\nvalues = [1.0]\n[metric.largest]"),
            r"input\.again: a\.u is given by input\.u too; leave one out",
        ),
        (
            ("[metric.largest]", "[set]\n'a.u' = 1.0\n[metric.largest]"),
            r"input\.u: a\.u is given by \[set\] a\.u too; leave one out",
        ),
        (("[systems]", "[system]"), r"wrong\.toml: system: no such key; there are campaign, systems"),
        (("toy.ssd", "no.ssd"), r"no\.ssd: no such file"),
    ],
)
def test_what_is_wrong_is_refused_in_one_line_and_leaves_no_results(folder, tmp_path, capsys, change, message):
    path = folder / "wrong.toml"
    text = FILE.replace(*change)
    assert text != FILE
    path.write_text(text)
    assert main(["campaign", str(path), "--out", str(tmp_path / "out")]) == 2
    (line,) = capsys.readouterr().err.strip().splitlines()[-1:]
    assert re.search(message, line), line
    assert not Path(tmp_path, "out", "campaign.json").exists()


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["a.toml", "b.toml"], "b.toml: give one campaign file, or rerun DIR NUMBER"),
        (["rerun", "out"], "rerun: give the folder of a campaign and the number of a run"),
        (["rerun", "out", "1"], "out: holds no campaign; give the folder of --out"),
        (["a.toml", "--record", "x"], "--record: has an effect with `rerun` only"),
        (["rerun", "out", "1", "--jobs", "2"], "--jobs: no effect on `rerun`; leave it out"),
        (["rerun", "out", "1", "--stop-when", "x"], "--stop-when: no effect on `rerun`"),
        (["report"], "report: give the folder of one campaign"),
        (["report", "out", "--record", "x"], "--record: no effect on `report`"),
        (["rare", "a.toml"], "rare: give a campaign file and an event"),
        (["rare", "a.toml", "x > 1", "--stop-when", "x"], "--stop-when: no effect on `rare`"),
        (["a.toml", "--scheduler", "tcp://x"], "--scheduler: 'tcp://x' is no address; write for example tcp://127"),
        (["a.toml", "--jobs", "2", "--scheduler", "tcp://x:1"], "--jobs: has no effect with --scheduler"),
        (["none.toml"], "none.toml: cannot be read (No such file or directory); give a campaign file"),
    ],
)
def test_wrong_words_are_refused(tmp_path, monkeypatch, capsys, words, message):
    monkeypatch.chdir(tmp_path)
    assert main(["campaign", *words]) == 2
    assert message in capsys.readouterr().err


def test_the_traceback_of_an_unexpected_error_is_kept_until_the_campaign_ends_well(
    folder, tmp_path, capsys, monkeypatch
):
    words = ["campaign", str(folder / "toy.toml"), "--out", str(tmp_path / "out"), "--jobs", "1"]
    with monkeypatch.context() as patched:
        patched.setattr("flexbench.campaign.campaign.write_results", lambda *_: 1 / 0)
        assert main(words) == 70
    file = tmp_path / "out/traceback.txt"
    errors = capsys.readouterr().err
    assert f"{file}: traceback of the error" in errors
    assert "ZeroDivisionError: division by zero: this is a bug of flexsat" in errors
    assert file.read_text().startswith("Traceback")
    assert "in run_campaign" in file.read_text()

    def update(*_):
        monkeypatch.setattr(fingerprint, "_SOURCES", (".py",))  # as if files of C were gone
        raise ImportError("cannot import name 'HEADER'")

    with monkeypatch.context() as patched:
        patched.setattr("flexbench.campaign.campaign.write_results", update)
        assert main(words) == 1
    said = (
        f"the code of flexsat has changed while {tmp_path / 'out'} was simulated (cannot import name 'HEADER'); restore"
    )
    assert said in capsys.readouterr().err
    monkeypatch.undo()

    assert main(words) == 0
    assert not file.exists()
