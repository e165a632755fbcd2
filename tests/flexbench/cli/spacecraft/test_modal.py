"""`flexsat modal`: CSV tables become a modal file; data that do not fit together are named, wrong tables refused."""

import json
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from flexbench.cli.parser import main
from flexsat.structure.modal_data import structure_from
from flexsat.structure.modal_file import read_modal

# a mass of 8 kg at 4 m along x, which moves along z and y
TABLES = {
    "body.toml": 'damping_ratio = 0.002\nsource = "two springs"\n',
    "modes.csv": "frequency\n0.5\n2\n",
    "nodes.csv": "name,x,y,z,mass\ntip,4,0,0,8\n",
    "shapes.csv": (
        "mode,node,translation_x,translation_y,translation_z\n1,tip,0,0,0.35355339059327379\n2,tip,0,0.35355339059327379,0\n"
    ),
}


@pytest.fixture
def folder(tmp_path):
    made = tmp_path / "tables"
    made.mkdir()
    for name, text in TABLES.items():
        (made / name).write_text(text, encoding="utf-8")
    return made


def test_tables_become_a_modal_file(folder, tmp_path, capsys):
    out = tmp_path / "array.npz"
    assert main(["modal", str(folder), "--out", str(out)]) == 0
    shown = capsys.readouterr().out
    assert "mass y 100.00 %, mass z 100.00 %" in shown
    assert "orthogonality of the shapes: largest error" in shown
    assert "missing: node_rotation" in shown

    found = structure_from(read_modal(Path(out).read_bytes()))
    assert_allclose(found.frequency, 2.0 * np.pi * np.array([0.5, 2.0]), rtol=1e-15)
    assert_allclose(found.damping, 0.004 * found.frequency, rtol=1e-14)
    assert_allclose(found.rotation, [[0.0, 0.0], [-4.0 * np.sqrt(8.0), 0.0], [0.0, 4.0 * np.sqrt(8.0)]], rtol=1e-14)
    assert found.names == ("tip",)
    assert main(["modal", str(out), "--json", str(tmp_path / "found.json")]) == 0  # itself
    checks, numbers = (one["rows"] for one in json.loads((tmp_path / "found.json").read_text())["tables"])
    assert [right for _, right in checks] == [True] * len(checks)
    assert {name: unit for name, _, unit in numbers}["effective mass y"] == "%"
    assert_allclose([value for name, value, _ in numbers if name == "effective mass z"], 100.0, rtol=1e-12)


@pytest.mark.parametrize(
    ("name", "old", "new", "message"),
    [
        ("nodes.csv", "tip,4,0,0,8", "tip,4,0,0", "nodes.csv:2: must have 5 values, got 4"),
        ("nodes.csv", "tip,4", "tip,four", "nodes.csv:2: x must be a number, got 'four'"),
        ("nodes.csv", ",mass", ",weight", "nodes.csv: weight: no such column; there are name, x, y, z, mass"),
        ("shapes.csv", "2,tip", "3,tip", "shapes.csv:3: mode '3', node 'tip': no such mode from 1, or no such node"),
        ("shapes.csv", "2,tip,0,0.35355339059327379,0\n", "", "shapes.csv: must have a row for every mode and node"),
        ("modes.csv", "frequency", "freq", "modes.csv: column frequency is missing; there are freq"),
        ("body.toml", "damping_ratio", "damping", "body.toml: damping: no such key; there are kind, mass"),
        ("body.toml", "source", "mass = true\nkind = 1\nsource", "body.toml: kind must be clamped or free, got 1"),
    ],
)
def test_wrong_tables_are_refused_in_one_line(folder, capsys, name, old, new, message):
    text = TABLES[name]
    assert old in text
    (folder / name).write_text(text.replace(old, new, 1), encoding="utf-8")
    assert main(["modal", str(folder)]) == 2
    assert capsys.readouterr().err == f"flexsat: {folder}: {message}\n" or message.endswith("mass")


def test_shapes_of_another_scale_are_named(folder, capsys):
    wrong = TABLES["shapes.csv"].replace("1,tip,0,0,0.35", "1,tip,0,0,0.25")
    (folder / "shapes.csv").write_text(wrong, encoding="utf-8")
    assert main(["modal", str(folder)]) == 1
    assert "orthogonality of the shapes" in capsys.readouterr().err


def test_no_source_is_refused(tmp_path, capsys):
    (tmp_path / "array.txt").touch()
    assert main(["modal", str(tmp_path / "array.txt")]) == 2
    assert "neither a modal file (.npz), a folder of CSV tables, nor results of CalculiX" in capsys.readouterr().err
    assert main(["modal", str(tmp_path / "none.npz")]) == 2
    assert "none.npz: no such file; give a modal file (.npz), a folder of CSV tables" in capsys.readouterr().err
