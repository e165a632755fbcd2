"""Load a run as a Dataset, and export it; each format is read back by another library than the one that wrote it."""

import csv
import json
import resource
from pathlib import Path

import fastparquet
import h5py
import mat4py
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from numpy.testing import assert_array_equal
from scipy.io import loadmat

import flexbench
from flexbench.report.results import load_results
from flexbench.runs.dataset import dimension_of
from flexbench.runs.export import SUFFIXES, export_run
from lockstep import Component, InputError, System, simulate
from lockstep.fmi.model_description import read_description
from lockstep.results.run_record import to_toml

ROWS = 50
UNITS = {
    "plant.rate[1]": "rad/s",
    "plant.rate[2]": "rad/s",
    "plant.rate[3]": "rad/s",
    **{f"plant.wheel.speed[{k}]": "rad/s" for k in (1, 2, 10)},
    **{f"controller.wheel.torque[{k}]": "N.m" for k in (1, 2, 10)},
    "controller.reference.wheel.speed[4]": "rad/s",
    "plant.rms_deformation": "m",
}


@pytest.fixture(scope="module")
def recorded():
    """Return signals whose numbers need every digit."""
    values = np.random.default_rng(7).normal(size=(len(UNITS), ROWS)) * 1e-7
    return dict(zip(UNITS, values, strict=True))


@pytest.fixture(scope="module")
def run(tmp_path_factory, recorded):
    """Return a results folder as the master leaves it."""
    folder = tmp_path_factory.mktemp("results") / "short-run"
    folder.mkdir()
    time = np.arange(ROWS) * 0.005
    fields = [pa.field("time", pa.float64(), metadata={"unit": "s"})]
    fields += [pa.field(name, pa.float64(), metadata={"unit": unit, "description": f"the {name}"})
               for name, unit in UNITS.items()]  # fmt: skip
    pq.write_table(pa.table([time, *recorded.values()], schema=pa.schema(fields)), folder / "signals.parquet")
    manifest = {
        "status": "completed", "simulated_time": 0.25, "started": "2026-01-01T00:00:00+00:00",
        "system": {"name": "demo", "path": "", "sha256": "ab"}, "versions": {"python": "3.11", "numpy": "2.0"},
        "component": [
            {"name": "plant", "sha256": "cd", "model": "m", "parameters": {"seed": 3}},
            {"name": "sensors", "sha256": "ef", "model": "m", "parameters": {"seed": 3}},
        ],
    }  # fmt: skip
    (folder / "run.toml").write_text(to_toml(manifest))
    return folder


def test_arrays_become_variables_with_a_dimension(run, recorded):
    dataset = flexbench.load(run)

    assert dataset["plant.rate"].dims == ("time", "axis")
    assert dataset["plant.rms_deformation"].dims == ("time",)
    assert dataset["plant.wheel.speed"].dims == dataset["controller.wheel.torque"].dims == ("time", "wheel")
    assert_array_equal(dataset["wheel"], [1, 2, 10])  # by number, not by spelling
    assert_array_equal(dataset["plant.wheel.speed"].sel(wheel=10), recorded["plant.wheel.speed[10]"])
    assert_array_equal(dataset["time"], np.arange(ROWS) * 0.005)


def test_array_with_other_recorded_elements_has_its_own_index(run, recorded):
    speed = flexbench.load(run)["controller.reference.wheel.speed"]

    assert speed.dims[1] != "wheel"
    assert_array_equal(speed[speed.dims[1]], [4])
    assert_array_equal(speed[:, 0], recorded["controller.reference.wheel.speed[4]"])


def test_attributes_are_unit_description_seed_and_versions(run):
    dataset = flexbench.load(run, ["plant.rate"])

    assert list(dataset.data_vars) == ["plant.rate"]
    assert dataset["plant.rate"].attrs == {"units": "rad/s", "description": "the plant.rate[1]"}
    assert dataset["time"].attrs["units"] == "s"
    assert (dataset.attrs["seed"], dataset.attrs["versions"]) == (3, "python 3.11, numpy 2.0")
    assert json.loads(dataset.attrs["fmu_sha256"]) == {"plant": "cd", "sensors": "ef"}
    assert dataset.attrs["run_toml"] == (run / "run.toml").read_text()


@pytest.mark.parametrize(
    ("name", "count", "dimension"),
    [
        ("plant.attitude.mrp", 3, "axis"),
        ("plant.modal.velocity", 25, "mode"),
        ("controller.reference.torque", 33, "wheel"),
        ("sensors.gyro.rate", 23, "gyro"),
        ("toy.y", 2, "toy.y element"),
    ],
)
def test_names_of_dimensions(name, count, dimension):
    assert dimension_of(name, range(1, count + 1)) == dimension


def test_csv_read_by_the_standard_library(run, recorded):
    with export_run(run, "csv").open(newline="") as file:
        header, *rows = csv.reader(file)

    assert header == ["time [s]", *(f"{name} [{unit}]" for name, unit in UNITS.items())]
    assert_array_equal(np.array(rows, dtype=float)[:, 1:].T, list(recorded.values()))  # every digit


def test_parquet_read_by_fastparquet(run, recorded):
    path = export_run(run, "parquet")
    with path.open("rb") as file:
        frame = fastparquet.ParquetFile(file).to_pandas()

    assert list(frame) == ["time", *UNITS]
    for name, values in recorded.items():
        assert_array_equal(frame[name].to_numpy(), values)
    field = pq.read_schema(path).field("plant.rate[1]")
    assert field.metadata[b"unit"] == b"rad/s"
    assert pq.read_schema(path).metadata[b"seed"] == b"3"


def test_hdf5_read_by_h5py(run, recorded):
    with h5py.File(export_run(run, "hdf5")) as file:
        speed = file["plant.wheel.speed"]
        assert_array_equal(speed[:, 2], recorded["plant.wheel.speed[10]"])
        assert speed.attrs["units"] == "rad/s"
        assert_array_equal(file["wheel"][:], [1, 2, 10])
        assert file.attrs["seed"] == 3
        assert [dimension[0].name for dimension in speed.dims] == ["/time", "/wheel"]


def test_matlab_file_read_by_mat4py(run, recorded):
    content = mat4py.loadmat(str(export_run(run, "mat")))

    speed = np.array(content["signals"]["plant"]["wheel"]["speed"])
    assert_array_equal(speed[:, 2], recorded["plant.wheel.speed[10]"])
    assert_array_equal(np.ravel(content["signals"]["plant"]["rms_deformation"]), recorded["plant.rms_deformation"])
    assert content["units"]["plant"]["wheel"]["speed"] == "rad/s"
    assert np.ravel(content["elements"]["plant"]["wheel"]["speed"]).tolist() == [1, 2, 10]
    assert content["run"]["seed"] == 3
    assert_array_equal(np.ravel(content["time"]), np.arange(ROWS) * 0.005)


def test_only_requested_signals_are_written(run, tmp_path):
    path = export_run(run, "csv", tmp_path / "new" / "some.csv", ["plant.wheel.*", "plant.rate[2]"])
    header = path.read_text().splitlines()[0]

    assert header.count("wheel.speed") == 3
    assert ("plant.rate[2]" in header, "plant.rate[1]" in header) == (True, False)
    assert [p.name for p in path.parent.iterdir()] == ["some.csv"]  # nothing half-written beside it


@pytest.mark.parametrize("to", SUFFIXES)
def test_failed_export_leaves_no_file(run, tmp_path, to):
    (tmp_path / "file").write_text("in the way")

    with pytest.raises(InputError, match=r"file/x: cannot be written"):
        export_run(run, to, tmp_path / "file" / "x")
    assert [p.name for p in tmp_path.iterdir()] == ["file"]


OWN = ("signals.parquet", "signals.arrows", "run.toml", "events.jsonl", "metrics.json", "design.npz")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"to": "xls"}, "--format xls: no such format; there are csv, mat, hdf5, parquet"),
        ({"to": "csv", "patterns": ["plant.rat"]}, "--signals plant.rat: matches nothing.*did you mean plant.rate"),
        *(({"to": "parquet", "out": name}, "is the run's own record") for name in OWN),
        ({"to": "csv", "out": "."}, "is a folder"),
    ],
)
def test_bad_input_is_refused(run, arguments, message):
    if "out" in arguments:
        arguments = arguments | {"out": run / arguments["out"]}
    before = sorted(run.iterdir())

    with pytest.raises(InputError, match=message):
        export_run(run, **arguments)
    assert sorted(run.iterdir()) == before


def test_a_folder_without_a_run_is_refused(tmp_path):
    with pytest.raises(InputError, match=r"holds no run\.toml"):
        flexbench.load(tmp_path)
    with pytest.raises(InputError, match=r"holds no run\.toml"):
        export_run(Path(tmp_path), "csv")


def test_names_invalid_in_matlab_are_changed_or_refused(tmp_path, run):
    table = pq.read_table(run / "signals.parquet").select(["time", "plant.rms_deformation"])
    for name, message in (("a.der(x)", None), (f"a.{'x' * 64}", "too long for MATLAB")):
        folder = tmp_path / name[:5]
        folder.mkdir()
        (folder / "run.toml").write_text((run / "run.toml").read_text())
        schema = table.schema.set(1, table.schema.field(1).with_name(name))
        pq.write_table(table.cast(table.schema).rename_columns(["time", name]).cast(schema), folder / "signals.parquet")
        if message:
            with pytest.raises(InputError, match=message):
                export_run(folder, "mat")
        else:
            assert "der_x_" in mat4py.loadmat(str(export_run(folder, "mat")))["signals"]["a"]


def test_strings_and_64_bit_integers_are_exported_exactly(reference_fmu, tmp_path):
    values = {"UInt64_in": 2**64 - 1, "String_in": "größer", "whole_in[1]": -(2**63)}
    fmu = read_description(Component(name="one", source=reference_fmu("feedthrough", "3.0"), period=1))
    texts = {v.name: "" for v in fmu.variables.values() if v.causality == "input" and v.type == "String"}
    flags = {v.name: False for v in fmu.variables.values() if v.causality == "input" and v.type == "Boolean"}
    given = {v.name: 0 for v in fmu.variables.values() if v.causality == "input"} | texts | flags | values
    part = Component(
        name="one",
        source=reference_fmu("feedthrough", "3.0"),
        period=10**7,
        kind="sampled",
        parameters=given,
        isolated=False,
    )
    simulate(System(name="s", tick=10**7, stop_time=3 * 10**7, components=(part,)), tmp_path / "run")

    export_run(tmp_path / "run", "parquet", tmp_path / "out.parquet")
    export_run(tmp_path / "run", "csv", tmp_path / "out.csv")

    table = pq.read_table(tmp_path / "out.parquet")
    assert table["one.UInt64_out"].to_pylist() == [2**64 - 1] * 4
    assert table["one.whole_out[1]"].to_pylist() == [-(2**63)] * 4
    assert table["one.String_out"].to_pylist() == ["größer"] * 4
    assert "18446744073709551615" in (tmp_path / "out.csv").read_text()
    drawn = load_results([tmp_path / "run"])[0][0].signals()  # what a report draws
    assert "one.String_out" not in drawn
    assert drawn["one.UInt64_out"].dtype == np.float64


MATRIX = [f"plant.gain[{row},{column}]" for row in (1, 2) for column in (1, 2, 10)]


@pytest.fixture
def matrix_run(run, tmp_path):
    """Return a run with a matrix and a part of another, whose columns stand in the order of their letters."""
    names = [*sorted(MATRIX), "plant.part[1,1]", "plant.part[2,2]"]
    columns = [np.full(4, float(names.index(name))) for name in names]
    pq.write_table(pa.table([np.arange(4.0), *columns], names=["time", *names]), tmp_path / "signals.parquet")
    (tmp_path / "run.toml").write_text((run / "run.toml").read_text())
    return tmp_path, dict(zip(names, columns, strict=True))


def test_matrix_becomes_a_variable_of_rows_and_columns(matrix_run):
    folder, columns = matrix_run
    gain = flexbench.load(folder)["plant.gain"]

    assert gain.dims == ("time", "plant.gain row", "plant.gain column")
    assert_array_equal(gain["plant.gain column"], [1, 2, 10])
    for row in (1, 2):
        for column in (1, 2, 10):
            element = gain.sel({"plant.gain row": row, "plant.gain column": column})
            assert_array_equal(element, columns[f"plant.gain[{row},{column}]"])


def test_part_of_a_matrix_is_labelled_by_both_indices(matrix_run):
    part = flexbench.load(matrix_run[0])["plant.part"]

    assert part.shape == (4, 2)
    assert part["plant.part element"].to_numpy().tolist() == ["1,1", "2,2"]


def test_matrix_is_exported_in_numeric_order(matrix_run, tmp_path):
    folder, columns = matrix_run
    with export_run(folder, "csv", tmp_path / "a.csv", ["plant.gain"]).open(newline="") as file:
        header = next(csv.reader(file))
    assert header == ["time [s]", *(f"{name} [1]" for name in MATRIX)]

    # SciPy's own reader: mat4py takes no arrays of three dimensions
    stored = loadmat(export_run(folder, "mat", tmp_path / "a.mat", ["plant.gain"]), simplify_cells=True)
    assert_array_equal(stored["elements"]["plant"]["gain"], [[row, col] for row in (1, 2) for col in (1, 2, 10)])
    assert_array_equal(stored["signals"]["plant"]["gain"][:, 0, 2], columns["plant.gain[1,10]"])

    with h5py.File(export_run(folder, "hdf5", tmp_path / "a.h5", ["plant.gain"])) as file:
        assert file["plant.gain"].shape == (4, 2, 3)
        assert_array_equal(file["plant.gain"][:, 1, 2], columns["plant.gain[2,10]"])


@pytest.mark.parametrize("to", SUFFIXES)
def test_full_disk_is_one_line_and_leaves_the_earlier_file(run, tmp_path, to):
    out = tmp_path / f"out{SUFFIXES[to]}"
    out.write_text("earlier")
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (1000, limits[1]))
    try:
        with pytest.raises(InputError, match=r"out\.\w+: cannot be written \(.*File too large\); choose another file$"):
            export_run(run, to, out)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    assert (out.read_text(), [path.name for path in tmp_path.iterdir()]) == ("earlier", [out.name])


@pytest.mark.parametrize("to", SUFFIXES)
def test_damaged_signals_are_named_and_not_the_file_to_write(run, tmp_path, to):
    folder = tmp_path / "run"
    folder.mkdir()
    for path in run.iterdir():
        if path.is_file():
            (folder / path.name).write_bytes(path.read_bytes())
    with (folder / "signals.parquet").open("r+b") as file:
        file.seek(200)
        file.write(bytes(200))
    with pytest.raises(InputError, match=r"run/signals\.parquet: cannot be read \(.*; restore the file, or run again"):
        export_run(folder, to, tmp_path / "out")
    assert [path.name for path in tmp_path.iterdir()] == ["run"]
