"""JSON files in results folders: numpy's numbers are written, and files of another shape are refused by name."""

import json
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from flexbench.report.results import Result
from flexbench.report.study_table import study_table
from flexbench.runs.evaluation_folder import evaluation_folders, writing
from flexbench.runs.json_file import read_json, write_json
from flexbench.studies.budget.result_file import read_budget
from flexbench.studies.budget.split import read_split
from flexbench.studies.margins.study import read_study
from flexbench.studies.waterfall.sweep import read_waterfall
from lockstep import InputError


def metrics(folder):
    return Result(folder=folder, name="run", record={}, text="", events=[], run=SimpleNamespace()).metrics()


WATERFALL = {"configuration": "c", "seed": 1, "stop": 2.0, "speed_rpm": [1.0], "crossings": [{"speed_rpm": 1.0}]}
CASES = [
    (metrics, "metrics.json", [], "json: [] must be a table"),
    (metrics, "metrics.json", {}, "metrics is missing"),
    (metrics, "metrics.json", {"metrics": [1.0]}, "metrics = [1.0] must be a table"),
    (metrics, "metrics.json", {"metrics": {"torque": "x"}}, "metrics.torque = 'x' must be a number"),
    (metrics, "metrics.json", {"metrics": {"torque": None}}, "metrics.torque = None must be a number"),
    (metrics, "metrics.json", {"metrics": {"torque": True}}, "metrics.torque = True must be a number"),
    (study_table, "table.json", {"seeds": 1}, "seeds = 1 must be a list"),
    (study_table, "table.json", {"seeds": [1], "duration": 1, "rows": ["x"]}, "rows[1] = 'x' must be a table"),
    (read_split, "split.json", {"configuration": 5}, "configuration = 5 must be a text"),
    (read_split, "split.json", {"configuration": "c", "seed": 1, "header": [], "rows": [1]}, "rows[1] = 1 must be"),
    (read_waterfall, "waterfall.json", WATERFALL, "crossings[1].mode is missing"),
    (read_study, "margins.json", {"seed": 1, "analysis": {"exact": 1}}, "analysis.exact = 1 must be a table"),
    (read_budget, "budget.json", [], "not written by `flexsat budget`"),
    (read_budget, "budget.json", {"requirements": [1]}, "not written by `flexsat budget`"),
]


@pytest.mark.parametrize(("read", "name", "content", "message"), CASES)
def test_a_file_of_another_shape_is_refused_by_name(tmp_path, read, name, content, message):
    write_json(tmp_path / name, content)
    with pytest.raises(InputError) as caught:
        read(tmp_path)
    assert str(caught.value).startswith(f"{tmp_path / name}: ")
    assert message in str(caught.value)
    assert "delete it" in str(caught.value)


@pytest.mark.parametrize("read", [metrics, read_split, read_waterfall, read_study, read_budget])
@pytest.mark.parametrize("text", ["[" * 100_000, "{", "\udcff"])
def test_a_file_that_cannot_be_parsed_is_refused_by_name(tmp_path, read, text):
    name = {metrics: "metrics", read_split: "split", read_waterfall: "waterfall", read_study: "margins"}
    path = tmp_path / f"{name.get(read, 'budget')}.json"
    path.write_bytes(text.encode("utf-8", "surrogateescape"))
    with pytest.raises(InputError, match=rf"{path.name}: is (no JSON file|nested too deeply).*; delete it, or"):
        read(tmp_path)


def test_numbers_of_numpy_come_back_as_numbers(tmp_path):
    content = {
        "a": np.float64(0.1),
        "b": np.int64(5),
        "c": np.bool_(True),
        "d": np.arange(3),
        "e": Path("x"),
        "f": None,
    }
    write_json(tmp_path / "a.json", content)
    assert read_json(tmp_path / "a.json") == {"a": 0.1, "b": 5, "c": True, "d": [0, 1, 2], "e": "x", "f": None}
    with pytest.raises(InputError, match=r"a\.json: 1j of type complex cannot be kept"):
        write_json(tmp_path / "a.json", {"a": 1j})
    assert json.loads((tmp_path / "a.json").read_text())["b"] == 5  # the old one stays
    assert read_json(tmp_path / "none.json") is None


def test_the_evaluation_of_each_run_has_its_folder(tmp_path):
    runs = [Path("a/one"), Path("b/two")]
    assert evaluation_folders(runs, None) == runs
    assert evaluation_folders(runs[:1], Path("out")) == [Path("out")]
    assert evaluation_folders(runs, Path("out")) == [Path("out/one"), Path("out/two")]
    with pytest.raises(InputError, match="--out out: two runs are named one; evaluate them one by one"):
        evaluation_folders([Path("a/one"), Path("b/one")], Path("out"))
    (tmp_path / "file").write_text("")
    message = r"file.*: cannot be written \(.*\); give another folder with --out"
    with pytest.raises(InputError, match=message), writing(tmp_path):
        write_json(tmp_path / "file" / "budget.json", {})
