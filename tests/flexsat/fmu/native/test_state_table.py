"""Every function of FMI 2.0 in every state of a native instance: what the table allows, and what a refusal leaves.

What may be set depends on causality and variability. FMI 2.0.4, section 4.2.4; the steps of this FMU are never pending.
"""

import math
from ctypes import byref, c_char, c_double, c_int, c_size_t, c_uint, c_void_p

import pytest

from fmus.raw_fmu import DISCARD, ERROR, OK, Library

NEW, INITIALISING, STEPPING, ENDED, FAILED = STATES = ("new", "initialisation", "stepping", "terminated", "error")
READABLE = {INITIALISING, STEPPING, ENDED, FAILED}
UNCHANGED = ("u[1]", "u[2]", "gain", "begin")


def pointer(kind=c_double):
    """Return a place for an answer."""
    return byref(kind())


def setting(name, value):
    return lambda one, _: one.set("Real", [one.library.reference[name]], [value])


def reading(name, kind="Real"):
    return lambda one, _: one.get(kind, [one.library.reference[name]])[0]


def calling(name, *arguments):
    return lambda one, _: one.call(name, *arguments)


def with_state(name, *arguments):
    return lambda one, state: one.call(name, state, *arguments)


def derivative(one, _):
    u, y = ((c_uint * 1)(one.library.reference[name]) for name in ("u[1]", "y[1]"))
    return one.call("GetDirectionalDerivative", y, c_size_t(1), u, c_size_t(1), (c_double * 1)(1.0), (c_double * 1)())


def deserialise(one, state):
    return one.deserialise(one.serialise(state)[1])[0]


FIRST, N = (c_uint * 1)(0), c_size_t(1)
CALLS = {
    "setup": (lambda one, _: one.setup(), {NEW}),
    "enter initialisation": (calling("EnterInitializationMode"), {NEW}),
    "leave initialisation": (calling("ExitInitializationMode"), {INITIALISING}),
    "step": (lambda one, _: one.step(0.01), {STEPPING}),
    "terminate": (calling("Terminate"), {STEPPING}),
    "reset": (calling("Reset"), set(STATES)),
    "set an input": (setting("u[1]", 7.0), {NEW, INITIALISING, STEPPING}),
    "set a fixed parameter": (setting("begin", 7.0), {NEW, INITIALISING}),
    "set a tunable parameter": (setting("gain", 7.0), {NEW, INITIALISING, STEPPING}),
    "set an output": (setting("x", 7.0), set()),
    "set an integer output": (lambda one, _: one.set("Integer", [one.library.reference["n"]], [1]), set()),
    "set nothing": (calling("SetReal", None, c_size_t(0), None), {NEW, INITIALISING, STEPPING}),
    "get nothing": (calling("GetReal", None, c_size_t(0), None), READABLE),
    "get an input": (reading("u[1]"), READABLE),
    "get a parameter": (reading("begin"), READABLE),
    "get an output": (reading("y[1]"), READABLE),
    "get an integer": (reading("n", "Integer"), READABLE),
    "get a boolean": (calling("GetBoolean", FIRST, N, (c_int * 1)()), set()),  # there is none
    "get a string": (calling("GetString", FIRST, N, (c_void_p * 1)()), set()),
    "get a state": (lambda one, _: one.get_state()[0], set(STATES)),
    "set a state": (with_state("SetFMUstate"), set(STATES)),
    "free a state": (lambda one, _: one.free_state(one.get_state()[1]), set(STATES)),
    "free no state": (calling("FreeFMUstate", byref(c_void_p())), set(STATES)),
    "size of a state": (with_state("SerializedFMUstateSize", pointer(c_size_t)), set(STATES)),
    "serialise": (lambda one, state: one.serialise(state)[0], set(STATES)),
    "serialise into too few": (with_state("SerializeFMUstate", (c_char * 3)(), c_size_t(3)), set()),
    "deserialise": (deserialise, set(STATES)),
    "deserialise one byte": (lambda one, _: one.deserialise(b"x")[0], set()),
    "log": (calling("SetDebugLogging", c_int(1), c_size_t(0), None), set(STATES)),
    "directional derivative": (derivative, {INITIALISING, STEPPING, ENDED}),
    "input derivatives": (calling("SetRealInputDerivatives", FIRST, N, (c_int * 1)(1), (c_double * 1)()), set()),
    "output derivatives": (calling("GetRealOutputDerivatives", FIRST, N, (c_int * 1)(1), (c_double * 1)()), set()),
    "cancel": (calling("CancelStep"), set()),
    "time of the last step": (calling("GetRealStatus", c_int(2), pointer()), {STEPPING, ENDED}),
    "whether terminated": (calling("GetBooleanStatus", c_int(3), pointer(c_int)), {STEPPING, ENDED}),
}
UNANSWERED = {  # fmi2Discard where they are allowed
    "status of a step": calling("GetStatus", c_int(0), pointer(c_int)),
    "integer status": calling("GetIntegerStatus", c_int(0), pointer(c_int)),
    "string status": calling("GetStringStatus", c_int(1), pointer(c_void_p)),
    "another real status": calling("GetRealStatus", c_int(0), pointer()),
    "another boolean status": calling("GetBooleanStatus", c_int(2), pointer(c_int)),
}


@pytest.fixture(scope="module")
def library(follower, tmp_path_factory):
    return Library(follower, tmp_path_factory.mktemp("unpacked"))


def in_state(library, state):
    """Return an instance in a state, with inputs and parameters that are not those of the start."""
    one = library.instantiate()
    assert one.set("Real", [library.reference[name] for name in UNCHANGED], [4.0, 5.0, 6.0, 8.0]) == OK
    assert one.setup(0.0, 0.5) == OK
    calls = {
        INITIALISING: lambda: one.call("EnterInitializationMode"),
        STEPPING: lambda: one.call("ExitInitializationMode") or one.step(0.0),
        ENDED: lambda: one.call("Terminate"),
    }
    for name in STATES[1 : (STATES.index(state) if state != FAILED else 2) + 1]:
        assert calls[name]() == OK
    if state == FAILED:
        assert one.step(0.01, math.nan) == ERROR
    library.logged.clear()
    return one


def read(one, names):
    """Return values, of an instance that may be new: then after it is initialised."""
    return one.get("Real", [one.library.reference[name] for name in names])[1]


def outputs_after_going_on(one, state):
    """Return the outputs after what a host does next, and None where it does nothing."""
    if state in (NEW, INITIALISING):
        assert state == INITIALISING or one.call("EnterInitializationMode") == OK
        assert one.call("ExitInitializationMode") == OK
    if state in (NEW, INITIALISING, STEPPING):
        assert one.step(0.01 if state == STEPPING else 0.0) == OK
    return None if state == FAILED else read(one, ("y[1]", "y[2]", "x"))


@pytest.mark.parametrize("state", STATES)
def test_the_table(library, state):
    undisturbed = in_state(library, state)
    expected = outputs_after_going_on(undisturbed, state)
    undisturbed.free()
    for name, (call, allowed) in CALLS.items():
        one = in_state(library, state)
        _, before = one.get_state()
        status = call(one, before)
        if state in allowed:
            assert (status, library.logged) == (OK, []), name
            one.free()
            continue
        assert (status, len(library.logged)) == (ERROR, 1), (name, library.logged)
        assert library.logged[0][:3] == (b"one", ERROR, "logStatusError"), name
        assert read(one, UNCHANGED) == [4.0, 5.0, 6.0, 8.0], name
        assert all(map(math.isnan, read(one, ("y[1]", "y[2]", "x")))), name  # no result can be mistaken for one
        assert one.step(0.01) == ERROR, name  # the error lasts
        assert one.set_state(before) == OK, name
        assert outputs_after_going_on(one, state) == expected, name  # as if nothing had been called
        one.free()


@pytest.mark.parametrize("state", STATES)
def test_inquiries_without_an_answer(library, state):
    for name, call in UNANSWERED.items():
        one = in_state(library, state)
        status = DISCARD if state in (STEPPING, ENDED) else ERROR
        assert (call(one, None), len(library.logged)) == (status, 1), name
        if status == DISCARD and state == STEPPING:
            assert one.step(0.01) == OK, name
        one.free()


def test_a_state_is_restored_whatever_the_inputs_have_become(library):
    """The model starts anew for the parameters of the state, but not with its inputs: no run may start with them."""
    one = in_state(library, STEPPING)
    assert one.set("Real", [library.reference["u[1]"]], [-1.0]) == OK
    _, content = one.serialise(one.get_state()[1])
    expected = outputs_after_going_on(one, STEPPING)
    one.free()
    other = library.instantiate()
    status, state = other.deserialise(content)
    assert (status, other.set_state(state)) == (OK, OK), library.logged
    assert read(other, ["u[1]"]) == [-1.0]
    assert outputs_after_going_on(other, STEPPING) == expected
    other.free()


def test_a_host_that_wants_no_log_is_refused_the_same(library):
    """Without callbacks, memory is that of the C library, and nothing is logged."""
    library.logged.clear()
    one = library.instantiate(callbacks=False)
    assert one.initialise().step(0.0) == OK
    assert one.step(5.0) == ERROR
    assert one.call("Reset") == OK
    assert one.initialise().step(0.0) == OK
    one.free()
    assert library.instantiate(callbacks=False, guid=b"{other}") is None
    assert library.logged == []
