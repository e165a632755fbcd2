"""The store of files of a machine: it holds what is used, and does not grow without bound."""

import os
import time

import pytest

from flexbench.engine import content
from flexbench.engine.content import File, found, put, receive
from lockstep.whole_file import file_digest

HOUR, DAY = 3600.0, 86400.0


@pytest.fixture
def store(tmp_path, monkeypatch):
    """Return the machine's store, empty."""
    monkeypatch.setattr(content.tempfile, "tempdir", str(tmp_path))
    return content._own()


def file_of(tmp_path, data):
    (tmp_path / "data.fmu").write_bytes(data)
    return File(digest=file_digest(tmp_path / "data.fmu"), suffix=".fmu")


def make_old(path, age):
    """Give a file the times of one that was last used so long ago."""
    then = time.time() - age
    os.utime(path, (then, then))


def test_what_was_not_used_for_a_week_is_removed_once_files_come(tmp_path, store):
    old, used, new = (file_of(tmp_path, data) for data in (b"old", b"used", b"new"))
    receive({old: b"old", used: b"used"})
    for file in (old, used):
        make_old(store / file.name, 8 * DAY)
    (store / ".cut-1").write_bytes(b"of a process that was killed")
    make_old(store / ".cut-1", 2 * HOUR)

    assert set(found([used], None)) == {used}  # read, and known from then on
    os.utime(store / used.name, (time.time() - 8 * DAY, (store / used.name).stat().st_mtime))
    assert set(found([used], None)) == {used}  # a use, though it is not read again
    receive({new: b"new"})

    assert {one.name for one in store.iterdir()} == {used.name, new.name}
    assert found([old, used, new], None).keys() == {used, new}


def test_beyond_its_size_the_longest_unused_files_go_and_none_in_use(tmp_path, store, monkeypatch):
    files = [file_of(tmp_path, bytes([k]) * 100) for k in range(4)]
    receive({file: bytes([k]) * 100 for k, file in enumerate(files)})
    for file, age in zip(files, (5 * HOUR, 3 * DAY, 4 * HOUR, 0.1 * HOUR), strict=True):
        make_old(store / file.name, age)

    monkeypatch.setattr(content, "MOST", 250)
    receive({})
    assert [file in found([file], None) for file in files] == [False, False, True, True]

    monkeypatch.setattr(content, "MOST", 50)
    make_old(store / files[2].name, 2 * HOUR)
    receive({})
    assert [file in found([file], None) for file in files] == [False, False, False, True]


def test_files_of_a_campaign_are_left_as_they_are(tmp_path, store):
    (tmp_path / "a.fmu").write_bytes(b"a")
    file = put(tmp_path / "a.fmu", tmp_path / "campaign")
    make_old(tmp_path / "campaign" / file.name, 30 * DAY)

    assert found([file], tmp_path / "campaign") == {file: tmp_path / "campaign" / file.name}
    receive({})
    assert (tmp_path / "campaign" / file.name).read_bytes() == b"a"
    assert not any(store.iterdir())
