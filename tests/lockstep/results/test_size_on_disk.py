"""The size of the recorded signals is stated: in run.toml, in the summary, and by the command."""

import tomllib

import pytest

from fmus.wanderer.wanderer import wanderer
from lockstep import Component, RunError, System, simulate
from lockstep.cli.progress import in_bytes, print_summary

STEP = 1_000_000  # [ns]


@pytest.fixture(scope="module")
def system(tmp_path_factory):
    fmu = wanderer(tmp_path_factory.mktemp("fmu"), "good")
    part = Component(name="a", source=fmu, period=STEP, kind="sampled", isolated=False, parameters={"seed": 5})
    return System(name="demo", tick=STEP, components=(part,), stop_time=1200 * STEP, record=("a.y", "a.steps"))


def record_of(folder):
    return tomllib.loads((folder / "run.toml").read_text(encoding="utf-8"))["recorded"]


def test_the_size_is_that_of_the_file(system, tmp_path, capsys):
    summary = simulate(system, tmp_path / "out")
    size = (tmp_path / "out/signals.parquet").stat().st_size
    assert summary.size == size
    assert record_of(tmp_path / "out") == {"signals": 2, "rows": 1201, "size": size}
    print_summary(summary)
    assert f" x real time), 1201 rows in {in_bytes(size)}: {tmp_path}" in capsys.readouterr().out


def test_a_run_in_memory_takes_no_room_on_disk(system, capsys):
    summary = simulate(system)
    assert summary.size == 0
    print_summary(summary)
    assert "rows in" not in capsys.readouterr().out


def test_what_a_failed_run_has_recorded_is_stated(system, tmp_path, monkeypatch):
    def full(*_, **__):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("lockstep.results.conversion.pq.ParquetWriter.write_table", full)
    with pytest.raises(RunError, match="No space left"):
        simulate(system, tmp_path / "out")
    size = (tmp_path / "out/signals.arrows").stat().st_size
    assert record_of(tmp_path / "out") == {"signals": 2, "rows": 1201, "size": size}


@pytest.mark.parametrize(
    ("size", "text"), [(0, "0 bytes"), (999, "999 bytes"), (1500, "1.5 kB"), (86_839_256, "86.8 MB"), (3e12, "3.0 TB")]
)
def test_sizes_have_units(size, text):
    assert in_bytes(size) == text
