"""What is unpacked of an FMU to run it, and when the digest of its file is computed again."""

import hashlib
import zipfile

import pytest

from lockstep import Component
from lockstep.fmi import safe_zip
from lockstep.fmi.library import unpack_fmu

MEMBERS = {
    "modelDescription.xml": True,
    "binaries/linux64/a.so": True,
    "resources/sources/table.txt": True,
    "terminalsAndIcons/icon.png": True,
    "documentation/licenses/license.txt": True,
    "documentation/index.html": False,
    "sources/plant.c": False,
}


def test_sources_and_pages_stay_packed(tmp_path):
    with zipfile.ZipFile(tmp_path / "a.fmu", "w") as archive:
        for name in MEMBERS:
            archive.writestr(name, name)
    unpack_fmu(Component(name="a", source=tmp_path / "a.fmu", period=1), tmp_path / "out")
    found = {path.relative_to(tmp_path / "out").as_posix() for path in (tmp_path / "out").rglob("*") if path.is_file()}
    assert found == {name for name, needed in MEMBERS.items() if needed}


def digest(path):
    """Return the digest, and check it against that of the content."""
    with path.open("rb") as stream:
        found = safe_zip.sha256_of(stream, on_disk=True)
    assert found == hashlib.sha256(path.read_bytes()).hexdigest()
    return found


def test_a_file_is_hashed_again_when_it_may_have_changed(tmp_path, monkeypatch):
    path = tmp_path / "a.fmu"
    monkeypatch.setattr(safe_zip, "_digests", {})
    for content in (b"one", b"two"):  # a file just written is not remembered: its times may stay the same
        path.write_bytes(content)
        digest(path)
        assert not safe_zip._digests
    later = path.stat().st_ctime + 10.0
    monkeypatch.setattr(safe_zip, "time", lambda: later)
    settled = digest(path)
    assert list(safe_zip._digests.values()) == [settled]
    with path.open("rb") as stream:
        assert safe_zip.sha256_of(stream, on_disk=True) == settled
        assert stream.tell() == 0  # it was not read
    path.unlink()
    path.write_bytes(b"six")  # of the same size
    assert digest(path) != settled


def test_a_copy_holds_what_was_unpacked_and_a_copy_that_fails_names_its_first_reason_alone(tmp_path):
    unpacked = tmp_path / "unpacked"
    (unpacked / "resources" / "empty").mkdir(parents=True)
    (unpacked / "resources" / "data").write_bytes(b"\0\1")
    safe_zip.copy_extracted(unpacked, tmp_path / "copy", "a.fmu")
    there = {path.relative_to(tmp_path / "copy").as_posix() for path in (tmp_path / "copy").rglob("*")}

    assert there == {"resources", "resources/data", "resources/empty"}
    assert (tmp_path / "copy/resources/data").read_bytes() == b"\0\1"
    for name in ("first", "second"):
        (unpacked / name).symlink_to("gone")
    with pytest.raises(safe_zip.TemporaryFolderError) as raised:
        safe_zip.copy_extracted(unpacked, tmp_path / "again", "a.fmu")
    assert str(raised.value) == (
        f"a.fmu: cannot be unpacked to {tmp_path / 'again'} (No such file or directory); "
        "free space there, or set TMPDIR to another folder"
    )
