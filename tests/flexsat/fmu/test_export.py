"""The builder: equal sources give equal bytes, others another GUID, and nothing is left behind."""

import hashlib
import io
import sys
import tempfile
import zipfile
from pathlib import Path

import numpy as np
import pytest
from fmpy import read_model_description
from fmpy.validation import validate_fmu

import flexsat
from flexsat.fmu.export import build_fmu
from flexsat.fmu.reproducible_zip import npz_bytes, write_atomically
from fmus.toys.builds import build, copy_toys, python


@pytest.fixture
def packages(tmp_path, monkeypatch):
    """A folder with an editable copy of the toys, importable as `flexsat.toys` and gone afterwards."""
    folder = copy_toys(tmp_path / "packages")
    monkeypatch.setattr(flexsat, "__path__", [*flexsat.__path__, str(folder)])
    yield folder
    for name in [name for name in sys.modules if name.startswith("flexsat.toys")]:
        del sys.modules[name]


def test_two_processes_build_the_same_bytes(toy, tmp_path):
    again = tmp_path / "elsewhere" / "b.fmu"
    guid, sha256 = build(again)

    assert guid == read_model_description(str(toy)).guid
    assert sha256 == hashlib.sha256(toy.read_bytes()).hexdigest()
    assert again.read_bytes() == toy.read_bytes()


def test_another_source_line_resource_or_name_gives_another_guid(tmp_path, packages):
    shell, guids = "flexsat.toys.counter:Counter", set()
    guids.add(build_fmu(shell, tmp_path / "a.fmu", {"r": b"1"}, "toy").guid)
    guids.add(build_fmu(shell, tmp_path / "a.fmu", {"r": b"2"}, "toy").guid)
    guids.add(build_fmu(shell, tmp_path / "a.fmu", {"s": b"1"}, "toy").guid)
    guids.add(build_fmu(shell, tmp_path / "a.fmu", {"r": b"1"}, "other").guid)
    counter = packages / "toys" / "counter.py"
    counter.write_text(counter.read_text().replace("GAIN = 2.0", "GAIN = 2.5"))
    guids.add(build_fmu(shell, tmp_path / "a.fmu", {"r": b"1"}, "toy").guid)

    assert len(guids) == 5


@pytest.mark.usefixtures("packages")
def test_a_build_leaves_nothing_behind(tmp_path, monkeypatch):
    (tmp_path / "temporary").mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "temporary"))
    build_fmu("flexsat.toys.counter:Counter", tmp_path / "out" / "a.fmu", {}, "toy")  # loads what stays loaded
    path, modules, finders = list(sys.path), set(sys.modules), set(sys.path_importer_cache)

    build_fmu("flexsat.toys.counter:Counter", tmp_path / "out" / "b.fmu", {}, "other")

    assert sys.path == path
    assert set(sys.modules) == modules
    assert set(sys.path_importer_cache) <= finders
    assert list((tmp_path / "temporary").iterdir()) == []
    assert sorted(p.name for p in (tmp_path / "out").iterdir()) == ["a.fmu", "b.fmu"]


@pytest.mark.usefixtures("packages")
def test_the_archive_holds_what_the_shell_imports_and_what_it_was_given(tmp_path):
    build_fmu(
        "flexsat.toys.counter:Counter",
        tmp_path / "toy.fmu",
        {"model.npz": b"numbers"},
        "toy",
        {"index.html": b"<p>"},
        {"model.png": b"png"},
    )
    with zipfile.ZipFile(tmp_path / "toy.fmu") as archive:
        names = archive.namelist()
        assert archive.read("resources/model.npz") == b"numbers"
        assert archive.read("documentation/index.html") == b"<p>"
        assert archive.read("model.png") == b"png"
        assert {info.date_time for info in archive.infolist()} == {(1980, 1, 1, 0, 0, 0)}

    inside = {name.split("/", 2)[2] for name in names if name.startswith("resources/flexsat_")}
    shell = ("__init__", "access_plans", "call_order", "communication_points", "host_log", "life_cycle",
             "model_description", "port_values", "resources", "saved_life_cycle", "saved_state",
             "shared_buffers")  # fmt: skip
    expected = {"__init__.py", "toys/__init__.py", "toys/counter.py", "fmu/__init__.py"}
    expected |= {f"ports/{name}.py" for name in ("__init__", "table", "units")}
    expected |= {f"runtime/{name}.py" for name in ("__init__", "named_state")}
    assert inside == expected | {f"fmu/python/{name}.py" for name in shell}
    assert {"binaries/linux64/toy.so", "binaries/linux64/libpythonfmu-export.so"} <= set(names)
    assert not [name for name in names if "__pycache__" in name]


@pytest.mark.usefixtures("packages")
def test_fmpy_finds_no_problem_and_reads_the_feedthrough(tmp_path):
    build_fmu("flexsat.toys.counter:Counter", tmp_path / "toy.fmu", {}, "toy")

    assert validate_fmu(str(tmp_path / "toy.fmu")) == []
    description = read_model_description(str(tmp_path / "toy.fmu"))
    feedthrough = {u.variable.name: [d.name for d in u.dependencies] for u in description.outputs}
    assert feedthrough["level[2]"] == ["wheel.torque[2]"]
    assert feedthrough["angle"] == []
    assert not description.coSimulation.needsExecutionTool
    assert description.coSimulation.canSerializeFMUstate
    assert all(v.description for v in description.modelVariables)
    assert all(v.unit for v in description.modelVariables if v.type == "Real")
    assert description.defaultExperiment.stepSize == "0.01"


@pytest.mark.usefixtures("packages")
def test_a_build_declares_that_a_tool_is_needed_if_asked_to(tmp_path):
    builds = [
        build_fmu("flexsat.toys.counter:Counter", tmp_path / f"{asked}.fmu", {}, "toy", execution_tool=asked)
        for asked in (False, True)
    ]
    declared = [read_model_description(str(build.path)).coSimulation.needsExecutionTool for build in builds]

    assert declared == [False, True]
    assert builds[0].guid != builds[1].guid


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("import scipy", r"counter.py:3: .* imports scipy; an FMU has the standard library, numpy and pythonfmu"),
        ("from flexsat.fmu.python import base", r"counter.py:3: .* \(use a relative import\)"),
        ("def f():\n    from ..shells import base", r"counter.py:4: import of the package inside a function"),
    ],
)
def test_what_an_fmu_does_not_have_is_refused_with_its_line(tmp_path, packages, line, message):
    counter = packages / "toys" / "counter.py"
    text = counter.read_text().splitlines()
    text[1:2] = ["", *line.split("\n"), ""]
    counter.write_text("\n".join(text).replace("from __future__ import annotations\n", ""))

    with pytest.raises(ValueError, match=message):
        build_fmu("flexsat.toys.counter:Counter", tmp_path / "toy.fmu", {}, "toy")
    assert not (tmp_path / "toy.fmu").exists()


@pytest.mark.parametrize(
    ("shell", "name"), [("flexsat.toys.counter:Counter", "1 toy"), ("flexsat.toys.counter", "toy")]
)
def test_bad_names_are_refused(tmp_path, shell, name):
    with pytest.raises(ValueError, match="must"):
        build_fmu(shell, tmp_path / "toy.fmu", {}, name)


def test_npz_bytes_repeat_and_numpy_reads_them():
    arrays = {"b": np.arange(6.0).reshape(2, 3), "a": np.array(3)}

    data = npz_bytes(arrays)

    assert data == npz_bytes(dict(reversed(arrays.items())))
    with np.load(io.BytesIO(data), allow_pickle=False) as read:
        assert {name: read[name].tolist() for name in read} == {name: a.tolist() for name, a in arrays.items()}


def test_a_failed_write_leaves_the_old_file(tmp_path, monkeypatch):
    (tmp_path / "toy.fmu").write_bytes(b"old")
    monkeypatch.setattr(Path, "replace", lambda *_: (_ for _ in ()).throw(OSError("disk is gone")))

    with pytest.raises(OSError, match="disk is gone"):
        write_atomically(tmp_path / "toy.fmu", b"new")
    assert [(p.name, p.read_bytes()) for p in tmp_path.iterdir()] == [("toy.fmu", b"old")]


def test_the_schema_of_fmi_accepts_the_model_description(toy, tmp_path):
    with zipfile.ZipFile(toy) as archive:
        (tmp_path / "modelDescription.xml").write_bytes(archive.read("modelDescription.xml"))

    python(
        "import fmpy, pathlib; from lxml import etree\n"
        "folder = pathlib.Path(fmpy.__file__).parent / 'schema' / 'fmi2'\n"
        "schema = etree.XMLSchema(etree.parse(str(folder / 'fmi2ModelDescription.xsd')))\n"
        "schema.assertValid(etree.parse(sys.argv[1]))",
        tmp_path / "modelDescription.xml",
    )
