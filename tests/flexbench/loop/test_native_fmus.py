"""Native FMUs in the place of the others."""

import zipfile

import pytest

from flexbench.cli.parser import main
from flexbench.loop.native_fmus import with_native_fmus
from lockstep import Component, System
from lockstep.errors import InputError


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
        f"--native: {tmp_path}/native/plant.fmu has other matrices than {tmp_path}/plant.fmu, as it is older or newer;"
        " `flexsat build` makes both anew"
    )


def test_without_any_it_is_refused_with_the_command_that_makes_them(system, tmp_path):
    with pytest.raises(InputError) as refused:
        with_native_fmus(system)
    assert str(refused.value) == (
        f"--native: no FMU of loop has a native one beside it (looked for {tmp_path}/native/plant.fmu,"
        f" {tmp_path}/other/native/controller.fmu); `flexsat build` makes those of flexsat's components"
    )


def test_a_restart_without_a_system_is_refused(capsys):
    assert main(["run", "--native", "--restart-from", "t=1.ckpt"]) == 2
    text = "--native: a restart uses the FMUs of its run; name a system file, or leave --native out"
    assert capsys.readouterr().err == f"flexsat: {text}\n"
