"""FMUs and systems of a spacecraft that is not the paper's: a pyramid of four wheels, two gyros, seven modes."""

import json
import re
import zipfile
from dataclasses import replace

import numpy as np
import pytest

import flexbench
from flexbench.loop.build import build_files
from flexbench.loop.build_options import ONLY_PYTHON
from flexbench.loop.loop_parts import loop_parts
from flexbench.loop.spacecraft import design_file, read_file, write_start
from flexbench.runs.run_folder import read_run
from flexbench.studies.margins.design_notes import design_notes
from flexsat.closed_loop import ClosedLoop
from flexsat.description.spacecraft_file import parse_spacecraft
from flexsat.design.chain import designs_of
from flexsat.fmu.python import load_matrices
from lockstep import InputError, load_system, simulate

SECONDS = 0.5


@pytest.fixture(scope="module")
def described(tmp_path_factory):
    """Return the file of the spacecraft."""
    path = tmp_path_factory.mktemp("described") / "small.toml"
    write_start(path)
    text = path.read_text(encoding="utf-8")
    path.write_text(text.replace("plant = 60", "plant = 8"), encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def built(described, tmp_path_factory):
    """Return the folder of its FMUs in Python."""
    folder = tmp_path_factory.mktemp("fmus")
    build_files([described], folder, lambda _: None, ONLY_PYTHON)
    return folder / "small"


def test_a_run_is_that_of_the_monolith_and_knows_its_spacecraft(built, described, tmp_path):
    system = load_system(built / "fine_pointing.ssd")
    parts = loop_parts(system)
    assert (parts.configuration, len(parts.torques)) == ("small", 4)
    finished = simulate(system, tmp_path / "run", stop_time=SECONDS)

    parameters = {c.name: {k: v for k, v in c.parameters.items() if k != "seed"} for c in system.components}
    loop = ClosedLoop(design_file(read_file(described), described), parameters)
    alone = loop.run(SECONDS, ["plant.attitude.mrp", "controller.wheel.torque"])
    for name, values in alone.signals.items():
        np.testing.assert_array_equal(finished.signals[name], values)
    run = read_run(tmp_path / "run")
    assert run.configuration == "small"
    assert run.designs.corrected.structure.mode_count == 8
    assert run.spacecraft.text == described.read_text(encoding="utf-8")


def test_what_is_written_names_the_spacecraft(built, described):
    assert (built / "spacecraft.toml").read_bytes() == described.read_bytes()
    manifest = json.loads((built.parent / "manifest.json").read_text(encoding="utf-8"))
    assert list(manifest["configurations"]) == ["small"]
    text = (built / "ICD.md").read_text(encoding="utf-8")
    assert "Elements of the arrays: small" in text
    assert not (built.parent / "ICD.md").exists()
    system = load_system(built / "fine_pointing.ssd")
    assert [c.source for c in system.components] == [built / f"{c.name}.fmu" for c in system.components]


def test_a_spacecraft_in_python_is_built_as_its_file_is(built, described, tmp_path):
    given = read_file(described).configurations
    lines = []
    folder = flexbench.build(
        given["robust"], tmp_path / "fmus", published=given["published"], native=False, print_line=lines.append
    )
    assert folder == tmp_path / "fmus" / "small"
    for name in ("plant.fmu", "sensors.fmu", "controller.fmu"):
        assert (folder / name).read_bytes() == (built / name).read_bytes()
    assert read_file(folder / "spacecraft.toml").configurations == given
    stable = [line for line in lines if "the closed loop is stable on all 8 modes" in line]
    assert [line.split(":")[1] for line in stable] == [" design published", " design robust"]
    assert any("of 8 modes of the free spacecraft the wheels do not excite" in line for line in lines)
    with pytest.raises(InputError, match=r"centralised: name = .centralised.: a built-in spacecraft has this name"):
        flexbench.build(replace(given["robust"], name="centralised"), tmp_path / "other")
    assert not (tmp_path / "other").exists()


def test_an_unstable_loop_is_stated(described):
    """The published weights of this spacecraft with little weight on torque: spillover beyond its seven modes."""
    text = described.read_text(encoding="utf-8").replace("plant = 8", "plant = 30")
    given = parse_spacecraft(text + "[controller.published]\ntorque = 1e-3\n", "small.toml").configurations
    notes = list(design_notes(designs_of(given["robust"], given["published"])))
    assert re.match(r"design published: warning: the closed loop is unstable on all 30 modes: the motion at", notes[0])
    assert notes[1].startswith("design robust: the closed loop is stable on all 30 modes")


def test_nothing_of_it_was_published(built, tmp_path):
    assert not any(name.startswith("as_published") for name in np.load(built_model(built, tmp_path)).files)
    with pytest.raises(InputError, match="as_published: this spacecraft has no published release; set it to false"):
        simulate(
            load_system(built / "fine_pointing.ssd"),
            tmp_path / "run",
            stop_time=0.01,
            overrides={"controller.as_published": True},
        )


def built_model(built, folder):
    """Return the matrices of the plant, unpacked."""
    with zipfile.ZipFile(built / "plant.fmu") as archive:
        return archive.extract(f"resources/{load_matrices.MODEL_FILE}", folder)


def test_a_spacecraft_without_a_design_is_refused_with_its_file(described, tmp_path):
    path = tmp_path / "small.toml"
    text = described.read_text(encoding="utf-8")
    path.write_text(text.replace('controller = "5 ms"', 'controller = "5.5 ms"'), encoding="utf-8")
    with pytest.raises(InputError, match=r"^small\.toml: Rates\.controller = 0\.0055 s must be a whole multiple"):
        build_files([path], tmp_path / "fmus", lambda _: None)
    assert not (tmp_path / "fmus").exists()
