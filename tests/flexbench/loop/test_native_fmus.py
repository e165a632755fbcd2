"""Native FMUs in the place of the others."""

import json
import zipfile
from dataclasses import replace
from pathlib import Path

import pytest

from flexbench.cli.parser import main
from flexbench.loop.native_fmus import is_native, with_native_fmus
from flexsat.fmu.native import sources
from lockstep import Component, System
from lockstep.errors import InputError
from lockstep.ssp.native_fmu import NATIVE, shown_file


@pytest.fixture
def system(tmp_path):
    """Return a system of a plant, and a controller in another folder."""
    (tmp_path / "native").mkdir()
    return System(
        name="loop", tick=1, stop_time=10, connections=(),
        components=(
            Component(name="plant", source=tmp_path / "plant.fmu", period=1, parameters={"seed": 3}),
            Component(name="controller", source=tmp_path / "other" / "controller.fmu", period=5, kind="sampled"),
        ),
    )  # fmt: skip


def test_a_component_flies_its_native_fmu_if_there_is_one(system, tmp_path):
    (tmp_path / "native" / "plant.fmu").touch()
    made = with_native_fmus(system)
    assert [component.source for component in made.components] == [
        tmp_path / "native" / "plant.fmu",
        tmp_path / "other" / "controller.fmu",
    ]
    assert made.component("plant").parameters == {"seed": 3}


def test_a_native_fmu_of_another_design_is_refused(system, tmp_path):
    for path, content in ((tmp_path / "plant.fmu", "new"), (tmp_path / "native" / "plant.fmu", "old")):
        with zipfile.ZipFile(path, "w") as archive:
            archive.writestr("resources/model.npz", content)
    with pytest.raises(InputError) as refused:
        with_native_fmus(system)
    assert str(refused.value) == (
        f"--native: {tmp_path}/native/plant.fmu has another resources/model.npz than {tmp_path}/plant.fmu,"
        " as it is older or newer; `flexsat build` makes both anew"
    )


def test_without_any_it_is_refused_with_the_command_that_makes_them(system, tmp_path):
    with pytest.raises(InputError) as refused:
        with_native_fmus(system)
    assert str(refused.value) == (
        f"--native: no FMU of loop has a native one beside it (looked for {tmp_path}/native/plant.fmu,"
        f" {tmp_path}/other/native/controller.fmu); `flexsat build` makes those of flexsat's components"
    )


def write_fmu(path, **record):
    """Write what passes as an FMU with a build record."""
    path.parent.mkdir(exist_ok=True)
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("resources/build.json", json.dumps(record))


def test_what_is_native_already_stays_and_one_that_is_in_python_says_so(system, tmp_path):
    write_fmu(tmp_path / "plant.fmu", guid="{1}", native=True)
    write_fmu(tmp_path / "other" / "controller.fmu", guid="{2}")
    assert with_native_fmus(system) == system
    assert [is_native(component) for component in system.components] == [True, False]


def test_a_package_is_refused_with_that_of_the_native_fmus(system, tmp_path):
    package = tmp_path / "slew.ssp"
    packed = replace(system, components=tuple(replace(c, archive=package) for c in system.components))
    (tmp_path / "native" / "slew.ssp").touch()
    with pytest.raises(InputError) as refused:
        with_native_fmus(packed)
    assert str(refused.value) == (
        f"--native: the FMUs of loop are those inside {package}; run {tmp_path}/native/slew.ssp"
    )


def test_its_folder_is_that_of_the_build():
    assert NATIVE == sources.NATIVE


def test_a_restart_without_a_system_is_refused(capsys):
    assert main(["run", "--native", "--restart-from", "t=1.ckpt"]) == 2
    text = "--native: a restart uses the FMUs of its run; name a system file, or leave --native out"
    assert capsys.readouterr().err == f"flexsat: {text}\n"


@pytest.mark.parametrize(
    ("path", "shown"),
    [
        ("fmus/distributed/native/fmi3/plant.fmu", "native/fmi3/plant.fmu"),
        ("fmus/distributed/native/plant.fmu", "native/plant.fmu"),
        ("native/fmus/distributed/plant.fmu", "plant.fmu"),
        ("plant.fmu", "plant.fmu"),
        ("", ""),
    ],
)
def test_files_are_shown_with_the_folders_of_native_ones(path, shown):
    assert shown_file(Path(path)) == shown
