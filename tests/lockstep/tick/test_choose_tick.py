"""Which implementation executes the ticks: as it is chosen, where there is no compiler, and what run.toml says."""

import os
import subprocess
import tomllib

import pytest

from lockstep import InputError, simulate
from lockstep.__main__ import main
from lockstep.run.choose_tick import choose_tick
from lockstep.tick import compiled
from lockstep.tick.operations import Times

MS = 1_000_000


@pytest.fixture
def uncached(monkeypatch):
    """Look for the library anew in this test, and after it."""
    compiled._load.cache_clear()
    yield monkeypatch
    compiled._load.cache_clear()


def test_the_command_line_chooses_and_the_record_says_which(loop_ssd, tmp_path):
    def run(*options):
        assert main(["run", str(loop_ssd), "--out", str(tmp_path / "out"), "--overwrite", *options]) == 0
        return tomllib.loads((tmp_path / "out/run.toml").read_text()), (tmp_path / "out/signals.parquet").read_bytes()

    (plain, signals), (python, same), (c, equal) = run(), run("--tick", "python"), run("--tick", "c", "--tick", "0.001")
    assert (plain["tick_in"], python["tick_in"], c["tick_in"]) == ("c", "python", "c")
    assert "tick_in_reason" not in plain
    assert signals == same == equal


@pytest.mark.parametrize(
    ("options", "line"),
    [
        (("--tick", "c", "--tick", "python"), "--tick python: given already, as c; choose one"),
        (("--tick", "1", "--tick", "2"), "--tick 2: given already, as 1; give one base tick"),
        (("--tick", "rust"), "--tick: 'rust' is not a number of seconds"),
    ],
)
def test_a_bad_choice_is_refused_by_name(loop_ssd, capsys, tmp_path, options, line):
    assert main(["run", str(loop_ssd), "--out", str(tmp_path / "out"), *options]) == 2
    assert line in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_without_a_compiler_python_runs_and_c_is_refused(loop, tmp_path, uncached):
    uncached.setenv("PATH", str(tmp_path))
    uncached.delenv("CC", raising=False)
    uncached.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    summary = simulate(loop, tmp_path / "auto")
    record = tomllib.loads((summary.folder / "run.toml").read_text())
    assert record["tick_in"] == "python"
    assert "there is no C compiler in PATH" in record["tick_in_reason"]
    with pytest.raises(InputError, match=r"tick in C: there is no C compiler.*; or choose auto or python"):
        simulate(loop, tmp_path / "c", tick="c")
    assert not (tmp_path / "c").exists()


def test_the_library_is_compiled_once_and_anew_for_another_source(tmp_path, uncached):
    uncached.setenv("XDG_CACHE_HOME", str(tmp_path))
    first = compiled.compiled(compiled.find_compiler())
    made = first.stat().st_mtime_ns
    assert compiled.compiled(compiled.find_compiler()) == first
    assert first.stat().st_mtime_ns == made
    assert [path.name for path in (tmp_path / "lockstep").iterdir()] == [first.name]
    uncached.setattr(compiled, "OPTIONS", (*compiled.OPTIONS, "-O1"))
    assert compiled.compiled(compiled.find_compiler()) != first


def test_a_folder_that_others_can_write_is_not_used(tmp_path, uncached):
    uncached.setenv("XDG_CACHE_HOME", str(tmp_path))
    (tmp_path / "lockstep").mkdir()
    (tmp_path / "lockstep").chmod(0o777)
    path = compiled.compiled(compiled.find_compiler())
    assert tmp_path not in path.parents
    assert compiled.opened(path)


def test_a_compiler_that_fails_is_named(tmp_path, uncached):
    broken = tmp_path / "cc"
    broken.write_text("#!/bin/sh\necho no such luck >&2\nexit 3\n")
    broken.chmod(0o755)
    uncached.setenv("CC", str(broken))
    uncached.setenv("XDG_CACHE_HOME", str(tmp_path))
    with pytest.raises(compiled.NoLibrary, match=r"cc does not compile tick\.c: no such luck"):
        compiled.load()


@pytest.mark.parametrize("compiler", ["gcc", "clang"])
def test_the_source_has_no_warnings(compiler, tmp_path):
    if not any(os.access(f"{folder}/{compiler}", os.X_OK) for folder in os.environ["PATH"].split(":")):
        pytest.skip(f"there is no {compiler}")
    strict = ["-Wall", "-Wextra", "-Wconversion", "-Wpedantic", "-Werror"]
    command = [compiler, *compiled.OPTIONS, *strict, "-o", tmp_path / "tick.so", *compiled.SOURCES]
    assert subprocess.run(command, capture_output=True, text=True, check=False).stderr == ""


def test_times_that_a_double_does_not_hold_are_left_to_python():
    assert choose_tick("auto", MS, 0, 10**6).in_c
    assert not choose_tick("python", MS, 0, 10**6).in_c
    long = choose_tick("auto", MS, 0, 10**10)
    assert (long.in_c, "more than 53 bits" in long.reason) == (False, True)
    with pytest.raises(InputError, match=r"tick in C: the times of ticks have more than 53 bits"):
        choose_tick("c", MS, 0, 10**10)
    assert Times.of(MS, 0).exact_until(9 * 10**9)
