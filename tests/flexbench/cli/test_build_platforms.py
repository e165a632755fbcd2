"""`flexsat build --platforms`: the names, and what is refused before anything is built."""

import importlib.util

import pytest

from flexbench.cli import build
from flexbench.cli.parser import main
from flexsat.fmu.native.platforms import PLATFORMS


def test_the_names_are_those_of_the_build():
    assert tuple(PLATFORMS) == build.PLATFORMS


@pytest.mark.parametrize(
    ("given", "passed"),
    [
        ("all", tuple(PLATFORMS)),
        ("win64, linux64,win64", ("linux64", "win64")),
        ("darwin64,all", tuple(PLATFORMS)),
    ],
)
def test_each_platform_is_built_once_in_the_usual_order(monkeypatch, capsys, given, passed):
    found = {}
    monkeypatch.setattr("flexbench.loop.build.build_all", lambda *_, **options: found.update(options))

    assert main(["build", "--platforms", given]) == 0
    assert found["options"].platforms == passed
    assert "built in" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("options", "line"),
    [
        (["win6"], "--platforms: 'win6' is none of all, linux64, win64, aarch64-linux, darwin64; did you mean win64?"),
        ([""], "--platforms: '' is none of all, linux64"),
        (["win64", "--no-native"], "--platforms concerns the FMUs in C, which --no-native omits"),
        (["win64"], "compiled with Zig, which is missing: pip install ziglang"),
    ],
)
def test_what_cannot_be_built_is_refused_at_once(monkeypatch, capsys, tmp_path, options, line):
    find = importlib.util.find_spec
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None if name == "ziglang" else find(name))

    assert main(["build", "--out", str(tmp_path / "fmus"), "--platforms", *options]) == 2
    said = capsys.readouterr()
    assert said.out == ""
    assert line in said.err
    assert said.err.count("\n") == 1
    assert not (tmp_path / "fmus").exists()
