"""One line that names the right culprit: what was given for a system, paths, the temporary folder, step sizes."""

import os
import re
import resource
import shutil
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path

import psutil
import pytest

from lockstep import InputError, load_system, simulate
from lockstep.__main__ import PROGRAM
from lockstep.fmi import temporary_folder
from lockstep.fmi.safe_zip import TemporaryFolderError
from lockstep.fmi.temporary_folder import unpacking_folder
from lockstep.operating_system import refuses_programs
from lockstep.ssp.step_times import Timing

SYSTEM = """<?xml version="1.0" encoding="UTF-8"?>
<ssd:SystemStructureDescription xmlns:ssd="http://ssp-standard.org/SSP1/SystemStructureDescription"
  xmlns:ssc="http://ssp-standard.org/SSP1/SystemStructureCommon" name="one" version="1.0">
  <ssd:System name="root"><ssd:Elements>
    <ssd:Component name="a" type="application/x-fmu-sharedlibrary" source="a.fmu"/>
  </ssd:Elements></ssd:System>
  <ssd:DefaultExperiment startTime="0" stopTime="0.01"/>
</ssd:SystemStructureDescription>
"""


@pytest.fixture
def folder(reference_fmu, tmp_path):
    """Return a folder with an FMU `a.fmu` and a system of it, `one.ssd`."""
    shutil.copy(reference_fmu("integrator", "2.0"), tmp_path / "a.fmu")
    (tmp_path / "one.ssd").write_text(SYSTEM)
    return tmp_path


def refused(capsys, *words, code=2):
    """Return the one line that a command line is refused with."""
    assert PROGRAM.run([str(word) for word in words]) == code
    out, error = capsys.readouterr()
    assert (out, error.count("\n")) == ("", 1), error
    return error.removeprefix("lockstep: ").rstrip("\n")


def test_what_is_no_system_is_named_with_the_systems_near_it(folder, capsys):
    (folder / "results").mkdir()
    (folder / "results" / "run.toml").touch()
    (folder / "t=1.ckpt").touch()
    (folder / "inner").mkdir()
    shutil.copy(folder / "one.ssd", folder / "inner" / "two.ssd")
    os.mkfifo(folder / "pipe.ssd")
    near = f"systems in {folder}: one.ssd"
    said = {
        folder: f"is a folder without SystemStructure.ssd, so not an unpacked system; {near}",
        folder / "inner": f"so not an unpacked system; systems in {folder / 'inner'}: two.ssd",
        folder / "results": f"is the results folder of a run, not a system (--resume continues a run that was killed); "
                            f"no system (.ssd, .ssp) in {folder / 'results'}",
        folder / "t=1.ckpt": f"is a checkpoint, not a system (--restart-from begins a run there); {near}",
        folder / "pipe.ssd": f"{folder / 'pipe.ssd'} is a pipe or a device; give a regular file",
    }  # fmt: skip
    for path, what in said.items():
        line = refused(capsys, "show", path)
        assert line.startswith(f"{path}: ")
        assert what in line


@pytest.mark.parametrize("words", [["show", b"t\xe9st.ssd"], ["check", b"t\xe9st.fmu"], ["run", "--out", b"t\xe9st"]])
def test_bytes_of_an_argument_that_are_no_text_are_refused(capsys, words):
    decoded = [word if isinstance(word, str) else os.fsdecode(word) for word in words]
    assert re.fullmatch(
        r"'t\\xe9st(\.\w+)?': holds bytes that are not UTF-8, which records cannot name; rename it",
        refused(capsys, *decoded),
    )


def test_a_working_folder_that_is_no_text_or_gone_is_refused(capsys, tmp_path, monkeypatch):
    other = Path(os.fsdecode(bytes(tmp_path) + b"/t\xe9st"))
    other.mkdir()
    monkeypatch.chdir(other)
    assert re.match(r"the working folder '.*/t\\xe9st': holds bytes", refused(capsys, "show", "one.ssd"))
    other.rmdir()
    line = refused(capsys, "show", "one.ssd")
    assert line == "the working folder: No such file or directory; change to a folder that exists"


def test_an_fmu_or_results_folder_of_such_a_name_is_refused_in_python(folder):
    name = os.fsdecode(b"t\xe9st")
    system = load_system(folder / "one.ssd", Timing(period=1_000_000))
    with pytest.raises(InputError, match=r"results folder '.*t\\xe9st': holds bytes that are not UTF-8"):
        simulate(system, folder / name)
    (folder / "a.fmu").rename(folder / name)
    with pytest.raises(InputError, match=r"t\\xe9st': holds bytes that are not UTF-8"):
        load_system(folder / name)
    assert sorted(path.name for path in folder.iterdir()) == ["one.ssd", name]


def test_a_link_that_leads_out_of_a_package_is_named(folder, capsys):
    package = folder / "package"
    package.mkdir()
    (folder / "one.ssd").rename(package / "SystemStructure.ssd")
    (package / "a.fmu").symlink_to(folder / "a.fmu")
    line = refused(capsys, "show", package)

    what = f"a: source a.fmu lies outside {package}; put the file into that folder itself"
    assert line == f"{what}: it is, or passes, a link to {folder / 'a.fmu'}"


def test_a_link_packed_as_the_library_is_named(folder, capsys):
    with zipfile.ZipFile(folder / "a.fmu") as good, zipfile.ZipFile(folder / "linked.fmu", "w") as archive:
        for member in good.infolist():
            linked = member.filename.startswith("binaries/") and not member.is_dir()
            member.create_system, member.external_attr = 3, (0o120777 if linked else 0o100644) << 16
            archive.writestr(member, b"/usr/lib/a.so" if linked else good.read(member.filename))
    (folder / "linked.fmu").rename(folder / "a.fmu")
    line = refused(
        capsys, "run", folder / "one.ssd", "--step-size", "0.001", "--share-process", "a", "--out", folder / "o"
    )

    assert "binaries/linux64/integrator.so is a symbolic link, which cannot be unpacked; pack the file itself" in line
    assert not (folder / "o").exists()


@pytest.mark.skipif(sys.platform != "linux", reason="RLIMIT_FSIZE stands for a full disk")
def test_a_full_temporary_folder_is_the_culprit_and_not_the_fmu(folder, capsys, monkeypatch):
    monkeypatch.setattr(tempfile, "tempdir", str(folder))
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    words = ["run", folder / "one.ssd", "--step-size", "0.001", "--share-process", "a", "--out", folder / "out"]
    resource.setrlimit(resource.RLIMIT_FSIZE, (4096, before[1]))  # less than the library
    try:
        code = PROGRAM.run([str(word) for word in words])
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    last = capsys.readouterr().err.splitlines()[-1]

    assert code == 2, last
    assert re.search(
        r"a: .*a\.fmu: cannot be unpacked to .*lockstep-run-\d+-\w+/0(/fmu)? \(File too large\); free space", last
    )
    assert last.endswith("; free space there, or set TMPDIR to another folder")
    assert sorted(path.name for path in folder.iterdir()) == ["a.fmu", "one.ssd"]


@pytest.fixture
def barred(tmp_path):
    """Return a folder from which no program may run: mounted so, or one that is."""
    made = tmp_path / "barred"
    made.mkdir()
    if subprocess.run(
        ["mount", "-t", "tmpfs", "-o", "noexec", "none", made], check=False, capture_output=True
    ).returncode:
        mounted = [part.mountpoint for part in psutil.disk_partitions(all=True) if "noexec" in part.opts.split(",")]
        found = next((Path(path) for path in mounted if refuses_programs(Path(path))), None)
        if found is None:
            pytest.skip("nothing is mounted noexec here, and only root can mount it so")
        yield found
    else:
        yield made
        subprocess.run(["umount", made], check=True)


def test_a_temporary_folder_that_no_program_may_run_from_is_refused(monkeypatch, tmp_path, barred):
    assert not refuses_programs(tmp_path)
    monkeypatch.setattr(tempfile, "tempdir", str(barred))
    with pytest.raises(
        TemporaryFolderError, match=f"temporary folder {barred}: mounted noexec, so no FMU can run from it"
    ):
        unpacking_folder()


def test_a_temporary_folder_that_is_gone_is_refused(monkeypatch, tmp_path):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "gone"))
    with (
        pytest.raises(TemporaryFolderError, match=r"temporary folder .*gone: .*; set TMPDIR"),
        temporary_folder.temporary_folder("x"),
    ):
        pass


NO_STEP = {
    "0": "0: must be > 0 s",
    "-0.1": "-0.1: must be > 0 s",
    "NaN": "'NaN' is no",
    "1e300": "is more than",
}


@pytest.mark.parametrize(("size", "said"), NO_STEP.items())
def test_a_step_size_of_an_fmu_that_is_none_is_refused_with_the_remedy(folder, capsys, size, said):
    with zipfile.ZipFile(folder / "a.fmu") as good:
        members = {name: good.read(name) for name in good.namelist()}
    with zipfile.ZipFile(folder / "a.fmu", "w") as archive:
        for name, content in members.items():
            experiment = f'<DefaultExperiment stepSize="{size}"/><ModelVariables>'.encode()
            archive.writestr(name, content.replace(b"<ModelVariables>", experiment))
    line = refused(capsys, "show", folder / "one.ssd")

    assert line.startswith("a: the FMU's step size")
    assert said in line
    assert line.endswith("; give --step-size a=S in seconds, or --step-size S for all")
    assert PROGRAM.run(["show", str(folder / "one.ssd"), "--step-size", "0.01"]) == 0


OUT_OF_RANGE = {"1e300": "1e+300 s is more than 9.2e+09 s, which is 292 years", "inf": "is not a number of seconds",
                "nan": "is not a number of seconds", "-1": "must be > 0", "0": "must be > 0"}  # fmt: skip


@pytest.mark.parametrize("option", ["--stop-time", "--step-size", "--record-period", "--checkpoint-every"])
def test_times_that_no_clock_shows_are_refused(folder, capsys, option):
    for value, said in OUT_OF_RANGE.items():
        step = [] if option == "--step-size" else ["--step-size", "0.001"]
        line = refused(capsys, "run", folder / "one.ssd", *step, f"{option}={value}", "--out", folder / "out")
        assert said in line, line
        assert not (folder / "out").exists()


def test_numbers_of_other_options_are_finite_and_in_range(capsys):
    for option, value, said in (
        ("--time-limit", "nan", "--time-limit: 'nan' is not a finite number"),
        ("--time-limit", "1e300", "--time-limit 1e+300: must be > 0 and <= 9200000000"),
        ("--steps", "0", "--steps 0: must be 1 or more"),
        ("--steps", "1" + "0" * 25, "must be 1000000 or less"),
    ):
        assert said in refused(capsys, "probe-latency", "a.fmu", option, value)
