"""Options of real time and of the profile: what the command prints and records."""

import tomllib

import pytest

from fmus.wanderer.wanderer import wanderer
from lockstep import Component, System, write_ssd
from lockstep.__main__ import PROGRAM

MS = 1_000_000  # [ns]


@pytest.fixture(scope="module")
def demo(tmp_path_factory):
    folder = tmp_path_factory.mktemp("fmu")
    fmu = wanderer(folder, "good")
    part = Component(name="a", source=fmu, period=5 * MS, kind="sampled", isolated=False)
    write_ssd(System(name="demo", tick=5 * MS, components=(part,), stop_time=20 * MS, record=("a.y",)),
              folder / "demo.ssd")  # fmt: skip
    return folder / "demo.ssd"


def test_a_paced_run_says_so(demo, tmp_path, capsys):
    words = ["run", str(demo), "--set", "a.u=1", "--pace", "0.25", "--out", str(tmp_path / "out")]
    words += ["--core", "4095", "--realtime-priority", "1000", "--profile"]  # of which no system has the numbers
    assert PROGRAM.run(words) == 0
    record = tomllib.loads((tmp_path / "out" / "run.toml").read_text(encoding="utf-8"))

    said = capsys.readouterr()
    assert "paced at 0.25 x real time" in said.out
    assert record["wall_time"] > 0.9 * 0.02 / 0.25
    lines = said.out.splitlines()
    begin = next(k for k, line in enumerate(lines) if line.startswith("a  "))
    rows = [line.split() for line in lines[begin : begin + 6]]
    assert [row[0] for row in rows] == ["a", "exchange", "recording", "waiting", "rest", "all"]
    assert rows[0][1] == "4"
    assert "\nticks by how late they began:\n" in said.out
    assert "warning: core 4095: the run goes on without it" in said.err
    assert "warning: real-time priority 1000: the run goes on without it" in said.err
    assert record["real_time"] == {"core": 4095, "core_used": False, "priority": 1000, "priority_used": False}
    assert sum(record["pace"]["lateness_counts"]) == 5
