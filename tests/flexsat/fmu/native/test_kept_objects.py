"""Objects that are kept between processes: taken if all that they follow from is equal, and only if they are whole."""

import os
import shutil

import pytest

from flexsat.errors import BuildError
from flexsat.fmu.native import compile as compilation
from flexsat.fmu.native import kept_objects
from flexsat.fmu.native.compile import compile_library

UNIT = b'#include "x.h"\n#include <math.h>\ndouble x(double y) { return FACTOR * floor(y); }\n'
SOURCES = {"x.c": UNIT, "x.h": b"#define FACTOR 2.0\n"}

pytestmark = pytest.mark.skipif(shutil.which("gcc") is None, reason="units are compiled with gcc")


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.setenv(kept_objects.VARIABLE, str(tmp_path / "objects"))
    return tmp_path / "objects"


@pytest.fixture
def compiled(monkeypatch):
    """Return the units that the compiler has been started for."""
    units = []
    run = compilation._compiled
    monkeypatch.setattr(compilation, "_compiled", lambda *what: units.append(what[1]) or run(*what))
    return units


def library(sources=SOURCES):
    """Compile as another process does: without what this one knows."""
    for known in (compilation._object, compilation._headers):
        known.cache_clear()
    return compile_library(sources, "x")


def test_a_kept_object_gives_the_library_that_compiling_gives(folder, compiled, monkeypatch):
    first, second = library(), library()
    assert compiled == ["x.c"]
    monkeypatch.delenv(kept_objects.VARIABLE)
    assert first == second == library()
    assert compiled == ["x.c"] * 2
    assert [path.suffix for path in folder.iterdir()] == [".o"]


def test_what_an_object_follows_from_makes_another(folder, compiled, monkeypatch, tmp_path):
    first = library()
    header = library(SOURCES | {"x.h": b"#define FACTOR 3.0\n"})
    assert header != first
    (tmp_path / "math.h").write_text("#include_next <math.h>\n#define floor ceil\n")
    monkeypatch.setenv("CPATH", str(tmp_path))  # as where the C library has been updated
    assert library() not in (first, header)
    monkeypatch.delenv("CPATH")
    options = [option.replace("=hidden", "=default") for option in compilation._COMPILING]  # which no macro shows
    monkeypatch.setattr(compilation, "_COMPILING", tuple(options))
    assert library() != first
    monkeypatch.undo()
    assert len(compiled) == len(list(folder.iterdir())) == 4


@pytest.mark.usefixtures("folder")
def test_another_compiler_makes_another_object(compiled, monkeypatch, tmp_path):
    library()
    program = tmp_path / "cc"
    program.write_text('#!/bin/sh\nexec gcc "$@"\n')
    program.chmod(0o755)
    monkeypatch.setenv("CC", str(program))
    library()
    os.utime(program, (1, 1))  # an update
    library()
    library()
    assert len(compiled) == 3


def test_a_damaged_object_is_compiled_again(folder, compiled):
    first = library()
    (kept,) = folder.iterdir()
    for damaged in (b"", kept.read_bytes()[:-1], kept.read_bytes()[:-9] + b"\1" + kept.read_bytes()[-8:]):
        kept.write_bytes(damaged)
        assert library() == first
    assert len(compiled) == 4
    assert library() == first
    assert len(compiled) == 4


def test_the_oldest_are_removed_where_there_are_too_many(folder, monkeypatch):
    monkeypatch.setattr(kept_objects, "MOST_BYTES", 1000)
    for number in range(9):
        content = bytes([number]) * 68  # 100 with the digest
        assert kept_objects.kept_object([bytes([number])], lambda made=content: made) == content
    for number, path in enumerate(sorted(folder.iterdir(), key=lambda path: path.read_bytes()[-1])):
        os.utime(path, (number, number))
    (folder / "else").write_bytes(bytes(5000))  # not of this cache
    for number in (9, 10):
        kept_objects.kept_object([bytes([number])], lambda: bytes([number]) * 68)  # noqa: B023
    left = sorted(path.read_bytes()[-1] for path in folder.glob("*.o"))
    assert left == [6, 7, 8, 9, 10]
    assert (folder / "else").exists()


def test_a_folder_that_cannot_be_written_to_is_refused_in_one_line(tmp_path, monkeypatch):
    (tmp_path / "file").touch()
    monkeypatch.setenv(kept_objects.VARIABLE, str(tmp_path / "file" / "objects"))
    with pytest.raises(BuildError, match=r"FLEXSAT_OBJECTS=.*objects: Not a directory; name a folder that can be"):
        library()


def test_a_unit_that_fails_is_not_kept(folder):
    with pytest.raises(BuildError, match=r"cannot compile x\.c"):
        library({"x.c": b"nonsense"})
    assert not folder.exists()


def test_without_the_variable_nothing_is_kept(folder, compiled, monkeypatch):
    monkeypatch.setenv(kept_objects.VARIABLE, "")
    library()
    library()
    assert compiled == ["x.c"] * 2
    assert not folder.exists()
