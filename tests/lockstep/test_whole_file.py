"""Files are written whole or not at all, with the permissions that the umask leaves."""

import os
import resource
import stat

import pytest

from lockstep.whole_file import write_whole


def test_file_is_replaced_with_the_permissions_of_the_umask(tmp_path):
    path = tmp_path / "new/file.txt"
    before = os.umask(0o027)
    try:
        write_whole(path, b"one")
        write_whole(path, b"two")
    finally:
        os.umask(before)
    assert (path.read_bytes(), stat.S_IMODE(path.stat().st_mode)) == (b"two", 0o640)
    assert [entry.name for entry in path.parent.iterdir()] == ["file.txt"]


def test_full_disk_leaves_the_old_file_and_nothing_else(tmp_path):
    path = tmp_path / "file.txt"
    path.write_bytes(b"old")
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (100, limits[1]))
    try:
        with pytest.raises(OSError, match=r"File too large: '.*/file\.txt'"):
            write_whole(path, bytes(200))
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    assert (path.read_bytes(), list(tmp_path.iterdir())) == (b"old", [path])
