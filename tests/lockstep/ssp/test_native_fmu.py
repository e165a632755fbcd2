"""A component with native="true" has the FMU of the same name in the folder `native`, of the same data."""

import shutil
import tomllib
import zipfile
from dataclasses import replace
from pathlib import Path

import pytest

from fmus import echo_fmu
from fmus.c_fmu import compile_library, quoted
from lockstep import Component, System, load_system, read_signals, simulate, write_ssd
from lockstep.__main__ import main
from lockstep.errors import InputError
from lockstep.ssp.package_members import package_entries

MS = 1_000_000  # [ns]
DATA = "resources/model.npz"


@pytest.fixture(scope="module")
def echoes(tmp_path_factory):
    """Return a folder with echo.fmu, whose `inner` is 3 x, and native/echo.fmu, where it is 5 x; equal data."""
    folder = tmp_path_factory.mktemp("echoes")
    named = echo_fmu.echo_fmu(folder)
    source = folder / "changed.c"
    text = Path(echo_fmu.__file__).with_name("echo.c").read_text(encoding="utf-8")
    source.write_text(text.replace("3.0 * m->x[0]", "5.0 * m->x[0]"), encoding="utf-8")
    compile_library(folder / "native" / "echo.so", [source], defines=[quoted("GUID", echo_fmu.GUID)])
    with zipfile.ZipFile(named, "a") as archive, zipfile.ZipFile(folder / "native" / "echo.fmu", "w") as native:
        for member in archive.namelist():
            inside = member.endswith(".so")
            native.writestr(member, (folder / "native" / "echo.so").read_bytes() if inside else archive.read(member))
        for each, build in ((archive, "one"), (native, "other")):
            each.writestr(DATA, "matrices")
            each.writestr("resources/build.json", build)
    return folder


@pytest.fixture
def folder(echoes, tmp_path):
    """Return a copy of the two FMUs, and mixed.ssd: component `a` is native, `b` is not."""
    for path in ("echo.fmu", "native/echo.fmu"):
        (tmp_path / path).parent.mkdir(exist_ok=True)
        shutil.copy(echoes / path, tmp_path / path)
    one = Component(name="a", source=tmp_path / "echo.fmu", period=MS, parameters={"x": 2.0}, isolated=False)
    file = tmp_path / "mixed.ssd"
    write_ssd(System(name="mixed", tick=MS, components=(one, replace(one, name="b")), stop_time=MS), file)
    text = file.read_text(encoding="utf-8").replace("isolated=", 'native="true" isolated=', 1)
    file.write_text(text, encoding="utf-8")
    return tmp_path


def inner(system, folder):
    """Return the last value of each component's local variable."""
    simulate(system, folder, record=["locals:*"])
    signals = read_signals(folder)
    return [float(signals[f"{name}.inner"][-1]) for name in "ab"]


def test_it_is_the_one_that_runs_is_shown_and_recorded(folder, capsys):
    system = load_system(folder / "mixed.ssd")
    assert [component.source for component in system.components] == [
        folder / "native" / "echo.fmu",
        folder / "echo.fmu",
    ]
    assert inner(system, folder / "run") == [10.0, 6.0]
    run = tomllib.loads((folder / "run" / "run.toml").read_text())
    assert [c["source"] for c in run["component"]] == [str(folder / "native" / "echo.fmu"), str(folder / "echo.fmu")]
    assert main(["show", str(folder / "mixed.ssd")]) == 0
    assert capsys.readouterr().out.splitlines()[1:3] == [
        "  a  every 0.001 s from 0 s, continuous, native/echo.fmu",
        "  b  every 0.001 s from 0 s, continuous, echo.fmu",
    ]


def test_a_package_of_the_system_has_both_and_so_has_a_system_that_is_written_again(folder):
    entries = package_entries(folder / "mixed.ssd")
    with zipfile.ZipFile(folder / "mixed.ssp", "w") as package:
        for member, content in entries.items():
            package.writestr(member, content)
    assert b"native=" not in entries["SystemStructure.ssd"]
    assert inner(load_system(folder / "mixed.ssp"), folder / "packed") == [10.0, 6.0]

    write_ssd(load_system(folder / "mixed.ssd"), folder / "again.ssd")
    assert inner(load_system(folder / "again.ssd"), folder / "written") == [10.0, 6.0]


def test_in_a_package_it_is_the_member_in_the_folder(folder):
    with zipfile.ZipFile(folder / "by_hand.ssp", "w") as package:
        package.write(folder / "mixed.ssd", "SystemStructure.ssd")
        for path in ("echo.fmu", "native/echo.fmu"):
            package.write(folder / path, path)
    assert inner(load_system(folder / "by_hand.ssp"), folder / "run") == [10.0, 6.0]


def test_a_run_of_it_is_resumed_from_its_record(folder):
    out = folder / "run"
    options = ["--stop-time", "0.004", "--record", "locals:*", "--checkpoint", "0.002"]
    assert main(["run", str(folder / "mixed.ssd"), "--out", str(out), *options]) == 0
    checkpoint = str(out / "checkpoints" / "t=0.002.ckpt")
    assert main(["run", "--restart-from", checkpoint, "--out", str(folder / "rest"), "--set", "a.x=3"]) == 0
    signals = read_signals(folder / "rest")
    assert [float(signals[f"{name}.inner"][-1]) for name in "ab"] == [15.0, 6.0]


def test_the_fmu_that_is_named_need_not_be_there(folder):
    shutil.copy(folder / "echo.fmu", folder / "b.fmu")
    text = (folder / "mixed.ssd").read_text(encoding="utf-8")
    (folder / "mixed.ssd").write_text('source="b.fmu"'.join(text.rsplit('source="echo.fmu"', 1)), encoding="utf-8")
    (folder / "echo.fmu").unlink()
    assert inner(load_system(folder / "mixed.ssd"), folder / "run") == [10.0, 6.0]


def refused(path):
    with pytest.raises(InputError) as error:
        load_system(path)
    return str(error.value)


def test_one_that_is_not_there_or_has_other_data_is_refused(folder):
    native = folder / "native" / "echo.fmu"
    with zipfile.ZipFile(folder / "echo.fmu") as old, zipfile.ZipFile(folder / "new.fmu", "w") as new:
        for member in old.namelist():
            new.writestr(member, "other" if member == DATA else old.read(member))
    (folder / "new.fmu").replace(folder / "echo.fmu")
    assert refused(folder / "mixed.ssd") == (
        f"a: {native} has another {DATA} than {folder / 'echo.fmu'}, as it is older or newer; build both anew, "
        "or leave native out"
    )
    native.unlink()
    assert refused(folder / "mixed.ssd") == (
        f'a: no such file {native}, which native="true" asks for; build it, or leave native out'
    )


def test_another_value_is_refused(folder):
    text = (folder / "mixed.ssd").read_text(encoding="utf-8").replace('native="true"', 'native="yes"')
    (folder / "mixed.ssd").write_text(text, encoding="utf-8")
    assert refused(folder / "mixed.ssd") == "a: native 'yes' must be true or false"


def test_it_may_not_lie_outside_where_all_files_have_to_be(folder, tmp_path_factory):
    outside = tmp_path_factory.mktemp("outside")
    shutil.move(folder / "native", outside / "native")
    (folder / "native").symlink_to(outside / "native")
    with pytest.raises(InputError, match=r"a: source echo\.fmu lies outside"):
        load_system(folder / "mixed.ssd", within=folder)
