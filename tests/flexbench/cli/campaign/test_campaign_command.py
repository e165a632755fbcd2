"""The command `flexsat campaign`: a campaign of a small FMU, one of its runs again, and what it refuses."""

import re
from pathlib import Path

import pytest

from flexbench.cli.parser import main
from fmus.wanderer.wanderer import wanderer
from lockstep import Component, System, read_signals, write_ssd

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
    assert f"{tmp_path / 'again'}: same rows as in the campaign" in capsys.readouterr().out
    assert set(read_signals(tmp_path / "again")) == {"a.y", "a.began", "a.steps", "a.odd", "a.u"}


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
        (["rerun", "out", "1", "--jobs", "2"], "--scheduler, --jobs: have no effect on `rerun`"),
        (["a.toml", "--jobs", "2", "--scheduler", "tcp://x"], "--jobs: has no effect with --scheduler"),
        (["none.toml"], "none.toml: cannot be read (No such file or directory); give a campaign file"),
    ],
)
def test_wrong_words_are_refused(tmp_path, monkeypatch, capsys, words, message):
    monkeypatch.chdir(tmp_path)
    assert main(["campaign", *words]) == 2
    assert message in capsys.readouterr().err
