"""A built toy in fresh processes: isolation, errors that do not crash, reset, state."""

import json

import pytest

from fmus.toys.builds import build, copy_toys, python

OPEN = "from session import *; from session import argument; import json; from pathlib import Path\n"


@pytest.fixture(scope="module")
def other_toy(tmp_path_factory):
    """The same toy from sources that differ in one line, with the same model name."""
    folder = tmp_path_factory.mktemp("other")
    build(folder / "other.fmu", copy_toys(folder / "packages", ("GAIN = 2.0", "GAIN = 4.0")))
    return folder / "other.fmu"


def test_simulate_fmu_runs_it(toy):
    python(
        """
import fmpy, numpy
torque = numpy.array([(0.0, 1.0), (1.0, 1.0)], dtype=[("time", float), ("wheel.torque[1]", float)])
result = fmpy.simulate_fmu(sys.argv[1], stop_time=0.5, output_interval=0.01, input=torque, output=["angle", "energy"])
assert len(result) == 51, result
assert abs(result["angle"][-1] - 0.5) < 1e-12
""",
        toy,
    )


def test_two_builds_in_one_process_do_not_mix(toy, other_toy):
    python(
        OPEN
        + """
alone = []
for path in (argument(0), argument(1)):
    with Session(path) as one:
        alone.append(one.initialize().run(0, 20))
assert alone[0] != alone[1]
with Session(argument(1), "b") as b, Session(argument(0), "a") as a:
    a.initialize(); b.initialize()
    assert [a.run(0, 20), b.run(0, 20)] == alone
""",
        toy,
        other_toy,
    )


def test_fifty_loads_in_turn_leave_no_trace(toy, other_toy):
    python(
        OPEN
        + """
runs = {}
for k in range(50):
    path = argument(k % 2)
    with Session(path) as one:
        run = one.initialize().run(0, 3)
        assert runs.setdefault(path, run) == run, k
    if k == 1:
        before = list(sys.path), set(sys.modules), len(sys.path_importer_cache)
    if k < 2:
        continue
    assert (list(sys.path), set(sys.modules), len(sys.path_importer_cache)) == before, k
""",
        toy,
        other_toy,
    )


def test_two_instances_at_once_and_reset_give_the_same_run(toy):
    python(
        OPEN
        + """
with Session(argument(0), "a") as a, Session(argument(0), "b") as b:
    a.initialize(); b.initialize(gain=3.0)
    first = a.run(0, 10); second = b.run(0, 10)
    assert first != second
    b.fmu.reset(); b.initialize()
    assert b.get("gain") == 1.0
    assert b.run(0, 10) == first
""",
        toy,
    )


def test_exception_of_the_model_is_a_logged_error(toy):
    python(
        OPEN
        + """
for formatted in (True, False):
    with Session(argument(0), formatted=formatted) as one:
        one.initialize(); one.run(0, 3)
        one.set("explode", True)
        for _ in range(3):
            try:
                one.fmu.doStep(0.03, 0.01)
            except FMICallException as error:
                assert error.status == 3, error.status  # fmi2Error, and never fmi2Fatal
            else:
                raise AssertionError("the step was accepted")
        assert one.get("level") != one.get("level")  # not a number
        percent = "100%" if formatted else "100%%"
        status, category, text = one.messages[0]
        assert (status, category) == (3, b"logStatusError"), one.messages
        assert f"RuntimeError: asked to at {percent} of 0.03 s" in text and "Traceback" in text and "in advance" in text
        assert "refused since: doStep at t = 0.03 s: RuntimeError" in one.messages[1][2]
        one.fmu.reset(); one.initialize(); one.run(0, 3)
""",
        toy,
    )


REFUSED = [
    ("one.set('wheel.torque', 1.0, float('nan'), 0.0)", "wheel.torque[2] must be finite, got nan"),
    ("one.set('gain', 2.0)", "gain is a fixed parameter and cannot be set after initialisation, got 2.0"),
    ("one.set('level', 2.0)", "level[1] is an output and cannot be set"),
    ("one.fmu.setReal([77], [1.0])", "real value reference 77: no such variable"),
    ("one.fmu.getReal([77])", "real value reference 77: no such variable"),
    ("one.fmu.setInteger([3, 9], [1, 2])", "integer value reference 3: no such variable"),
    ("one.set('poison', 1.0)", "output angle = nan is not finite"),
]


def test_refused_calls_are_named_and_stop_the_run(toy):
    python(
        OPEN
        + """
for action, message in json.loads(argument(1)):
    with Session(argument(0)) as one:
        one.initialize(); one.run(0, 3)
        for call in (action, "one.fmu.doStep(0.03, 0.01)"):
            try:
                exec(call)
            except FMICallException as error:
                assert error.status == 3, call
            else:
                assert action == "one.set('poison', 1.0)" == call, f"{action}: {call} was accepted"
        assert message in one.messages[0][2], (action, one.messages)
        assert "Traceback" not in one.messages[0][2], (action, one.messages)
""",
        toy,
        json.dumps(REFUSED),
    )


def test_refused_parameters_are_told_in_one_line(toy):
    python(
        OPEN
        + """
for parameters, message in (
    (dict(label="refuse"), "exitInitializationMode: label must not be 'refuse'"),
    (dict(gain=-1.0), "setReal: gain must be >= 0.0, got -1.0"),
):
    with Session(argument(0)) as one:
        for call in (lambda: one.initialize(**parameters), lambda: one.fmu.doStep(0.0, 0.01)):
            try:
                call()
            except FMICallException as error:
                assert error.status == 3
            else:
                raise AssertionError("the call was accepted")
        assert one.messages[0] == (3, b"logStatusError", message), one.messages
        assert one.get("level") != one.get("level")
""",
        toy,
    )


def test_outputs_on_demand_are_right_and_computed_once_when_read(toy):
    python(
        OPEN
        + """
with Session(argument(0)) as one:
    one.initialize()
    for k in range(5):
        one.fmu.doStep(0.01 * k, 0.01)
    one.get("level", 3)
    assert one.get("evaluations") == 0
    assert abs(one.get("energy") - sum(x * x for x in one.get("level", 3))) < 1e-12  # rounding of three squares
    one.get("energy")
    assert one.get("evaluations") == 1
""",
        toy,
    )


def test_a_path_with_spaces_and_umlauts(toy, tmp_path):
    archive = tmp_path / "Größe und Maß.fmu"
    archive.write_bytes(toy.read_bytes())
    python(
        OPEN
        + """
with Session(argument(0), folder=argument(1)) as one:
    one.initialize().run(0, 3)
with Session(argument(0), folder=argument(2), raw_location=True) as one:
    one.initialize().run(0, 3)
""",
        archive,
        tmp_path / "with two spaces",
        tmp_path / "für Ümlaute",
    )


SAVE = (
    OPEN
    + """
import ctypes
with Session(argument(0)) as one:
    one.initialize(gain=2.0, seed=11)
    one.run(0, 25)
    state = one.fmu.getFMUState()
    bytes_ = bytes(one.fmu.serializeFMUState(state))
    rest = one.run(25, 50)
    one.fmu.setFMUState(state)
    assert one.run(25, 50) == rest, "rolled back in the same instance"
    one.fmu.freeFMUState(state)
    Path(argument(1)).write_bytes(bytes_)
    print(json.dumps(rest))
"""
)
RESUME = (
    OPEN
    + """
with Session(argument(0)) as one:
    state = one.fmu.deSerializeFMUstate(Path(argument(1)).read_bytes())
    one.fmu.setFMUState(state)
    assert not one.messages, one.messages
    assert one.get("gain") == 2.0
    print(json.dumps(one.run(25, 50)))
    one.fmu.freeFMUState(state)
"""
)


@pytest.fixture(scope="module")
def saved(toy, tmp_path_factory):
    """Return the file of a state that was saved in the middle of a run, and the rest of the run."""
    path = tmp_path_factory.mktemp("saved") / "state"
    return path, json.loads(python(SAVE, toy, path))


def test_saved_state_continues_bitwise_in_another_process(toy, saved):
    path, rest = saved

    assert json.loads(python(RESUME, toy, path)) == rest


def test_that_test_notices_a_generator_left_out_of_the_state(tmp_path):
    start = "        self.state = State("
    packages = copy_toys(
        tmp_path / "packages",
        ("state.generator.normal()", "self.hidden.normal()"),
        (start, f"        self.hidden = np.random.default_rng(1)\n{start}"),
    )
    build(tmp_path / "leaky.fmu", packages)

    failed = python(SAVE, tmp_path / "leaky.fmu", tmp_path / "state", check=False)

    assert failed.returncode == 1
    assert "rolled back in the same instance" in failed.stderr


def test_damaged_state_is_refused(toy, saved):
    python(
        OPEN
        + """
data = Path(argument(1)).read_bytes()
replaced = data.replace(b'state.level', b'state.lever')
assert replaced != data
for damaged in (data[:-9], b"nonsense", b"", replaced):
    with Session(argument(0)) as one:
        one.initialize(); one.run(0, 3)
        try:
            one.fmu.deSerializeFMUstate(damaged)
        except FMICallException as error:
            assert error.status == 3
        else:
            raise AssertionError("accepted")
        assert one.messages and one.messages[0][0] == 3, damaged[:20]
""",
        toy,
        saved[0],
    )


def test_state_of_another_build_is_refused(other_toy, saved):
    python(
        OPEN
        + """
with Session(argument(0)) as one:
    try:
        one.fmu.deSerializeFMUstate(Path(argument(1)).read_bytes())
    except FMICallException as error:
        assert error.status == 3
    else:
        raise AssertionError("accepted")
    assert "the saved state belongs to" in one.messages[0][2], one.messages
""",
        other_toy,
        saved[0],
    )
