"""fmi2GetDirectionalDerivative: outputs that follow inputs, in the present state; where it is not there, it is said."""

import math
import zipfile
from ctypes import c_double, c_size_t, c_uint
from xml.etree import ElementTree

import numpy as np
import pytest
from numpy.testing import assert_allclose

from fmus.raw_fmu import ERROR, OK, Library


@pytest.fixture(scope="module")
def library(follower, tmp_path_factory):
    return Library(follower, tmp_path_factory.mktemp("unpacked"))


def derivative(one, unknown, known, seed):
    """Return the status and the sensitivities of unknowns, named or by value reference."""
    reference = one.library.reference
    unknowns, knowns = ([reference.get(name, name) for name in names] for names in (unknown, known))
    n, m = len(unknowns), len(knowns)
    found = (c_double * n)(*[77.0] * n)
    given = ((c_uint * n)(*unknowns), c_size_t(n), (c_uint * m)(*knowns), c_size_t(m), (c_double * m)(*seed), found)
    return one.call("GetDirectionalDerivative", *given), list(found)


def test_values_in_every_state_that_the_standard_allows(one):
    reference = one.library.reference
    assert one.setup() == one.call("EnterInitializationMode") == OK
    unknown, known = ["y[1]", "y[2]", "x"], ["u[1]", "u[2]"]
    assert derivative(one, unknown, known, [1.0, 0.0]) == (OK, [1.5, 1.0, 0.0])
    assert one.call("ExitInitializationMode") == one.step(0.0) == OK
    assert derivative(one, unknown, known, [10.0, 1.0]) == (OK, [16.0, 10.0, 0.0])
    assert one.set("Real", [reference["u[1]"]], [0.0]) == OK  # the kink: either side, and inputs that nobody has read
    assert derivative(one, unknown, ["u[1]"], [1.0]) == (OK, [1.5, 1.0, 0.0])
    assert derivative(one, ["y[2]", "y[1]"], ["u[1]"], [-1.0]) == (OK, [1.0, -1.5])
    assert derivative(one, ["y[1]"], ["u[1]", "u[1]"], [1.0, 3.0]) == (OK, [6.0])
    assert derivative(one, [], known, [1.0, 2.0]) == (OK, [])
    assert derivative(one, ["y[1]"], [], []) == (OK, [0.0])
    assert one.call("Terminate") == OK
    assert derivative(one, ["y[1]"], ["u[1]"], [1.0]) == (OK, [1.5])
    assert one.library.logged == []


def test_what_is_no_derivative_is_refused(one):
    integer = one.library.reference["n"]
    gain = one.library.reference["gain"]
    for unknown, known, seed, reason in (
        (["u[1]"], ["u[1]"], [1.0], "unknown 1: value reference 0 is not that of a real output"),
        (["y[1]", "n"], ["u[1]"], [1.0], f"unknown 2: value reference {integer} is not that of a real output"),
        ([4_000_000_000], [], [], "unknown 1: value reference 4000000000 is not that of a real output"),
        (["y[1]"], ["u[1]", "gain"], [1.0, 1.0], f"known 2: value reference {gain} is not that of a real input"),
        (["y[1]"], ["y[1]"], [1.0], "known 1: value reference 2 is not that of a real input"),
        (["y[1]"], ["u[1]"], [math.nan], "seed 1 must be finite, got nan"),
        (["y[1]"], ["u[1]"], [math.inf], "seed 1 must be finite, got inf"),
        (["x", "y[1]"], ["u[1]"], [1.7e308], "the derivative of y[1] is inf: the seeds are too large"),
    ):
        one.call("Reset")
        one.library.logged.clear()
        assert one.set("Real", [one.library.reference["u[2]"]], [30.0]) == OK
        status, found = derivative(one.initialise(), unknown, known, seed)
        assert (status, found) == (ERROR, [77.0] * len(unknown))
        assert [text for *_, text in one.library.logged] == [f"getDirectionalDerivative: {reason}"]
        assert one.step(0.0) == ERROR  # as after any refused call
    two, n = (c_uint * 1)(2), c_size_t(1)
    for arguments, reason in (
        ((None, n, two, n, (c_double * 1)(), (c_double * 1)()), "1 unknowns in a NULL array"),
        ((two, n, two, n, (c_double * 1)(), None), "1 unknowns in a NULL array"),
        ((two, n, None, n, (c_double * 1)(), (c_double * 1)()), "1 knowns in a NULL array"),
        ((two, n, two, n, None, (c_double * 1)()), "1 knowns in a NULL array"),
    ):
        one.call("Reset")
        assert one.initialise().call("GetDirectionalDerivative", *arguments) == ERROR
        assert one.library.logged[-1][3] == f"getDirectionalDerivative: {reason}"


def test_it_needs_an_initialised_instance(one):
    for prepare in (lambda: OK, lambda: one.initialise().step(0.0, -1.0)):
        prepare()
        one.library.logged.clear()
        assert derivative(one, ["y[1]"], ["u[1]"], [1.0]) == (ERROR, [77.0])
        assert len(one.library.logged) == 1
        one.call("Reset")


def flag(path):
    with zipfile.ZipFile(path) as archive:
        root = ElementTree.fromstring(archive.read("modelDescription.xml"))
    return root.find("CoSimulation").get("providesDirectionalDerivative", "false")


def test_the_plant_has_it_and_what_samples_its_inputs_in_a_step_has_not(delivered, tmp_path):
    """By differences through FMI: exact but for rounding, as the plant's outputs are linear in its inputs."""
    folder = delivered / "centralised"
    assert flag(folder / "native" / "plant.fmu") == "true"
    others = (folder / "plant.fmu", folder / "native" / "sensors.fmu", folder / "native" / "controller.fmu")
    assert [flag(path) for path in others] == ["false"] * 3
    library = Library(folder / "native" / "plant.fmu", tmp_path)
    one = library.instantiate().initialise()
    inputs, outputs = library.references("Real", "input"), library.references("Real", "output")
    present = np.random.default_rng(1).uniform(-0.1, 0.1, len(inputs))
    for k in range(5):
        assert one.set("Real", inputs, present) == OK
        assert one.step(k * library.step) == OK
    before = np.array(one.get("Real", outputs)[1])
    for place, reference in enumerate(inputs):
        status, found = derivative(one, outputs, [reference], [2.0])
        assert status == OK
        changed = present.copy()
        changed[place] += 2.0  # [N.m], below the largest torque
        assert one.set("Real", inputs, changed) == OK
        assert_allclose(found, np.array(one.get("Real", outputs)[1]) - before, rtol=0.0, atol=1e-12)
        assert one.set("Real", inputs, present) == OK
    assert library.logged == []
    one.free()
