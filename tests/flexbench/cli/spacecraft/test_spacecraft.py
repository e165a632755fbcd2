"""`flexsat new` writes a file that `flexsat spacecraft` shows and `flexsat build` takes."""

from pathlib import Path

import pytest

from flexbench.cli.parser import main
from flexbench.loop.spacecraft import designs_for, read_file, spacecraft_of
from flexsat.description.built_in import built_in
from lockstep import InputError


@pytest.fixture
def start(tmp_path, capsys):
    path = tmp_path / "mine.toml"
    assert main(["new", str(path)]) == 0
    capsys.readouterr()
    return path


def test_the_start_is_shown(start, capsys):
    assert main(["spacecraft", str(start), "--list-modes", "3"]) == 0
    shown = capsys.readouterr().out
    assert shown.startswith("mine: four wheels in a pyramid on the bus; 2 gyros, 1 accelerometers\n")
    # 800 kg at 1 m below 4200.03 kg of structure, as printed; four of 4.4 N.m at 45 degrees
    assert "centre of mass 0, 0, -0.16 m from the origin\n" in shown
    assert "net momentum of the wheels there 0, 0, 0 N.m.s\n" in shown
    assert "torque about x, y, z 6.223, 6.223, 12.45 N.m" in shown
    assert "note:" not in shown
    assert "\n3  " in shown
    assert "\n4  " not in shown


def test_the_schema_is_the_page_of_the_documentation(capsys):
    assert main(["spacecraft", "--schema"]) == 0
    page = Path(__file__).parents[4] / "docs" / "spacecraft_file.md"
    assert capsys.readouterr().out == page.read_text()


def test_a_spacecraft_is_drawn(start, tmp_path, capsys):
    drawn = tmp_path / "mine.svg"
    assert main(["spacecraft", str(start), "--list-modes", "1", "--draw", str(drawn)]) == 0
    assert capsys.readouterr().out.endswith(f"{drawn}\n")
    assert "<svg" in drawn.read_text()


def test_a_file_is_never_overwritten(start, capsys):
    start.write_text("mine", encoding="utf-8")
    assert main(["new", str(start)]) == 2
    assert "is there already, and is kept" in capsys.readouterr().err
    assert start.read_text(encoding="utf-8") == "mine"


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["new", "My-Craft.toml"], "the spacecraft has the name of its file, which must be small letters"),
        (["new", "distributed.toml"], "a built-in spacecraft is called distributed; choose another name"),
        (["new", "none/mine.toml"], "cannot be written (No such file or directory); choose another folder"),
        (
            ["spacecraft", "distribted"],
            "distribted: no such file, and no built-in spacecraft (centralised, dis",
        ),
        (["spacecraft"], "SPACECRAFT is missing: a spacecraft's file, or the name of a built-in one; or give --schema"),
        (["spacecraft", "distributed", "--draw", "one.pdf"], "--draw one.pdf: a figure is written to a file that ends"),
        (["build", "no.toml"], "no.toml: cannot be read (No such file or directory); `flexsat new` writes a file"),
        (
            ["build", "no.toml", "--configuration", "distributed"],
            "--configuration chooses among the built-in spacecraft",
        ),
    ],
)
def test_refusals(arguments, message, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(arguments) == 2
    error = capsys.readouterr().err
    assert message in error
    assert error.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


def test_the_file_of_a_built_in_spacecraft_is_one_to_start_from(tmp_path, capsys):
    assert main(["spacecraft", "distributed", "--file"]) == 0
    text = capsys.readouterr().out
    path = tmp_path / "mine.toml"
    path.write_text(text, encoding="utf-8")
    assert read_file(path).configurations == built_in("distributed").configurations
    path.write_text(text.replace('"0.84 kg.m2"', '"0.9 kg.m2"'), encoding="utf-8")
    with pytest.raises(
        InputError, match='name = "distributed": a built-in spacecraft has this name, and another design'
    ):
        read_file(path)


def test_results_are_evaluated_with_the_file_that_is_with_the_fmus(start, tmp_path):
    folder = tmp_path / "fmus" / "mine"
    fmu = folder / "native" / "plant.fmu"
    fmu.parent.mkdir(parents=True)
    with pytest.raises(InputError, match=r"mine: no built-in spacecraft, and no spacecraft\.toml of it with"):
        designs_for("mine", fmu)
    (folder / "spacecraft.toml").write_text(start.read_text(encoding="utf-8"), encoding="utf-8")
    assert spacecraft_of("mine", fmu).configurations == read_file(start).configurations
