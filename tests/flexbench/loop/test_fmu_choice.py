"""Which FMUs a study of many runs has: native where they are built for every system, else those in Python."""

import json
import zipfile

import pytest

from flexbench.loop.fmu_choice import choose_fmus
from lockstep import Component, System


def fmu(path, design="one", python=True):
    path.parent.mkdir(parents=True, exist_ok=True)
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("resources/model.npz", design)
        archive.writestr("resources/build.json", json.dumps({"native": not python}))
        if python:
            archive.writestr("resources/shell.py", "")


@pytest.fixture
def layout(tmp_path):
    """Return a function that makes a system of a plant and a controller, native FMUs beside those that are named."""

    def make(name, native=(), design="one"):
        folder = tmp_path / name
        for component in ("plant", "controller"):
            fmu(folder / f"{component}.fmu")
        for component in native:
            fmu(folder / "native" / f"{component}.fmu", design, python=False)
        parts = tuple(Component(name=one, source=folder / f"{one}.fmu", period=1) for one in ("plant", "controller"))
        return System(name=name, tick=1, stop_time=10, connections=(), components=parts)

    return make


def test_native_fmus_are_chosen_where_they_are_built(layout, tmp_path):
    systems = [layout("a", ("plant", "controller")), layout("b", ("plant", "controller"))]
    chosen = choose_fmus(systems)
    assert (chosen.native, chosen.text) == (True, "FMUs: native")
    assert [c.source.parent for c in chosen.of(systems[1]).components] == [tmp_path / "b" / "native"] * 2
    # a system whose file names them already, as those in native/ do
    again = choose_fmus([chosen.of(systems[0])])
    assert (again.text, again.of(chosen.of(systems[0]))) == ("FMUs: native", chosen.of(systems[0]))


def test_components_that_have_none_keep_theirs_and_are_named(layout):
    system = layout("a", ("plant",))
    chosen = choose_fmus([system])
    assert chosen.text == "FMUs: native (plant), Python (controller)"
    assert chosen.of(system).component("controller") == system.component("controller")


def test_python_fmus_are_chosen_on_request_or_where_a_layout_lacks_the_others(layout, tmp_path):
    complete, bare, old = layout("a", ("plant", "controller")), layout("b"), layout("c", ("plant",), "another")
    for systems, python, note in (
        ([complete], True, "--python"),
        ([complete, bare], False, f"no native ones in {tmp_path}/b/native; `flexsat build` makes them"),
        ([complete, old], False, f"{tmp_path}/c/native/plant.fmu has another resources/model.npz than"
                                 f" {tmp_path}/c/plant.fmu, as it is older or newer; `flexsat build` makes both anew"),
    ):  # fmt: skip
        chosen = choose_fmus(systems, python)
        assert chosen.text == f"FMUs: Python; {note}"
        assert [chosen.of(system) for system in systems] == systems


def test_fmus_of_others_are_not_called_python(tmp_path):
    with zipfile.ZipFile(tmp_path / "law.fmu", "w") as archive:
        archive.writestr("modelDescription.xml", "")
    part = Component(name="law", source=tmp_path / "law.fmu", period=1)
    system = System(name="others", tick=1, stop_time=10, connections=(), components=(part,))
    assert choose_fmus([system]).text == "FMUs: other"
