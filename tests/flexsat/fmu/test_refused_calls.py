"""What a built FMU refuses, at the border of C: NULL, wrong texts, foreign states, wrong times; and what it leaves."""

from fmus.toys.builds import TOYS, python

HOST = f"""
import ctypes, math, tempfile
from ctypes import byref, c_char, c_char_p, c_double, c_int, c_size_t, c_uint, c_void_p
sys.path.insert(0, {str(TOYS.parents[1])!r})
from fmus.raw_fmu import *
library = Library(sys.argv[1], tempfile.mkdtemp())
logged = library.logged

def message(status, expected=ERROR):
    assert status == expected, (status, logged)
    (name, level, category, text), = logged
    assert (level, category) == (expected, "logStatusError"), logged
    logged.clear()
    return text
"""


def test_refused_instantiation_is_null_with_one_line(either_toy):
    python(
        HOST
        + """
def reason(**wrong):
    assert library.instantiate(**wrong) is None
    (name, level, category, text), = logged
    assert (level, category) == (ERROR, "logStatusError")
    logged.clear()
    return text

assert reason(guid=b"{0}") == (f"fmi2Instantiate: the GUID {{0}} is not that of this FMU, {library.guid.decode()};"
                               " read the model description again")
assert reason(guid=None) == "fmi2Instantiate: the GUID is NULL"
assert reason(kind=0) == "fmi2Instantiate: this FMU is for co-simulation only"
assert reason(name=None) == reason(name=b"") == reason(name=b" ") == "fmi2Instantiate: the instance has no name"
assert library.instantiate(guid=b"{0}", callbacks=False) is None and logged == []
""",
        either_toy,
    )


def test_instantiation_without_resources_is_null_with_one_line(toy):
    python(
        HOST
        + """
(library.folder / "resources").rename(library.folder / "away")
(library.folder / "resources").mkdir()
(library.folder / "resources" / "slavemodule.txt").write_text("nothing")
assert library.instantiate() is None
(name, level, category, text), = logged
assert (level, category) == (ERROR, "logStatusError")
assert text.startswith("no resources at fmuResourceLocation = "), text
""",
        toy,
    )


def test_names_and_texts_that_are_not_utf8_and_missing_callbacks(either_toy):
    python(
        HOST
        + """
one = library.instantiate(b"\\xff\\xc3")
assert one and one.initialise().step(1.0) == ERROR
assert logged[0][0] == b"\\xff\\xc3"  # as the host wrote it
one.free()
logged.clear()
silent = library.instantiate(callbacks=False).initialise()
assert silent.step(0.0) == OK and silent.step(math.nan) == ERROR and logged == []
silent.free()
label = library.reference["label"]
for text, reason in (
    (b"\\xff", "value 1 is not UTF-8: ?"),
    (b"\\xed\\xa0\\x80", "value 1 is not UTF-8: ???"),  # half of a surrogate pair
    (b"\\xc0\\x80", "value 1 is not UTF-8: ??"),  # an overlong zero
    (None, "value 1 is NULL"),
):
    one = library.instantiate()
    assert message(one.set("String", [label], [text])) == f"setString: {reason}"
    one.free()
one = library.instantiate()
assert one.set("String", [label], ["Größe 😀".encode()]) == OK
one.initialise()
assert one.get("String", [label]) == (OK, ["Größe 😀".encode()])
one.free()
""",
        either_toy,
    )


def test_null_is_refused_wherever_it_stands(either_toy):
    python(
        HOST
        + """
nobody, number = RawFmu(library, None), (c_double * 1)()
for name, arguments in (
    ("SetDebugLogging", (0, c_size_t(0), None)), ("EnterInitializationMode", ()), ("Terminate", ()), ("Reset", ()),
    ("GetReal", (None, c_size_t(0), None)), ("SetString", (None, c_size_t(0), None)), ("FreeFMUstate", (None,)),
    ("GetFMUstate", (byref(c_void_p()),)), ("DoStep", (c_double(0), c_double(1), 1)), ("CancelStep", ()),
    ("GetRealStatus", (2, number)), ("GetDirectionalDerivative", (None, c_size_t(0), None, c_size_t(0), None, None)),
):
    assert nobody.call(name, *arguments) == ERROR, name
nobody.free()
assert logged == []

def refused(name, *arguments):
    one = library.instantiate().initialise()
    text = message(one.call(name, *arguments))
    assert one.step(0.0) == ERROR  # it is an error, and not forgotten
    one.free()
    logged.clear()
    return text

one, n = (c_uint * 1)(0), c_size_t(1)
for kind in KINDS:
    for verb in ("get", "set"):
        name = f"{verb.capitalize()}{kind}"
        assert refused(name, None, n, number) == f"{verb}{kind}: 1 value references in a NULL array"
        assert refused(name, one, n, None) == f"{verb}{kind}: 1 values in a NULL array"
assert refused("SetDebugLogging", 1, n, None) == "setDebugLogging: 1 categories in a NULL array"
assert refused("GetFMUstate", None) == "getFMUstate: the state goes to a NULL pointer"
assert refused("SetFMUstate", None) == "setFMUstate: the state is NULL"
assert refused("SerializedFMUstateSize", None, None) == "serializedFMUstateSize: the state is NULL"
text = "deSerializeFMUstate: the bytes come from a NULL array"
assert refused("DeSerializeFMUstate", None, n, byref(c_void_p())) == text
assert refused("GetRealStatus", 2, None) == "getRealStatus: the value goes to a NULL pointer"
""",
        either_toy,
    )


def test_refused_values_are_not_written(either_toy):
    python(
        HOST
        + """
torque = [library.reference[f"wheel.torque[{k}]"] for k in (1, 2, 3)]
for references, values in (
    ([*torque, 0x7ffffff0], [4.0, 5.0, 6.0, 7.0]), ([*torque, 2**31], [4.0, 5.0, 6.0, 7.0]),
    (torque, [4.0, 5.0, math.nan]), ([*torque, library.reference["angle"]], [4.0, 5.0, 6.0, 7.0]),
    ([*torque, library.reference["gain"]], [4.0, 5.0, 6.0, 7.0]),
):
    one = library.instantiate().initialise()
    assert one.set("Real", torque, [1.0, 2.0, 3.0]) == OK
    message(one.set("Real", references, values))
    assert one.get("Real", torque) == (OK, [1.0, 2.0, 3.0]), references
    one.free()
for kind in KINDS:  # what the shim asks of the model is not for hosts
    one = library.instantiate().initialise()
    assert "value reference 2147483632: no such variable; there " in message(one.get(kind, [0x7ffffff0])[0])
    one.free()
""",
        either_toy,
    )


def test_a_variable_of_another_type_is_refused_by_name_whether_set_or_read(either_toy):
    python(
        HOST
        + """
for name, kind in (("wheel.torque[1]", "Real"), ("level[1]", "Real"), ("seed", "Integer"), ("explode", "Boolean"),
                   ("valid", "Boolean"), ("label", "String")):
    reference = library.reference[name]
    for other in KINDS:
        for verb in () if other == kind else ("get", "set"):
            one = library.instantiate().initialise()
            value = b"" if other == "String" else 1
            called = one.get(other, [reference])[0] if verb == "get" else one.set(other, [reference], [value])
            assert message(called) == (f"{verb}{other}: {other.lower()} value reference {reference}: no such variable;"
                                       f" it is that of {name}, which is {kind.lower()}")
            assert one.step(0.0) == ERROR
            one.free()
            logged.clear()
one = library.instantiate().initialise()  # among variables of the right type too, and nothing is written
assert one.set("Real", [library.reference["poison"]], [0.0]) == OK
message(one.set("Real", [library.reference["poison"], library.reference["explode"]], [1.0, 1.0]))
assert one.get("Real", [library.reference["poison"]]) == (OK, [0.0])
assert one.get("Boolean", [library.reference["explode"]]) == (OK, [0])
one.free()
""",
        either_toy,
    )


TIMES = """
h = library.step
level = library.reference["level[1]"]
for time, step, reason in (
    (math.nan, h, "a step begins at the present communication point, 0.01 s"),
    (math.inf, h, "a step begins at the present communication point, 0.01 s"),
    (0.0, h, "a step begins at the present communication point, 0.01 s"),
    (0.02, h, "a step begins at the present communication point, 0.01 s"),
    (h, 0.0, "a step of 0.0 s is not accepted; a step is > 0 s and finite"),
    (h, -h, "a step of -0.01 s is not accepted; a step is > 0 s and finite"),
    (h, math.nan, "a step of nan s is not accepted; a step is > 0 s and finite"),
    (h, math.inf, "a step of inf s is not accepted; a step is > 0 s and finite"),
    (h, 99 * h, "a step to 1.0 s passes the stop time 0.5 s"),
):
    one = library.instantiate()
    assert one.setup(0.0, 0.5) == one.call("EnterInitializationMode") == one.call("ExitInitializationMode") == OK
    assert one.step(0.0) == OK
    _, before = one.get_state()
    _, content = one.serialise(before)
    assert message(one.step(time, step)) == f"doStep at t = {time} s: {reason}"
    assert one.set_state(before) == OK and one.step(h) == OK  # as if nothing had been
    expected = one.get("Real", [level])
    one.free()
    fresh = library.instantiate()
    status, state = fresh.deserialise(content)
    assert status == fresh.set_state(state) == OK and fresh.step(h) == OK
    assert fresh.get("Real", [level]) == expected
    fresh.free()
"""


def test_steps_at_wrong_times_are_refused_without_effect(either_toy):
    python(HOST + TIMES, either_toy)


def test_states_are_of_one_instance_and_are_reused_and_freed(either_toy):
    python(
        HOST
        + """
from lockstep.operating_system import resident_memory
one, other = library.instantiate().initialise(), library.instantiate(b"two").initialise()
status, state = one.get_state()
address = state.value
status, same = one.get_state(state)
assert status == OK and same.value == address
copy = c_void_p(address)
assert one.free_state(state) == OK and state.value is None
assert one.free_state(state) == OK and one.call("FreeFMUstate", None) == OK and logged == []
wrong = "no state of this instance: freed, or of another one"
assert message(one.set_state(copy)) == f"setFMUstate: {wrong}"
one.call("Reset"); one.initialise()
foreign = ctypes.create_string_buffer(64)
for handle in (other.get_state()[1], c_void_p(ctypes.addressof(foreign)), c_void_p(8)):
    for call in (one.set_state, one.free_state, one.get_state, one.serialise):
        status = call(handle)
        text = message(status if isinstance(status, int) else status[0])
        assert text.endswith(f"FMUstate: {wrong}") or text == f"serializedFMUstateSize: {wrong}", text
        one.call("Reset")
one.initialise()
_, state = one.get_state()
_, content = one.serialise(state)
size = len(content)
for wrong in (size - 1, size + 1, 0):
    buffer = (c_char * (size + 1))()
    text = message(one.call("SerializeFMUstate", state, buffer, c_size_t(wrong)))
    assert text == f"serializeFMUstate: the state has {size} bytes, not {wrong}"
    assert bytes(buffer) == bytes(size + 1)
    one.set_state(state)
for k in range(3000):
    one.get_state(state)
    if k == 300:
        before = resident_memory()
grown = resident_memory() - before
assert grown < 1e6, f"{grown} bytes"  # a state has 2 kB; each used to be lost
""",
        either_toy,
    )


def test_a_state_saved_after_an_error_does_not_repair_the_instance(either_toy):
    python(
        HOST
        + """
one = library.instantiate().initialise()
assert one.step(math.nan) == ERROR
status, state = one.get_state()
assert status == OK
status, copy = one.deserialise(one.serialise(state)[1])
for handle in (state, copy):
    one.call("Reset"); one.initialise()
    assert one.set_state(handle) == OK
    logged.clear()
    assert message(one.step(0.0)) == "doStep at t = 0.0 s: refused since: the state was saved after an error"
one.free()
""",
        either_toy,
    )


def test_a_reset_without_resources_is_refused_and_does_not_crash(toy):
    python(
        HOST
        + """
one = library.instantiate().initialise()
resources = library.folder / "resources"
(resources / "build.json").rename(library.folder / "build.json")
(resources / "build.json").write_text("[")
assert one.call("Reset") == ERROR and logged[0][3].startswith("instantiate: "), logged
logged.clear()
text = "there is no model since fmi2Reset failed; free the instance"
assert message(one.step(0.0)) == message(one.get("Real", [0])[0]) == text
assert message(one.call("GetFMUstate", byref(c_void_p()))) == text
(library.folder / "build.json").rename(resources / "build.json")
assert one.call("Reset") == OK and one.initialise().step(0.0) == OK
one.free()
""",
        toy,
    )
