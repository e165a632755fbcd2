"""The native toy in FMI 3.0, called in every phase: what the standard allows, and what each refusal leaves."""

import math
from ctypes import byref, c_bool, c_char_p, c_double, c_size_t, c_uint32, c_void_p

import pytest

from fmus.call_sequences3 import run
from fmus.raw_fmu3 import ERROR, OK, WARNING, Library3

PHASES = ("instantiated", "initialization", "step", "terminated", "error")
# FMI 3.0.2, sections 2.3 and 4.2; after an error an instance is terminated
ALLOWED = {
    "enter": {"instantiated"},
    "leave": {"initialization"},
    "step": {"step"},
    "terminate": {"step"},
    "get": {"initialization", "step", "terminated", "error"},
    "get start": set(PHASES),
    "set": {"instantiated", "initialization", "step"},
    "save": set(PHASES),
    "log": set(PHASES),
    "reset": set(PHASES),
    "empty list": set(PHASES),
    "event mode": set(),
    "configuration mode": set(),
    "model exchange": set(),
    "adjoint": set(),
    "clocks": set(),
}


@pytest.fixture(scope="module")
def library(native_toy_fmi3, tmp_path_factory):
    return Library3(native_toy_fmi3, tmp_path_factory.mktemp("unpacked"))


def in_phase(one, phase):
    calls = {
        "initialization": [lambda: one.enter(0.0, 0.5)],
        "step": [lambda: one.call("ExitInitializationMode"), lambda: one.step(0.0)],
        "terminated": [lambda: one.call("Terminate")],
    }
    for name in PHASES[1 : PHASES.index(phase) + 1]:
        for call in calls.get(name, ()) if not (phase == "error" and name == "terminated") else ():
            assert call() == OK
    if phase == "error":
        assert one.step(0.01, -1.0) == ERROR
        one.library.logged.clear()


def make_call(one, name):
    return {
        "enter": one.enter,
        "leave": lambda: one.call("ExitInitializationMode"),
        "step": lambda: one.step(0.01),
        "terminate": lambda: one.call("Terminate"),
        "get": lambda: one.get("Float64", ["level"])[0],
        "get start": lambda: one.get("Float64", ["time", "gain"])[0],
        "set": lambda: one.set("Float64", ["wheel.torque"], [1.0, 2.0, 3.0]),
        "save": lambda: one.get_state()[0],
        "log": lambda: one.call("SetDebugLogging", c_bool(True), c_size_t(0), None),
        "reset": lambda: one.call("Reset"),
        "empty list": lambda: one.call("GetUInt8", None, c_size_t(0), None, c_size_t(0)),
        "event mode": lambda: one.call("EnterEventMode"),
        "configuration mode": lambda: one.call("EnterConfigurationMode"),
        "model exchange": lambda: one.call("GetNumberOfContinuousStates", byref(c_size_t())),
        "adjoint": lambda: one.call("GetAdjointDerivative", None, c_size_t(0), None, c_size_t(0), None, c_size_t(0),
                                    None, c_size_t(0)),
        "clocks": lambda: one.call("GetIntervalDecimal", None, c_size_t(0), None, None),
    }[name]()  # fmt: skip


@pytest.mark.parametrize("phase", PHASES)
@pytest.mark.parametrize("name", ALLOWED)
def test_each_call_in_each_phase(one, name, phase):
    in_phase(one, phase)
    before = one.get_state()[1]

    if phase in ALLOWED[name]:
        assert make_call(one, name) == OK
        assert one.library.logged == []
        return
    assert make_call(one, name) == ERROR
    ((level, category, text),) = one.library.logged
    assert (level, category) == (ERROR, b"logStatusError")
    assert text.partition(": ")[2].startswith(
        (
            "not allowed ",
            "refused since: doStep at t = 0.01 s: a step of -1.0 s",
            "not supported",
            "outputs are not read",
        )
    )
    if phase != "instantiated":
        status, values = one.get("Float64", ["level"])
        assert status == OK
        assert all(map(math.isnan, values))  # from now on no result can be mistaken for one
    assert one.step(0.01) == ERROR  # the error lasts
    assert one.call("SetFMUState", before) == OK
    if phase == "step":  # as if nothing had been called
        assert one.step(0.01) == OK


def test_a_step_answers_flags_and_the_time_reached(one):
    in_phase(one, "step")
    assert (list(one.flags), one.reached.value) == ([False] * 3, 0.01)
    assert one.get("Float64", ["time"]) == (OK, [0.01])
    assert one.step(0.01) == OK
    assert (list(one.flags), one.reached.value) == ([False] * 3, 0.02)
    assert one.step(0.49, 0.1) == ERROR
    assert (list(one.flags), one.reached.value) == ([False] * 3, 0.02)
    one.call("Reset")
    one.library.logged.clear()
    one.initialise()
    for place in range(4):
        one.call("Reset")
        one.initialise()
        given = [byref(c_bool()), byref(c_bool()), byref(c_bool()), byref(c_double())]
        given[place] = None
        assert one.call("DoStep", c_double(0.0), c_double(0.01), c_bool(True), *given) == ERROR
        assert one.library.logged[-1][2] == "doStep: a flag or the last successful time goes to a NULL pointer"


def test_all_types_and_arrays_are_set_and_read_whole(one):
    assert one.get("Float64", ["gain", "wheel.torque", "time"]) == (OK, [1.0, 0.0, 0.0, 0.0, 0.0])  # start values
    assert one.set("Float64", ["gain", "wheel.torque"], [2.0, 0.1, 0.2, 0.3]) == OK
    assert one.set("Int32", ["seed"], [-3]) == OK
    assert one.set("String", ["label"], ["Süd#1".encode()]) == OK
    assert one.set("Boolean", ["explode"], [False]) == OK
    assert one.enter() == OK
    assert one.get("Float64", ["level", "energy"]) == (OK, [2.0, 2.0, 2.0, 12.0])
    assert one.get("Boolean", ["valid", "explode"]) == (OK, [False, False])
    assert one.call("ExitInitializationMode") == one.step(0.0) == OK
    assert one.get("Boolean", ["valid"]) == (OK, [True])
    assert one.get("String", ["greeting", "label"]) == (OK, ["Süd#1 1".encode(), "Süd#1".encode()])
    assert one.get("Int32", ["seed", "evaluations"]) == (OK, [-3, 1])
    assert one.library.logged == []


def test_wrong_references_sizes_and_values_are_refused(one):
    cases = [
        (lambda: one.get("Float64", ["seed"], 1), "Float64 value reference 8: no such variable; it is that of seed,"
         " which is Int32"),
        (lambda: one.get("Int32", ["time"], 1), "Int32 value reference 0: no such variable; it is that of the time,"
         " which is Float64"),
        (lambda: one.get("String", [13], 1), "String value reference 13: no such variable; there are 13 of all types,"
         " from 0 on"),
        (lambda: one.get("Float64", [4_000_000_000], 1), "Float64 value reference 4000000000: no such variable; there"
         " are 13 of all types, from 0 on"),
        (lambda: one.get("Float64", ["level", "gain"], 3), "3 values, where the variables have 4 elements"),
        (lambda: one.set("Float64", ["wheel.torque"], [1.0]), "1 values, where the variables have 3 elements"),
        (lambda: one.set("Float64", ["wheel.torque"], [1.0, math.nan, 1.0]),
         "wheel.torque[2] must be finite, got nan"),
        (lambda: one.set("Float64", ["gain"], [-1.0]), "gain is a fixed parameter and cannot be set after"
         " initialisation, got -1.0"),
        (lambda: one.set("Float64", ["level"], [1.0] * 3), "level[1] is an output and cannot be set"),
        (lambda: one.set("Float64", ["time"], [1.0]), "the time is the independent variable and cannot be set"),
        (lambda: one.set("String", ["label"], [None]), "value 1 is NULL"),
        (lambda: one.set("String", ["label"], [b"\xff"]), "value 1 is not UTF-8: ?"),
        (lambda: (one.call("SetBoolean", None, c_size_t(1), None, c_size_t(1)),), "1 value references in a NULL array"),
        (lambda: (one.call("GetFloat64", (c_uint32 * 1)(1), c_size_t(1), None, c_size_t(3)),),
         "3 values in a NULL array"),
        (lambda: (one.call("GetUInt64", (c_uint32 * 1)(8), c_size_t(1), None, c_size_t(1)),),
         "UInt64 value reference 8: no such variable; it is that of seed, which is Int32"),
        (lambda: (one.call("SetBinary", None, c_size_t(0), None, None, c_size_t(2)),), "2 values of no variable"),
        (lambda: (one.call("GetClock", None, c_size_t(1), None),), "1 value references in a NULL array"),
    ]  # fmt: skip
    for call, reason in cases:
        one.call("Reset")
        one.initialise().library.logged.clear()
        answer = call()
        assert (answer[0] if isinstance(answer, tuple) else answer) == ERROR, reason
        assert [text.partition(": ")[2] for *_, text in one.library.logged] == [reason]
        assert one.step(0.0) == ERROR


def test_wrong_experiments_are_refused(one):
    for arguments, reason in (
        ((math.nan,), "the start time must be finite, got nan s"),
        ((1.0, 0.5), "the stop time must be finite and not before the start time 1.0 s, got 0.5 s"),
        ((0.0, None, -1e-5), "the tolerance must be finite and >= 0, got -1e-05"),
    ):
        one.call("Reset")
        one.library.logged.clear()
        assert one.enter(*arguments) == ERROR
        assert [text for *_, text in one.library.logged] == [f"enterInitializationMode: {reason}"]


def test_what_cannot_be_instantiated_gives_null_and_a_reason(library):
    for given, reason in (
        ({"token": b"{0}"}, "fmi3InstantiateCoSimulation: the instantiation token {0} is not that of this FMU, "),
        ({"token": None}, "fmi3InstantiateCoSimulation: the instantiation token is NULL"),
        ({"name": b" "}, "fmi3InstantiateCoSimulation: the instance has no name"),
        ({"name": None}, "fmi3InstantiateCoSimulation: the instance has no name"),
        ({"events": True}, "fmi3InstantiateCoSimulation: there is no event mode"),
        ({"required": [1]}, "fmi3InstantiateCoSimulation: there is no intermediate update"),
    ):
        library.logged.clear()
        assert library.instantiate(**given) is None
        ((level, _, text),) = library.logged
        assert level == ERROR
        assert text.startswith(reason)
    library.logged.clear()
    assert library.instantiate(token=b"{0}", logging=False) is None  # the host wants no messages
    assert library.logged == []
    for kind in ("ModelExchange", "ScheduledExecution"):
        further = [None] * 3 if kind == "ScheduledExecution" else []
        text = (b"one", library.token, None, c_bool(False), c_bool(True), None, library.logger, *further)
        assert getattr(library.dll, f"fmi3Instantiate{kind}")(*text) is None
        assert library.logged.pop()[2] == f"fmi3Instantiate{kind}: this FMU is for co-simulation only"
    quiet = library.instantiate(early=True, logger=False)  # a host may allow what no step does, and log nothing
    assert quiet.initialise().step(0.0, -1.0) == ERROR
    quiet.free()
    library.dll.fmi3FreeInstance(None)
    assert library.dll.fmi3DoStep(None, c_double(), c_double(), c_bool(), *[None] * 4) == ERROR
    assert library.dll.fmi3GetVersion() == b"3.0"


def test_hosts_switch_messages_off_and_on(one):
    def refused():
        one.library.logged.clear()
        one.call("Reset")
        assert one.step(0.0) == ERROR
        return len(one.library.logged)

    def switch(on, *categories):
        names = (c_char_p * len(categories))(*categories) if categories else None
        return one.call("SetDebugLogging", c_bool(on), c_size_t(len(categories)), names)

    assert refused() == 1
    assert switch(False) == OK
    assert refused() == 0
    assert switch(True, b"logStatusError") == OK
    assert refused() == 1
    assert switch(False, b"logEvents") == WARNING
    assert one.library.logged[-1][2] == "setDebugLogging: no category logEvents; there is logStatusError"
    assert refused() == 1
    one.call("Reset")
    assert switch(True, None) == ERROR
    assert one.library.logged[-1][2] == "setDebugLogging: category 1 is NULL"


def test_a_hash_in_a_message_is_doubled(one):
    one.initialise()
    assert one.set("String", ["label"], [b"#1"]) == ERROR
    assert one.library.logged[-1][2].endswith("after initialisation, got '##1'")


def test_states_are_restored_serialised_and_of_their_own_fmu_only(one, library):
    other = library.instantiate(b"two")
    in_phase(one, "step")
    status, state = one.get_state()
    status, content = one.serialise(state)
    assert one.set("Float64", ["wheel.torque"], [0.5] * 3) == one.step(0.01) == OK
    expected = one.get("Float64", ["level", "time"])
    for instance in (one, other):
        status, made = instance.deserialise(content)
        assert status == OK
        assert instance.call("SetFMUState", made) == OK
        assert instance.get("Float64", ["time"]) == (OK, [0.01])
        assert instance.set("Float64", ["wheel.torque"], [0.5] * 3) == instance.step(0.01) == OK
        assert instance.get("Float64", ["level", "time"]) == expected
        assert instance.call("FreeFMUState", byref(made)) == OK
        assert made.value is None
        assert instance.call("FreeFMUState", byref(made)) == OK  # of NULL, as the standard says
    for damaged in (content[:-1], content[:40], b"", content[:100] + b"\x01" + content[101:]):
        status, made = other.deserialise(damaged)
        assert (status, made.value) == (ERROR, None)
        assert "are not a saved state of this component" in library.logged[-1][2]
    assert other.call("SetFMUState", state) == ERROR  # of the first instance
    assert library.logged[-1][2] == "setFMUState: no state of this instance: freed, or of another one"
    assert other.call("SetFMUState", c_void_p()) == ERROR
    assert other.call("GetFMUState", None) == ERROR
    other.free()


def test_sequences_of_calls_are_answered_as_the_standard_says(native_toy_fmi3, tmp_path):
    """By hand 100,000: `python tests/fmus/call_sequences3.py FMU`."""
    calls, refused = run(native_toy_fmi3, tmp_path, 300)

    assert sum(calls.values()) > 5000
    assert sum(refused.values()) > 2000
    assert set(calls) - set(refused) == {"Reset", "GetFMUState", "SetFMUState", "FreeFMUState", "log"}
