"""FMUs of FMI 3.0 inside a bundle of either version: bits, single elements of arrays, states, ends and errors."""

import pytest

from fmus.bundle_host import CLOSED, MS, Host, alone, bits, bundled, recorded
from fmus.cell.four_cells import wire
from lockstep import Component, System
from lockstep.bundle.ports import Choice

OPEN = Choice(inputs=("all",), outputs=("all",))
VERSIONS = ["2.0", "3.0"]


@pytest.fixture(scope="module")
def nested(cells, tmp_path_factory):
    """Return a system of one component: the four cells as an FMU of FMI 3.0."""
    path = bundled(cells, tmp_path_factory.mktemp("inner") / "four.fmu", version="3.0")
    return System(name="outer", tick=MS, components=(Component(name="in", source=path, period=MS, isolated=False),))


@pytest.fixture(scope="module")
def chain(cells, reference_fmu):
    """Return a cell, whose outputs go through single elements of the arrays of two FMUs of FMI 3.0, and back."""
    feed = reference_fmu("feedthrough", "3.0")

    def plain(start, end, delay, **more):
        return wire(start, end, delay, convert_units=False, **more)

    first = {"vector_in[1]": 3.0, "matrix_in[2,1]": 0.5, "words_in[2]": "said", "flags_in[1]": True}
    return System(
        name="chain",
        tick=MS,
        components=(
            Component(name="body", source=cells.components[0].source, period=MS, kind="continuous",
                      parameters={"gain": 40.0, "u[3]": 2.0}),
            Component(name="a", source=feed, period=MS, kind="sampled", parameters=first),
            Component(name="b", source=feed, period=2 * MS, kind="continuous"),
        ),
        connections=(
            plain("body.y[1]", "a.vector_in[2]", 1, factor=3.0, offset=0.5),
            plain("body.y[2]", "a.matrix_in[1,2]", 1),
            plain("body.y[3]", "a.Float64_in", 1),
            plain("body.n", "a.Int32_in", 1),
            plain("body.flag", "a.flags_in[2]", 1),
            plain("a.vector_out[2]", "b.matrix_in[2,3]", 0),
            plain("a.matrix_out[1,2]", "b.matrix_in[1,1]", 0),
            plain("a.matrix_out[2,1]", "b.Float64_in", 0),
            plain("a.flags_out[2]", "b.Boolean_in", 0),
            plain("a.Int32_out", "body.k", 0),
            plain("b.matrix_out[2,3]", "body.u[1]", 2),
        ),
    )  # fmt: skip


@pytest.mark.parametrize("version", VERSIONS)
def test_a_bundle_in_a_bundle_is_the_same(cells, nested, tmp_path, version):
    expected = recorded(cells, 0.02)
    found = alone(bundled(nested, tmp_path / "outer.fmu", version=version), 0.02)

    for name in expected.keys() - {"arm.text"}:
        assert bits(found[f"in.{name}"]) == bits(expected[name]), name


def test_elements_of_arrays_are_those_of_the_master(chain, tmp_path):
    expected = recorded(chain, 0.03)
    found = alone(bundled(chain, tmp_path / "chain.fmu", version="3.0"), 0.03)
    other = alone(bundled(chain, tmp_path / "chain2.fmu"), 0.03)
    names = [name for name in expected if name in found]

    assert {"b.matrix_out[2,3]", "a.vector_out[1]", "a.flags_out[2]", "a.words_out[2]", "body.y[1]"} <= set(names)
    assert not any("Int8" in name or "Float32" in name or "narrow" in name for name in found)
    assert len(set(expected["b.matrix_out[2,3]"])) > 10
    for name in names:
        assert bits(found[name]) == bits(expected[name]) == bits(other[name]), name


def test_elements_that_are_set_alone_leave_the_others_also_after_a_state_is_restored(chain, tmp_path):
    single = System(name="one", tick=MS, components=(chain.component("a"),))
    path = bundled(single, tmp_path / "one.fmu", OPEN)
    names = [f"a.vector_out[{k}]" for k in (1, 2, 3)]

    def put(host, values):
        assert max(host.set_one(f"a.{name}", value) for name, value in values.items()) == 0

    with Host(path, tmp_path / "a") as host, Host(path, tmp_path / "b") as other:
        host.start()
        put(host, {"vector_in[2]": 5.0, "words_in[1]": "one"})
        host.run(0, 1)
        # the sample at 0 was taken before; a sampled component takes what is set in the step that begins there
        assert host.get(*names, "a.words_out[1]", "a.words_out[2]") == [3.0, 5.0, 0.0, "one", "said"]
        state = host.state()
        content = host.serialised(state)
        put(host, {"vector_in[1]": 7.0, "vector_in[2]": 8.0, "words_in[1]": "two"})
        assert host.call("SetFMUstate", state) == 0
        put(host, {"vector_in[3]": 9.0})
        host.run(1, 2)
        assert host.get(*names, "a.words_out[1]") == [3.0, 5.0, 9.0, "one"]
        status, found = other.deserialised(content)
        assert (status, other.call("SetFMUstate", found)) == (0, 0)
        put(other, {"vector_in[3]": 9.0})
        other.run(1, 2)
        assert other.get(*names, "a.words_out[1]", "a.words_out[2]") == [3.0, 5.0, 9.0, "one", "said"]
        assert host.slave.reset() == 0
        host.start()
        host.run(0, 1)
        assert host.get(*names, "a.words_out[1]") == [3.0, 0.0, 0.0, ""]


@pytest.mark.parametrize("version", VERSIONS)
def test_errors_and_messages_of_components_have_their_names_and_states_their_bits(nested, tmp_path, version):
    path = bundled(nested, tmp_path / "outer.fmu", CLOSED, {"in.body.label": "talk"}, version=version)
    with Host(path, tmp_path / "a") as host, Host(path, tmp_path / "b") as other:
        host.set(in__slow__fail_at=0.017)
        host.start()
        host.run(0, 7)
        content = host.serialised(host.state())
        following = host.run(7, 16)
        status, state = other.deserialised(content)
        assert (status, other.call("SetFMUstate", state)) == (0, 0)
        assert other.run(7, 16) == following
        assert host.slave.do_step(0.016, 0.001, 1) == 3  # it takes the sample at its end
        assert "in: slow: fails at 100% of Real 10 and 0.017 s" in host.texts
        assert "in: fmi3DoStep returned fmi3Error at 0.016 s" in host.texts
        assert next(text for text in host.texts if "50%" in text).startswith("in: body: x is ")


@pytest.mark.parametrize(
    ("mode", "status", "text"),
    [
        (0, 2, "s: fmi3DoStep returned fmi3Discard at 0.004 s"),  # it asks for the end: a regular one
        (1, 3, "s: fmi3DoStep returned early at 0.002 s, which is not allowed"),
        (2, 3, "s: fmi3DoStep asked for event mode at 0.002 s, which is not allowed"),
        (4, 3, "s: the stair has a broken step"),
        (5, 4, "s: fmi3DoStep returned fmi3Fatal at 0.002 s"),
    ],
)
def test_a_step_with_a_flag_ends_the_run_or_is_an_error(reference_fmu, tmp_path, mode, status, text):
    values = {"last": 4, "mode": mode, "at": 3}
    part = Component(name="s", source=reference_fmu("stair", "3.0"), period=MS, parameters=values)
    path = bundled(System(name="one", tick=MS, components=(part,)), tmp_path / "one.fmu", version="3.0")
    with Host(path, tmp_path / "a") as host:
        host.start()
        found = [host.slave.do_step(k / 1000, 0.001, 1) for k in range(5)]
        assert next(one for one in found if one) == status
        assert text in host.texts
        assert found.index(status) == (4 if mode == 0 else 2)


def test_an_fmu_finds_its_resources(reference_fmu, tmp_path):
    part = Component(name="reader", source=reference_fmu("resource", "3.0"), period=MS)
    system = System(name="one", tick=MS, components=(part,))
    expected = recorded(system, 0.005)
    for version in VERSIONS:
        found = alone(bundled(system, tmp_path / f"one{version}.fmu", version=version), 0.005)
        assert bits(found["reader.number"]) == bits(expected["reader.number"])
    assert expected["reader.count"][-1] > 0
