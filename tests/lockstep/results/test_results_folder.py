"""A results folder belongs to one run at a time, is filled in place, and is never left half-replaced."""

import os
import stat
from contextlib import suppress
from pathlib import Path

import pytest

from lockstep import InputError
from lockstep.results.results_folder import claim, claim_earlier, claim_shared

OLD = {"run.toml": "old", "events.jsonl": "events", "signals.parquet": "rows", "checkpoints": None}
NEW = {"status": "running"}


def earlier_run(folder):
    """Make the folder of an earlier run."""
    folder.mkdir(parents=True)
    for name, text in OLD.items():
        if text is None:
            (folder / name).mkdir()
        else:
            (folder / name).write_text(text)
    return folder


def names(folder):
    return sorted(path.name for path in folder.iterdir())


def test_a_second_run_is_refused_in_one_line_until_the_first_ends(tmp_path):
    with claim(tmp_path / "out") as first:
        for again in (claim, claim_shared):
            with pytest.raises(InputError, match=r"^/.*/out: another run is writing to it; choose another folder, or"):
                again(tmp_path / "out")
        with pytest.raises(InputError, match=r"another run is writing to it"):
            claim(tmp_path / "out", overwrite=True)
        with pytest.raises(InputError, match=r"out: its run is still going on; end it before it is resumed$"):
            claim_earlier(tmp_path / "out")
        first.fill(NEW)
    with claim_earlier(tmp_path / "out"), pytest.raises(InputError, match="another run is writing to it"):
        claim(tmp_path / "out", overwrite=True)
    with pytest.raises(InputError, match=r"holds a run already; choose another folder, or replace it \(--overwrite\)"):
        claim(tmp_path / "out")
    with claim(tmp_path / "out", overwrite=True):
        pass
    assert names(tmp_path / "out") == ["run.toml"]


def test_what_a_run_without_a_result_made_is_removed_and_nothing_else(tmp_path):
    with claim(tmp_path / "a/b/out"), claim(tmp_path / "a/c"):
        assert (tmp_path / "a/b/out").is_dir()
    assert names(tmp_path) == []
    with claim(tmp_path / "a/b/out") as inner:
        (tmp_path / "a/mine").touch()
        (tmp_path / "empty").mkdir()
        with claim(tmp_path / "empty"):
            pass
    inner.unlock()  # again, which does nothing
    assert (names(tmp_path), names(tmp_path / "a")) == (["a", "empty"], ["mine"])


def test_an_empty_folder_is_filled_in_place(tmp_path, monkeypatch):
    (tmp_path / "real").mkdir(mode=0o750)
    (tmp_path / "link").symlink_to("real")
    monkeypatch.chdir(tmp_path / "real")
    before = Path.cwd().stat()
    for given in (".", tmp_path / "link"):  # the second overwrites the first
        with claim(given, overwrite=True) as folder:
            folder.fill(NEW)
        after = Path.cwd().stat()
        assert (after.st_ino, stat.S_IMODE(after.st_mode), names(Path())) == (before.st_ino, 0o750, ["run.toml"])
    assert (tmp_path / "link").is_symlink()


@pytest.mark.parametrize(("mask", "mode"), [(0o022, 0o755), (0o027, 0o750), (0o002, 0o775)])
def test_permissions_of_a_new_folder_follow_the_umask(tmp_path, mask, mode):
    before = os.umask(mask)
    try:
        with claim(tmp_path / "out") as folder:
            folder.fill(NEW)
    finally:
        os.umask(before)
    found = [stat.S_IMODE(path.stat().st_mode) for path in (tmp_path / "out", tmp_path / "out/run.toml")]
    assert found == [mode, mode & 0o666]


def test_a_default_folder_gets_the_next_free_number(tmp_path):
    (tmp_path / "out-2").mkdir()
    (tmp_path / "out-2/other.txt").touch()
    (tmp_path / "out-3").touch()
    with claim(tmp_path / "out", numbered=True) as one, claim(tmp_path / "out", numbered=True) as two:
        assert (one.path.name, two.path.name) == ("out", "out-4")
        one.fill(NEW)
    with claim(tmp_path / "out", numbered=True) as three:
        assert three.path.name == "out-4"  # it was made for nothing, and removed


@pytest.mark.parametrize("made", ["file", "dangling link", "other files"])
def test_what_cannot_be_a_results_folder_is_kept_and_named(tmp_path, made):
    out = tmp_path / "out"
    match made:
        case "file":
            out.write_text("keep")
        case "dangling link":
            out.symlink_to("nowhere")
        case _:
            out.mkdir()
            (out / "precious.txt").write_text("keep")
    message = "holds other files and no run" if made == "other files" else "is no folder"
    with pytest.raises(InputError, match=f"/out: {message}; choose another results folder$"):
        claim(out, overwrite=True)
    assert os.path.lexists(out)
    assert made != "file" or out.read_text() == "keep"


def failing_at(number, fail):
    """Return a replacement of Path.rename whose call of this number fails."""
    rename, calls = Path.rename, iter(range(1000))

    def call(self, target):
        if next(calls) == number:
            fail()
        return rename(self, target)

    return call


def no_space():
    raise OSError(28, "No space left on device")


@pytest.mark.parametrize("number", range(len(OLD) + 1))
def test_a_rename_that_fails_half_way_leaves_the_earlier_run(tmp_path, monkeypatch, number):
    out = earlier_run(tmp_path / "out")
    with claim(out, overwrite=True) as folder, monkeypatch.context() as patch:
        patch.setattr(Path, "rename", failing_at(number, no_space))
        with pytest.raises(InputError, match=r"/out: cannot be made \(No space left on device\); choose another"):
            folder.fill(NEW)
    assert {path.name: None if path.is_dir() else path.read_text() for path in out.iterdir()} == OLD


@pytest.mark.skipif(not hasattr(os, "fork"), reason="a copy of this process is killed")
@pytest.mark.parametrize("number", range(len(OLD) + 2))
def test_a_kill_while_a_run_is_replaced_leaves_the_earlier_or_the_new_one(tmp_path, monkeypatch, number):
    out = earlier_run(tmp_path / "out")
    child = os.fork()
    if child == 0:
        with suppress(BaseException):
            monkeypatch.setattr(Path, "rename", failing_at(number, lambda: os._exit(9)))
            claim(out, overwrite=True).fill(NEW)
        os._exit(0)
    _, status = os.waitpid(child, 0)
    killed = number <= len(OLD)
    assert os.waitstatus_to_exitcode(status) == (9 if killed else 0)

    with claim(out, overwrite=True):
        found = {path.name: None if path.is_dir() else path.read_text() for path in out.iterdir()}
    assert found == OLD if killed else sorted(found) == ["run.toml"]
