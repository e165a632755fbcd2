"""Static checks of the archive and of its members."""

import stat
import warnings
import zipfile
from pathlib import Path

import pytest

from ..conftest import BINARY, XML, Find, Make, bad, text_of


@pytest.mark.parametrize(
    ("member", "status", "says"),
    [
        ("../outside.txt", "error", "leaves the folder"),
        ("/etc/passwd", "error", "leaves the folder"),
        ("resources\\data.txt", "error", "backslash"),
        ("resources/__pycache__/model.cpython-311.pyc", "warning", "left behind"),
        (".git/config", "warning", "left behind"),
        ("resources/.DS_Store", "warning", "left behind"),
        ("resources/model.py~", "warning", "left behind"),
        ("Documentation/index.html", "warning", "upper and lower case"),
    ],
)
def test_unsafe_or_left_behind_member_is_reported(make: Make, found: Find, member: str, status: str, says: str) -> None:
    findings = found(make({member: "x"}))

    assert findings["static.hygiene"].status == status
    assert says in text_of(findings["static.hygiene"])
    assert set(bad(findings)) <= {"static.hygiene", "static.fmpy"}  # FMPy refuses backslashes too


def test_duplicate_member_is_reported(make: Make, found: Find) -> None:
    path = make()
    with (
        zipfile.ZipFile(path, "a") as archive,
        pytest.warns(UserWarning, match="Duplicate"),
    ):
        archive.writestr("documentation/index.html", "another")

    assert bad(found(path)) == {"static.hygiene": "error"}


def test_symbolic_link_is_reported(make: Make, found: Find) -> None:
    path = make()
    link = zipfile.ZipInfo("resources/link")
    link.external_attr = (stat.S_IFLNK | 0o777) << 16
    with zipfile.ZipFile(path, "a") as archive:
        archive.writestr(link, "/etc/passwd")

    assert "symbolic link" in text_of(found(path)["static.hygiene"])


def test_unusual_compression_is_reported(make: Make, found: Find) -> None:
    path = make()
    with zipfile.ZipFile(path, "a", zipfile.ZIP_LZMA) as archive:
        archive.writestr("resources/data.bin", b"0" * 100)

    assert bad(found(path)) == {"static.hygiene": "error"}
    assert "method 14" in text_of(found(path)["static.hygiene"])


def test_encrypted_member_is_reported(make: Make, found: Find) -> None:
    path = make({"resources/secret.txt": "x"})
    content = path.read_bytes()
    for signature, offset in ((b"PK\3\4", 6), (b"PK\1\2", 8)):  # both headers carry the flag
        at = content.rindex(b"resources/secret.txt") if offset == 8 else content.index(b"resources/secret.txt")
        start = content.rindex(signature, 0, at)
        content = content[: start + offset] + b"\1" + content[start + offset + 1 :]
    path.write_bytes(content)

    assert "resources/secret.txt: encrypted" in text_of(found(path)["static.hygiene"])


def test_damaged_member_is_reported(make: Make, found: Find) -> None:
    path = make({"resources/data.txt": "value=123"})
    with zipfile.ZipFile(path, "a", zipfile.ZIP_STORED) as archive:
        archive.writestr("resources/plain.txt", "value=123456789")
    path.write_bytes(path.read_bytes().replace(b"value=123456789", b"value=123456780"))

    assert bad(found(path)) == {"static.archive": "error"}
    assert "resources/plain.txt" in text_of(found(path)["static.archive"])


@pytest.mark.parametrize("content", [b"", b"no zip", b"PK\3\4" + b"\0" * 200])
def test_file_that_is_not_an_archive_is_reported(tmp_path: Path, found: Find, content: bytes) -> None:
    path = tmp_path / "vendor.fmu"
    path.write_bytes(content)
    findings = found(path)

    assert findings["static.archive"].status == findings["static.kind"].status == "error"
    assert {f.status for check, f in findings.items() if check not in ("static.archive", "static.kind")} == {"skipped"}


def test_truncated_archive_is_reported(make: Make, found: Find) -> None:
    path = make()
    path.write_bytes(path.read_bytes()[:-100])

    assert found(path)["static.archive"].status == "error"


def test_missing_model_description_is_reported(make: Make, found: Find) -> None:
    findings = found(make({"modelDescription.xml": None, "Good/modelDescription.xml": XML}))

    assert findings["static.kind"].status == "error"
    assert "not at the top" in text_of(findings["static.kind"])


@pytest.mark.parametrize(
    ("member", "check"),
    [("documentation/index.html", "static.documentation"), ("documentation/licenses/license.txt", "static.licence")],
)
def test_missing_documentation_or_licence_is_reported(make: Make, found: Find, member: str, check: str) -> None:
    assert bad(found(make({member: None}))) == {check: "warning"}


def test_binary_under_another_name_is_reported(make: Make, found: Find, library: bytes) -> None:
    findings = found(make({BINARY: None, "binaries/linux64/model.so": library}))

    assert findings["static.platforms"].status == "error"
    assert "good.so" in text_of(findings["static.platforms"])
    assert findings["static.functions"].status == findings["static.dependencies"].status == "skipped"


@pytest.mark.parametrize(
    ("folder", "there"),
    [("binaries/win64/good.dll", "win64"), ("sources/good.c", "source code only"), ("resources/x", "none")],
)
def test_missing_binary_for_this_platform_is_reported(make: Make, found: Find, folder: str, there: str) -> None:
    findings = found(make({BINARY: None, folder: b"MZ"}))

    assert findings["static.platforms"].status == "error"
    assert there in text_of(findings["static.platforms"])


@pytest.mark.parametrize(
    ("member", "says"),
    [
        ("binaries/win64/other.dll", "binaries/win64 lacks good.dll, the file that modelIdentifier names"),
        ("binaries/win64/good.dll", "binaries/win64/good.dll is no Windows library"),
        ("binaries/darwin64/good.dylib", "binaries/darwin64/good.dylib is no macOS library"),
        ("binaries/linux32/good.so", "binaries/linux32/good.so is no ELF file"),
        ("binaries/aarch64-linux/good.so", "binaries/aarch64-linux/good.so is no ELF file"),
    ],
)
def test_fault_of_another_platform_is_a_warning(make: Make, found: Find, member: str, says: str) -> None:
    findings = found(make({member: b"nothing"}))

    assert (findings["static.platforms"].status, findings["static.platforms"].message) == ("warning", says)


def test_members_of_one_name_are_an_error_only_if_they_differ(make: Make, found: Find) -> None:
    path = make()
    for content, status, which in ((b"a", "pass", ""), (b"a", "warning", "alike"), (b"b", "error", "which differ")):
        with zipfile.ZipFile(path, "a") as archive, warnings.catch_warnings():
            warnings.simplefilter("ignore")  # zipfile warns of the second member
            archive.writestr("extra/list.txt", content)
        hygiene = found(path)["static.hygiene"]
        assert (hygiene.status, which in hygiene.message) == (status, True)
