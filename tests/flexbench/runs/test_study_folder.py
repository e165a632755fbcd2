"""The folder of a study: a new one by default, the one asked for otherwise, and one study at a time."""

from pathlib import Path

import pytest

from flexbench.runs.study_folder import study_folder
from lockstep import InputError


def test_a_default_folder_gets_the_next_number_if_it_holds_anything(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name in ("health", "health-2", "health-3"):
        with study_folder(None, "health") as folder:
            assert folder == Path("results", name)
            (folder / "health.json").touch()
    with study_folder(None, "paper") as one, study_folder(None, "paper") as two:  # at the same time
        assert (one, two) == (Path("results/paper"), Path("results/paper-2"))
    assert sorted(path.name for path in Path("results").iterdir()) == ["health", "health-2", "health-3"]


def test_a_folder_that_is_asked_for_may_hold_an_earlier_study(tmp_path):
    out = tmp_path / "mine"
    for _ in range(2):
        with study_folder(out, "health") as folder:
            assert folder == out
            (folder / "health.json").touch()
            with pytest.raises(InputError, match=r"/mine: another run is writing to it"), study_folder(out, "health"):
                pass
    assert [path.name for path in out.iterdir()] == ["health.json"]
