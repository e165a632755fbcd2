"""Every parameter of environment, thrusters and mission manager acts on a run, in its unit and its order."""

from collections.abc import Callable

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from flexsat.fmu.build_missions import data_resources
from flexsat.runtime.missions import environment
from fmus.mission_numbers import MISSION_DATA
from fmus.mission_runs import (
    BASE,
    STEPS,
    InOtherOrder,
    InOtherUnits,
    Instance,
    PythonInstance,
    differences,
    fly,
    without_effect,
)

Make = Callable[[str], Instance]


@pytest.fixture(scope="module")
def make(tmp_path_factory: pytest.TempPathFactory) -> Make:
    """Return a maker of components outside FMUs."""
    folder = tmp_path_factory.mktemp("missions")
    for name, content in data_resources(MISSION_DATA).items():
        (folder / name).write_bytes(content)
    return lambda component: PythonInstance(component, folder)


@pytest.mark.parametrize("component", STEPS)
def test_every_parameter_changes_a_run(make: Make, component: str):
    assert without_effect(make, component) == []


@pytest.mark.parametrize("component", STEPS)
def test_numbers_in_other_units_are_the_same_run(make: Make, component: str, monkeypatch: pytest.MonkeyPatch):
    """A quantity that was in another unit than its port states, or was converted, would not fit the others."""
    expected = fly(make(component), component, {})
    form = InOtherUnits()
    for name, unit in (("EARTH_RADIUS", form.factor("m")), ("FIELD_RADIUS", form.factor("m")),
                       ("EARTH", form.factor("m") ** 3 / form.factor("s") ** 2)):  # fmt: skip
        monkeypatch.setattr(environment, name, unit * getattr(environment, name))
    found = fly(make(component), component, {}, form)

    for name, values in expected.items():
        assert_array_equal(found[name], values, err_msg=name)


@pytest.mark.parametrize("component", STEPS)
def test_wheels_thrusters_and_axes_in_another_order_are_the_same_run(make: Make, component: str):
    """An element that was taken for another one would not fit."""
    assert differences(make, component, InOtherOrder(), 1e-11) == {}  # sums in another order


@pytest.mark.parametrize("component", STEPS)
def test_at_each_limit_outputs_are_finite_or_the_value_is_refused_in_one_line(make: Make, component: str):
    for port in make(component).table:
        if port.causality != "parameter" or port.kind not in ("real", "integer"):
            continue
        assert port.minimum is not None, port.name
        assert port.maximum is not None or port.name == "seed"
        for limit in (port.minimum, port.maximum):
            if limit is None:
                continue
            value = limit if port.kind == "real" else int(limit)
            refusal = ""
            try:
                run = fly(make(component), component, {port.name: value}, steps=8)
            except ValueError as error:
                refusal = str(error)
            if refusal:  # in the first step where that gives its length
                assert refusal.startswith(("exitInitializationMode: ", "doStep at t = 0.0 s: ")), (port.name, limit)
                assert "\n" not in refusal
            else:
                assert all(np.isfinite(values).all() for values in run.values()), (port.name, limit)


def test_each_command_of_a_timeline_has_its_own_time_action_and_rotation(make: Make):
    run = fly(make("mission"), "mission", {"slew.lead": 3.0})
    done, mode = run["timeline.done"].ravel(), run["mode"].ravel()
    begun = [int(np.flatnonzero(done == number)[0]) for number in (1, 2, 3)]
    given = BASE["mission"]
    rotations = np.reshape(given["timeline.rotation"], (-1, 3))

    assert [mode[k] for k in begun] == [1.0, 4.0, 1.0]  # slew, off-load, slew
    assert all(5e-3 * k >= given["timeline.time"][number] for number, k in enumerate(begun))
    assert_array_equal(run["command.rotation"][[begun[0], begun[2]]], rotations[[0, 2]])
    assert run["command.start_time"][[begun[0], begun[2]], 0].tolist() == [5e-3 * k + 3.0 for k in (begun[0], begun[2])]
