"""Calls of one instance: parameters, steps that are refused, reset, several instances, states, and what it logs."""

from ctypes import byref
from dataclasses import replace

import pytest

from fmus.bundle_host import MS, Host, bundled
from lockstep import Component
from lockstep.bundle.ports import Choice
from lockstep.errors import RunError
from lockstep.fmi.instance import Hooks
from lockstep.fmi.instantiate import instantiate_unpacked
from lockstep.fmi.library import UnpackedFmu, unpack_fmu
from lockstep.fmi.model_description import read_description

OPEN = Choice(outputs=("all",))  # the inputs are the connectors of the system


@pytest.fixture(scope="module", params=["2.0", "3.0"])
def version(request):
    """Return the version of FMI that hosts see."""
    return request.param


@pytest.fixture(scope="module")
def path(cells, tmp_path_factory, version):
    """Return the bundle."""
    return bundled(cells, tmp_path_factory.mktemp("life") / "four.fmu", OPEN, version=version)


@pytest.fixture
def host(path, tmp_path):
    """Return an instance in step mode."""
    with Host(path, tmp_path / "unpacked") as found:
        yield found.start()


def another(path, folder, **values):
    """Return an instance in step mode, with start values."""
    return Host(path, folder).start(**values)


def test_parameters_reach_their_components_before_and_tunable_ones_while_it_runs(path, tmp_path):
    with Host(path, tmp_path / "a") as host, another(path, tmp_path / "b") as plain:
        assert host.get("fast.gain", "slow.trim", "arm.gain", "fast.label") == [1.5, 0.25, 0.5, "quick"]
        assert host.set(arm__gain=2.0, fast__label="other") == 0
        host.start()
        assert host.get("arm.gain", "fast.label", "fast.text") == [2.0, "other", "other 0"]
        same, changed = plain.run(0, 8), host.run(0, 8)
        assert same != changed
        before = host.get("body.y[1]")[0]
        assert host.set(body__trim=0.5) == 0
        host.run(8, 9)
        assert abs(host.get("body.y[1]")[0] - before) > 0.4
        assert host.set(arm__gain=3.0) == 3
        assert "is a fixed parameter; set it before initialization" in host.texts[-1]


def test_inputs_are_held_over_a_step_and_reach_their_components(host):
    host.run(0, 4)
    before = host.get("arm.y[3]", "fast.n")
    host.set(push=0.5, number=100)
    assert host.get("arm.y[3]", "fast.n", "push", "number") == [*before, 0.5, 100]  # outputs of the communication point
    host.run(4, 6)
    assert host.get("arm.y[3]")[0] == pytest.approx(before[0] + 0.5, abs=0.01)
    assert host.get("fast.n")[0] > 99


@pytest.mark.parametrize(
    ("time", "step", "text"),
    [
        (0.0, 0.0015, "step 0.0015 s must be a multiple of 0.001 s, the tick of the system"),
        (0.0, 0.0, "step 0 s must be a multiple"),
        (0.0, -0.001, "step -0.001 s must be a multiple"),
        (0.0, float("nan"), "step nan s must be a multiple"),
        (0.0, 1e300, "step 1e+300 s must be a multiple"),
        (0.001, 0.001, "begins at 0.001 s, and the instance is at 0 s"),
        (float("nan"), 0.001, "begins at nan s, and the instance is at 0 s"),
    ],
)
def test_a_wrong_step_is_refused_and_a_right_one_follows(host, time, step, text):
    assert host.slave.do_step(time, step, 1) == 3
    assert text in host.texts[-1]
    host.run(0, 1)


def test_accumulated_times_of_hosts_are_accepted(host):
    time = 0.0
    for _ in range(3000):
        assert host.slave.do_step(time, 0.001, 1) == 0, host.texts
        time += 0.001


def test_reset_and_other_instances_repeat_every_bit(path, tmp_path):
    with another(path, tmp_path / "a") as one, another(path, tmp_path / "b", order=2.0) as two:
        first, other = one.run(0, 12), two.run(0, 12)
        assert first != other
        assert one.slave.reset() == 0
        assert one.get("fast.gain")[0] == 1.5
        one.start()
        turns = [(one.run(k, k + 1)[0], two.run(12 + k, 13 + k)) for k in range(12)]
        assert [row for row, _ in turns] == first


def test_a_state_goes_on_with_every_bit_also_in_another_instance(path, tmp_path):
    with another(path, tmp_path / "a", order=0.5) as one, Host(path, tmp_path / "b") as two:
        one.run(0, 7)
        state = one.state()
        content = one.serialised(state)
        following = one.run(7, 19)
        assert one.call("SetFMUstate", state) == 0
        assert one.row() != following[-1]
        assert one.run(7, 19) == following
        assert one.call("FreeFMUstate", byref(state)) == 0
        assert state.value is None
        status, other = two.deserialised(content)
        assert (status, two.call("SetFMUstate", other)) == (0, 0)
        assert two.get("order")[0] == 0.5
        assert two.run(7, 19) == following
        assert two.serialised(other) == content


def test_bad_states_are_refused_and_change_nothing(path, tmp_path):
    with another(path, tmp_path / "a") as one, another(path, tmp_path / "b") as two:
        state = one.state()
        content = one.serialised(state)
        for bad in (b"", content[:20], content[:-1], content[:200], b"x" + content[1:]):
            assert one.deserialised(bad)[0] == 3
        assert two.call("SetFMUstate", state) == 3
        assert "none of this instance" in two.texts[-1]
        assert one.run(0, 3) == two.run(0, 3)


@pytest.mark.parametrize(
    ("setting", "status", "text"),
    [
        ({"slow__fail_at": 0.007}, 3, "slow: fmi2DoStep returned fmi2Error at 0.007 s"),
        ({"body__nan_at": 0.006, "push": 0.0}, 0, ""),  # of an output that no connection reads
        ({"fast__fatal_at": 0.005}, 4, "fast: fmi2DoStep returned fmi2Fatal at 0.005 s"),
    ],
)
def test_an_error_names_component_call_and_time(path, tmp_path, setting, status, text):
    with another(path, tmp_path / "a", **setting) as host:
        worst = [host.slave.do_step(k / 1000, 0.001, 1) for k in range(12)]

        assert max(worst) >= status
        if status:
            first = next(k for k, found in enumerate(worst) if found)
            assert worst[first] == status
            assert text in host.texts
            assert host.slave.do_step((first + 1) / 1000, 0.001, 1) == 3
            assert "the instance is in the state: failed" in host.texts[-1]
        else:
            assert not host.texts


def test_a_transferred_value_that_is_not_finite_is_an_error(cells, tmp_path, version):
    extra = replace(cells.connections[0], from_component="arm", output="y[3]", to_component="fast", input="u[3]")
    system = replace(cells, connections=(*cells.connections, extra))
    with another(bundled(system, tmp_path / "x.fmu", version=version), tmp_path / "a", arm__nan_at=0.01) as host:
        worst = [host.slave.do_step(k / 1000, 0.001, 1) for k in range(9)]
        assert worst == [0] * 8 + [3]
        assert "arm.y[3]: is nan at 0.01 s; every exchanged value must be finite" in host.texts[-1]


def test_messages_of_components_have_their_names(cells, tmp_path, version):
    values = {"body.label": "talk", "slow.fail_at": "0.007"}
    path = bundled(cells, tmp_path / "talk.fmu", overrides=values, version=version)
    with another(path, tmp_path / "a") as host:
        for k in range(9):
            host.slave.do_step(k / 1000, 0.001, 1)
        assert next(text for text in host.texts if "50%" in text).startswith("body: x is ")
        assert "slow: fails at 100% of Real 10 and 0.007 s" in host.texts


def test_a_component_may_ask_for_the_end(path, tmp_path):
    with another(path, tmp_path / "a", body__end_at=0.006) as host, another(path, tmp_path / "b") as plain:
        rows, others = host.run(0, 5), plain.run(0, 5)
        assert rows == others
        assert host.slave.do_step(0.005, 0.001, 1) == 2
        assert "asked for the end of the simulation, having reached 0.006 s" in host.slave.outcome("DoStep", 2)
        plain.run(5, 6)
        assert host.get("body.y[1]") == plain.get("body.y[1]")
        assert host.slave.do_step(0.006, 0.001, 1) == 3


def test_resources_of_another_place_and_another_guid_are_refused(cells, tmp_path):
    path = bundled(cells, tmp_path / "four.fmu", OPEN)
    part = Component(name="it", source=path, period=MS)
    unpack_fmu(part, tmp_path)
    description = read_description(part)
    good = UnpackedFmu(name="it", folder=tmp_path, identifier=description.identifier, guid=description.guid)
    for bad, text in (
        (replace(good, guid="{other}"), "GUID {other}: the FMU's is {"),
        (replace(good, resources="/tmp"), "fmuResourceLocation /tmp: it must be the file: URI"),
        (replace(good, resources="file:///nowhere"), "program.bin cannot be read"),
    ):
        with pytest.raises(RunError) as error:
            instantiate_unpacked(bad, "2.0", (), Hooks(log=lambda *_: None))
        assert text in str(error.value)
