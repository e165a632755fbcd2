"""The command `bundle`: its options, and the systems that a bundle cannot carry."""

import zipfile
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path

import pytest

import lockstep.bundle.compile
import lockstep.bundle.write
from fmus.bundle_host import MS, alone, bits, bundled
from lockstep import Component, InputError, System, write_ssd
from lockstep.__main__ import main
from lockstep.bundle.compile import library
from lockstep.bundle.contents import contents
from lockstep.bundle.ports import Choice
from lockstep.check.static import elf
from lockstep.system.adapter_file import Adapter
from lockstep.system.sums import Sums
from lockstep.system.system import SystemPort
from lockstep.system.transformation import Table


@pytest.fixture
def ssd(cells, tmp_path):
    """Return the system as a file."""
    write_ssd(replace(cells, name="four"), tmp_path / "four.ssd")
    return tmp_path / "four.ssd"


def description(path):
    """Return the model description."""
    return zipfile.ZipFile(path).read("modelDescription.xml").decode()


def test_every_option_changes_the_bundle(cells, ssd, tmp_path, capsys):
    def made(*options):
        assert main(["bundle", str(ssd), "--out", str(tmp_path / "made.fmu"), *options]) == 0
        captured = capsys.readouterr()
        assert captured.out == f"{tmp_path / 'made.fmu'}\n"
        return description(tmp_path / "made.fmu"), captured.err

    plain, said = made()
    assert said == ""
    assert 'name="push"' in plain
    text, said = made("--input", "none", "--output", "*.y", "--output", "arm.n", "--parameter", "*.gain")
    names = ("push", "arm.y[3]", "arm.n", "arm.flag", "arm.gain", "arm.trim")
    assert [name for name in names if f'"{name}"' in text] == ["arm.y[3]", "arm.n", "arm.gain"]
    text, said = made("--output", "all", "--multiple-of", "0.005", "--set", "arm.gain=7")
    assert "left out: arm.text: a bundle shows Strings" in said
    assert 'stepSize="0.005"' in text
    assert 'start="7.0"' in text
    before = zipfile.ZipFile(tmp_path / "made.fmu").read("resources/program.bin")
    for option in (["--delay", "fast:slow=1"], ["--step-size", "arm=0.004"], ["--sampled", "arm"],
                   ["--continuous", "slow", "--delay", "slow:body=1"]):  # fmt: skip
        made("--output", "arm.y", "--multiple-of", "0.005", *option)
        assert zipfile.ZipFile(tmp_path / "made.fmu").read("resources/program.bin") != before

    text, _ = made("--output", "all", "--fmi3")
    assert 'fmiVersion="3.0"' in text
    assert '<Dimension start="3" />' in text
    one = [str(cells.components[0].source), "--out", str(tmp_path / "made.fmu"), "--step-size", "0.004"]
    assert main(["bundle", *one, "--tick", "0.002"]) == 0
    assert 'stepSize="0.002"' in description(tmp_path / "made.fmu")


def refused(capsys, *words):
    """Return the line with which a command is refused."""
    assert main(["bundle", *map(str, words)]) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.count("\n") == 1
    return captured.err


def test_bad_options_are_refused_in_one_line_and_leave_no_file(ssd, tmp_path, capsys, monkeypatch):
    out = tmp_path / "new" / "b.fmu"
    assert "--out b.zip: the file of an FMU ends with .fmu" in refused(capsys, ssd, "--out", "b.zip")
    for words, text in (
        (["--input", "pusch"], "--input pusch: matches no input; there are push, order"),
        (["--output", "x"], "--output x: matches no output"),
        (["--output", "arm.text"], "--output arm.text: a bundle shows Strings of components that step at each tick"),
        (["--input", "push", "--input", "arm.u[3]"], "--input arm.u[3]: leads to arm.u[3], as push does; choose one"),
        (["--platforms", "beos"], "--platforms: 'beos' is none of linux64, win64, aarch64-linux"),
        (["--platforms", "win64"], "fast: cell.fmu has no binary for win64, only for linux64; build it for that"),
        (["--multiple-of", "0.0015"], "step size of the bundle 0.0015 s is not a whole multiple of the tick"),
    ):
        assert text in refused(capsys, ssd, "--out", out, *words), words
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.delenv("CC", raising=False)
    monkeypatch.setattr(lockstep.bundle.write, "library", library.__wrapped__)  # without what was compiled before
    assert "a bundle needs a C compiler, and there is none; install gcc or clang" in refused(capsys, ssd, "--out", out)
    monkeypatch.setattr(lockstep.bundle.compile.importlib.util, "find_spec", lambda _: None)
    line = refused(capsys, ssd, "--out", out, "--platforms", "linux64")
    assert "--platforms: Zig compiles for chosen platforms, and it is missing: pip install ziglang" in line
    assert not out.parent.exists()


def changed(system, name, **values):
    """Return the system with one component changed."""
    return replace(system, components=tuple(replace(c, **values) if c.name == name else c for c in system.components))


def test_what_a_bundle_cannot_carry_is_refused_by_name_with_the_remedy(cells, reference_fmu):
    table = Table(kind="Integer", entries=((1, 2),))
    adapter = Adapter(path=Path("a.toml"), sha256="")
    old = Component(name="f", source=reference_fmu("integrator", "1.0"), period=MS)
    wide = Component(name="f", source=reference_fmu("feedthrough", "3.0"), period=MS, parameters={"Int8_in": 1})
    wires = (replace(c, table=table) if (c.output, c.to_component) == ("n", "body") else c for c in cells.connections)
    mapped = replace(cells, connections=tuple(wires))
    for system, expected in (
        (changed(cells, "arm", adapter=adapter),
         "arm: a bundle cannot carry an adapter; write its connections as SSP"),
        (changed(cells, "arm", sums=Sums(inputs={"s": ("a", "b")})),
         "arm: a bundle cannot carry sums of an OSP system"),
        (mapped, "slow.n -> body.k: a bundle carries linear conversions of Reals only, neither mapping tables"),
        (System(name="x", tick=MS, components=(old,)),
         "f: integrator.fmu is an FMU of FMI 1.0; a bundle holds FMUs of FMI 2.0 and 3.0; export it for one of them"),
        (System(name="x", tick=MS, components=(wide,)),
         "value of f.Int8_in: f.Int8_in is Int8; a bundle carries Float64, Int32, Boolean and String of FMI 3.0"),
        (replace(cells, strict_inputs=True), "not connected and without a value"),
    ):  # fmt: skip
        with pytest.raises(InputError) as error:
            contents(system, {}, Choice(inputs=("none",)))
        assert expected in str(error.value)


def test_two_variables_of_one_name_are_refused(cells):
    port = SystemPort(name="arm.gain", kind="output", component="arm", variable="y[1]")
    with pytest.raises(InputError, match=r"arm\.gain: two variables of the bundle would have this name"):
        contents(replace(cells, ports=(port,)), {}, Choice())


def test_the_library_exports_the_functions_of_fmi_alone_and_needs_the_c_library_alone():
    found = elf.read_library(library(None))

    assert {name for name in found.exported if not name.startswith("fmi2")} == set()
    third = elf.read_library(library(None, "3.0"))
    assert {name for name in third.exported if not name.startswith("fmi3")} == set()
    assert len(found.exported) == 34
    assert set(found.needed) <= {"libc.so.6", "libdl.so.2"}


@pytest.mark.skipif(find_spec("ziglang") is None, reason="no ziglang")
def test_zig_builds_for_chosen_platforms_that_all_fmus_have(ssd, tmp_path, cells):
    assert main(["bundle", str(ssd), "--out", str(tmp_path / "zig.fmu"), "--platforms", "linux64"]) == 0
    own = bundled(cells, tmp_path / "own.fmu", Choice())
    binary = "binaries/linux64/four.so"
    content = zipfile.ZipFile(tmp_path / "zig.fmu").read(binary)

    assert elf.read_library(content).exported == elf.read_library(library(None)).exported
    assert max(map(int, elf.read_library(content).versions["GLIBC"].split(".")[1:2])) <= 17
    assert bits(alone(tmp_path / "zig.fmu", 0.02)["angle"]) == bits(alone(own, 0.02)["angle"])
