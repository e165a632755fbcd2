"""The native FMU of the toy, called in every phase: what the standard allows, and what each refusal leaves."""

import json
import math
import subprocess
import sys
from ctypes import byref, c_char_p, c_double, c_int, c_size_t, c_uint

import numpy as np
import pytest

from fmus.raw_fmu import DISCARD, ERROR, OK, WARNING, Library
from fmus.toys.builds import TOYS

PHASES = ("instantiated", "initialization", "complete", "terminated", "error")
# FMI 2.0.4, section 4.2.4
ALLOWED = {
    "setup": {"instantiated"},
    "enter": {"instantiated"},
    "leave": {"initialization"},
    "step": {"complete"},
    "terminate": {"complete"},
    "get": {"initialization", "complete", "terminated", "error"},
    "set": {"instantiated", "initialization", "complete"},
    "inquire": {"complete", "terminated"},
    "save": set(PHASES),
    "log": set(PHASES),
    "reset": set(PHASES),
    "cancel": set(),
}


@pytest.fixture(scope="module")
def library(native_toy, tmp_path_factory):
    return Library(native_toy, tmp_path_factory.mktemp("unpacked"))


def in_phase(one, phase):
    assert one.setup(0.0, 0.5) == OK
    calls = {
        "initialization": [lambda: one.call("EnterInitializationMode")],
        "complete": [lambda: one.call("ExitInitializationMode"), lambda: one.step(0.0)],
        "terminated": [lambda: one.call("Terminate")],
    }
    for name in PHASES[1 : PHASES.index(phase) + 1]:
        for call in calls.get(name, ()) if not (phase == "error" and name == "terminated") else ():
            assert call() == OK
    if phase == "error":
        assert one.step(0.01, -1.0) == ERROR
        one.library.logged.clear()
    return one


def make_call(one, name):
    reference = one.library.reference
    return {
        "setup": lambda: one.setup(),
        "enter": lambda: one.call("EnterInitializationMode"),
        "leave": lambda: one.call("ExitInitializationMode"),
        "step": lambda: one.step(0.01),
        "terminate": lambda: one.call("Terminate"),
        "get": lambda: one.get("Real", [reference["level[1]"]])[0],
        "set": lambda: one.set("Real", [reference["wheel.torque[1]"]], [1.0]),
        "inquire": lambda: one.call("GetRealStatus", c_int(2), byref(c_double())),
        "save": lambda: one.get_state()[0],
        "log": lambda: one.call("SetDebugLogging", c_int(1), c_size_t(0), None),
        "reset": lambda: one.call("Reset"),
        "cancel": lambda: one.call("CancelStep"),
    }[name]()


@pytest.mark.parametrize("phase", PHASES)
@pytest.mark.parametrize("name", ALLOWED)
def test_each_call_in_each_phase(one, name, phase):
    in_phase(one, phase)
    levels = [one.library.reference[f"level[{k}]"] for k in (1, 2, 3)]
    status, before = one.get_state()

    if phase in ALLOWED[name]:
        assert make_call(one, name) == OK
        assert one.library.logged == []
        return
    assert make_call(one, name) == ERROR
    ((_, level, category, text),) = one.library.logged
    assert (level, category) == (ERROR, "logStatusError")
    assert text.partition(": ")[2].startswith(("not allowed ", "refused since: doStep at t = 0.01 s: a step of -1.0 s",
                                               "no step is in progress"))  # fmt: skip
    status, values = one.get("Real", levels)
    assert status == OK
    assert all(map(math.isnan, values))  # from now on no result can be mistaken for one
    assert one.step(0.01) == ERROR  # the error lasts
    assert one.set_state(before) == OK
    if phase == "complete":  # as if nothing had been called
        assert one.step(0.01) == OK
        assert one.get("Real", levels)[0] == OK


def test_initialisation_needs_an_experiment(one):
    assert one.call("EnterInitializationMode") == ERROR
    assert one.library.logged[0][3] == "enterInitializationMode: not allowed before fmi2SetupExperiment"


@pytest.mark.parametrize(
    ("arguments", "reason"),
    [
        ((math.nan,), "the start time must be finite, got nan s"),
        ((1.0, 0.5), "the stop time must be finite and not before the start time 1.0 s, got 0.5 s"),
        ((0.0, math.inf), "the stop time must be finite and not before the start time 0.0 s, got inf s"),
        ((0.0, None, -1e-5), "the tolerance must be finite and >= 0, got -1e-05"),
    ],
)
def test_wrong_experiments_are_refused(one, arguments, reason):
    assert one.setup(*arguments) == ERROR
    assert [text for *_, text in one.library.logged] == [f"setupExperiment: {reason}"]


def test_numbers_in_messages_are_those_of_python(one):
    random = np.random.default_rng(1)
    numbers = [*-(random.random(150) * 10.0 ** random.integers(-320, 300, 150))]
    numbers += [-1e16, -1e-5, -0.1, -123456789012345680.0, -5e-324, -1.7976931348623157e308, -1e22, -9999999999999998.0]
    gain = one.library.reference["gain"]
    for number in numbers:
        one.call("Reset")
        one.library.logged.clear()
        assert one.set("Real", [gain], [number]) == ERROR
        assert one.library.logged[0][3] == f"setReal: gain must be >= 0.0, got {float(number)!r}"


def test_an_error_of_the_model_lasts_until_reset(one):
    reference = one.library.reference
    assert one.set("String", [reference["label"]], [b"refuse"]) == OK
    assert (one.setup(), one.call("EnterInitializationMode"), one.call("ExitInitializationMode")) == (OK, OK, ERROR)
    assert one.step(0.0) == ERROR
    reason = "exitInitializationMode: label must not be 'refuse'"
    assert [text for *_, text in one.library.logged] == [reason, f"doStep at t = 0.0 s: refused since: {reason}"]
    one.call("Reset")
    one.initialise()  # the label is the start value again
    assert one.step(0.0) == OK
    assert one.get("String", [reference["greeting"], reference["label"]]) == (OK, [b"toy 1", b"toy"])
    assert one.set("Boolean", [reference["explode"]], [5]) == OK
    assert one.get("Boolean", [reference["explode"]]) == (OK, [1])
    one.library.logged.clear()
    assert one.step(0.01) == ERROR
    assert one.library.logged[0][3] == "doStep at t = 0.01 s: asked to at 100% of 0.01 s"
    assert one.call("Reset") == OK
    assert one.initialise().step(0.0) == OK


def test_outputs_are_checked_and_those_on_demand_computed_when_read(one):
    reference = one.library.reference
    in_phase(one, "initialization")
    assert one.set("Real", [reference["gain"]], [3.0]) == OK
    assert one.get("Real", [reference["level[2]"]]) == (OK, [3.0])  # starts the model
    assert one.set("Real", [reference["gain"]], [2.0]) == OK
    assert one.get("Real", [reference["energy"]]) == (OK, [12.0])  # and again
    assert one.call("ExitInitializationMode") == OK
    for k in range(3):
        assert one.step(k * 0.01) == OK
    assert one.get("Integer", [reference["evaluations"]]) == (OK, [1])
    names = ("energy", "level[1]", "level[2]", "level[3]")
    _, (energy, *levels) = one.get("Real", [reference[name] for name in names])
    assert energy == pytest.approx(sum(x * x for x in levels), rel=1e-15)  # rounding of one sum
    assert one.get("Real", [reference["energy"]])[0] == OK
    assert one.get("Integer", [reference["evaluations"]]) == (OK, [2])
    assert one.set("Real", [reference["poison"]], [1.0]) == OK
    assert one.step(0.03) == ERROR
    assert one.library.logged[-1][3] == "doStep at t = 0.03 s: output angle = nan is not finite"


def test_lists_of_references_in_any_order_are_read_and_written_as_one_by_one(one):
    one.initialise()
    library, random = one.library, np.random.default_rng(1)
    inputs, known = library.references("Real", "input"), library.references("Real")
    assert len(inputs) > 3
    for length in range(1, 2 * len(known)):
        begin = int(random.integers(len(known)))
        chosen = {
            "a run": known[begin : begin + length],
            "backwards": known[::-1][:length],
            "with gaps and twice": random.choice(known, length).tolist(),
            "two runs": known[begin:] + known[:begin],
        }
        for name, references in chosen.items():
            status, values = one.get("Real", references)
            assert status == OK
            assert values == [one.get("Real", [reference])[1][0] for reference in references], name
        order = random.permutation(inputs).tolist() if length % 2 else inputs[begin % len(inputs) :]
        values = random.standard_normal(len(order)).tolist()
        assert one.set("Real", order, values) == OK
        assert one.get("Real", order)[1] == values
    assert library.logged == []


@pytest.mark.parametrize("wrong", [0, 3])
def test_the_first_wrong_value_of_a_run_is_named_and_none_is_written(one, wrong):
    one.initialise()
    inputs = one.library.references("Real", "input")
    before = one.get("Real", inputs)[1]
    values = [2.0 + value for value in before]
    values[wrong] = math.nan
    names = {reference: name for name, reference in one.library.reference.items()}
    assert one.set("Real", inputs, values) == ERROR
    assert one.library.logged[-1][3] == f"setReal: {names[inputs[wrong]]} must be finite, got nan"
    assert one.get("Real", inputs)[1] == before


def test_a_run_that_leaves_the_reals_is_refused_with_its_first_wrong_reference(one):
    one.initialise()
    reals = one.library.references("Real")
    assert one.get("Real", [*reals[-2:], max(reals) + 1])[0] == ERROR
    assert one.library.logged[-1][3].startswith(f"getReal: real value reference {max(reals) + 1}: no such variable")


def test_inquiries_and_unknown_log_categories(one):
    in_phase(one, "complete")
    value = c_double()
    assert one.call("GetRealStatus", c_int(2), byref(value)) == OK
    assert value.value == 0.01
    assert one.call("GetRealStatus", c_int(1), byref(value)) == DISCARD
    assert one.call("GetStatus", c_int(0), byref(c_int())) == DISCARD
    assert one.call("SetDebugLogging", c_int(1), c_size_t(1), (c_char_p * 1)()) == ERROR
    assert one.library.logged[-1][3] == "setDebugLogging: category 1 is NULL"
    one.call("Reset")
    assert one.call("SetDebugLogging", c_int(1), c_size_t(1), (c_char_p * 1)(b"logEvents")) == WARNING
    assert one.library.logged[-1][3] == "setDebugLogging: no category logEvents; there is logStatusError"
    assert one.call("GetDirectionalDerivative", (c_uint * 1)(0), c_size_t(1), None, c_size_t(0), None, None) == ERROR


def test_long_texts_are_refused_and_others_kept_whole(one):
    label = one.library.reference["label"]
    longest = "ß".encode() * 127
    assert one.set("String", [label], [longest]) == OK
    assert one.initialise().get("String", [label]) == (OK, [longest])
    one.call("Reset")
    assert one.set("String", [label], [longest + b"xx"]) == ERROR
    assert one.library.logged[-1][3] == "setString: label must have less than 256 bytes, got 256"


def test_a_message_is_one_line_whatever_it_quotes(one):
    assert one.call("SetDebugLogging", c_int(1), c_size_t(1), (c_char_p * 1)(b"two\nlines\x7f")) == WARNING
    assert one.library.instantiate(guid=b"{\r\n\t}") is None
    texts = [text for *_, text in one.library.logged]
    assert texts[0] == "setDebugLogging: no category two?lines?; there is logStatusError"
    assert texts[1].startswith("fmi2Instantiate: the GUID {???} is not that of this FMU, {")


def test_sequences_of_calls_are_answered_as_the_standard_says(native_toy):
    """In a process of its own, so that a crash is a failure; by hand: 100,000 sequences."""
    done = subprocess.run(
        [sys.executable, TOYS.parent / "call_sequences.py", native_toy, "--sequences", "1000"],
        capture_output=True, text=True, check=False, timeout=300,
    )  # fmt: skip

    assert done.returncode == 0, f"{done.stdout}\n{done.stderr}"
    result = json.loads(done.stdout)
    assert result["calls"] > 10_000
    assert sum(result["refused"].values()) > 5_000
