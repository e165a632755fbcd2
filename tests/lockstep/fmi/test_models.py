"""The reference FMUs of FMI 1.0, 2.0 and 3.0 through the master: against closed forms and against simulate_fmu."""

import json

import numpy as np
import pytest
from fmpy.simulation import simulate_fmu
from numpy.testing import assert_allclose, assert_array_equal

from lockstep import Component, Connection, RunError, System, read_signals, simulate
from lockstep.results.read_run_record import read_run_record

STEP = 7_812_500  # [ns]: 2^-7 s, which FMPy adds up without rounding
TICKS = 256
STOP = TICKS * STEP
VERSIONS = ("1.0", "2.0", "3.0")
U, X0, RATE = 2.0, 3.0, 0.5
NUMBERS = {"Float64_in": -1.5e300, "Int32_in": -(2**31), "Boolean_in": True, "Enumeration_in": 7}
OLDER = {"Float64": "Real", "Int32": "Integer"}


def started(version):
    """Return the start values of the feedthrough by this version's names of its types."""
    texts = {"String_in": "drehen um 90°"}
    given = NUMBERS if version == "3.0" else {OLDER.get(k[:-3], k[:-3]) + "_in": v for k, v in NUMBERS.items()}
    return given | texts | ({"Enumeration_in": 2} if version == "1.0" else {})  # whose items count from 1


def _zero(name, position):
    return "" if name == "words" else position > 0 if name == "flags" else 0


WAYS = [("1.0", False), ("2.0", False), ("2.0", True), ("3.0", False), ("3.0", True)]


@pytest.fixture(scope="module", params=WAYS, ids=lambda way: f"{way[0]}-{'isolated' if way[1] else 'inside'}")
def run(request, reference_fmu, tmp_path_factory):
    """Return version and signals of all models side by side, unpacked where a path has a blank and an umlaut."""
    version, isolated = request.param
    folder = tmp_path_factory.mktemp("runs")
    values = {"integrator": {"u": U, "x0": X0}, "feedthrough": started(version), "ball": {}, "resource": {}}
    if version == "1.0":
        values.pop("resource")
    if version == "3.0":
        described = {"vector": (3,), "matrix": (2, 3), "narrow": (2,), "whole": (2,), "flags": (2,), "words": (2,)}
        for name, shape in described.items():
            for index in np.ndindex(shape):
                label = f"{name}_in[{','.join(str(k + 1) for k in index)}]"
                values["feedthrough"][label] = _zero(name, sum(index))
        for kind in ("Float32", "Int8", "Int16", "Int64", "UInt8", "UInt16", "UInt32", "UInt64"):
            values["feedthrough"][f"{kind}_in"] = 0
    parts = tuple(
        Component(
            name=model,
            source=reference_fmu(model, version),
            period=STEP,
            kind="sampled" if model in ("feedthrough", "resource") else "continuous",
            parameters=given,
            isolated=isolated,
        )
        for model, given in values.items()
    )
    with pytest.MonkeyPatch.context() as patch:
        (folder / "ein Ördner").mkdir()
        patch.setenv("TMPDIR", str(folder / "ein Ördner"))
        patch.setattr("tempfile.tempdir", None)
        simulate(System(name="models", tick=STEP, stop_time=STOP, components=parts), folder / "out")
    assert list((folder / "ein Ördner").iterdir()) == []
    events = [json.loads(line) for line in (folder / "out" / "events.jsonl").read_text().splitlines()]
    assert sum(event.get("message") == "terminated" for event in events) == (2 if version == "1.0" else 4) + (
        version == "1.0"
    )
    return version, read_signals(folder / "out")


def simulated_by_fmpy(reference_fmu, model, version, **start):
    """Return the results of FMPy's own master."""
    return simulate_fmu(
        str(reference_fmu(model, version)),
        fmi_type="CoSimulation",
        stop_time=STOP / 1e9,
        step_size=STEP / 1e9,
        output_interval=STEP / 1e9,
        start_values=start,
        logger=lambda *_: None,
    )


def test_integrator_agrees_with_its_closed_form(run, reference_fmu):
    version, signals = run
    level = U / RATE
    few = TICKS * 2.0**-52 * level  # one rounding a step, and what it adds decays

    assert_allclose(signals["integrator.x"], level + (X0 - level) * np.exp(-RATE * signals.time), atol=few)
    assert_array_equal(
        signals["integrator.x"], simulated_by_fmpy(reference_fmu, "integrator", version, u=U, x0=X0)["x"]
    )


def test_ball_agrees_with_its_closed_form(run, reference_fmu):
    version, signals = run
    h0, g, e, time = 1.0, 9.81, 0.7, signals.time
    speed = np.sqrt(2.0 * g * h0) * e ** np.arange(10)  # before each bounce
    bounces = np.cumsum(np.concatenate([[speed[0] / g], 2.0 * speed[1:] / g]))
    passed = np.searchsorted(bounces, time)

    assert_array_equal(signals["ball.bounces"], passed)
    assert passed[-1] == 4
    since = time - bounces[passed - 1]
    height = since * (speed[passed] - 0.5 * g * since)
    first = passed == 0
    height[first] = h0 - 0.5 * g * time[first] ** 2
    # the ball restarts from the rounded end of each step: 256 of them, times of a second, speeds of 5 m/s
    assert_allclose(signals["ball.h"], height, atol=1e-12)
    assert_allclose(signals["ball.last_bounce"][~first], bounces[passed - 1][~first], atol=1e-12)
    assert_array_equal(signals["ball.h"], simulated_by_fmpy(reference_fmu, "ball", version)["h"])


def test_feedthrough_copies_every_type(run, reference_fmu):
    version, signals = run
    given = started(version)
    for name, value in given.items():
        column = signals[f"feedthrough.{name.removesuffix('_in')}_out"]
        assert column.tolist() == [value] * (TICKS + 1), name
    numbers = {name: value for name, value in given.items() if isinstance(value, int | float)}
    result = simulated_by_fmpy(reference_fmu, "feedthrough", version, **numbers)
    for name, value in numbers.items():
        if name.removesuffix("_in") + "_out" in result.dtype.names:
            assert result[name.removesuffix("_in") + "_out"][-1] == value


def test_resources_are_found(run, reference, reference_fmu):
    version, signals = run
    if version == "1.0":
        assert not [
            name for name in signals.columns if name.startswith("resource")
        ]  # FMI 1.0 does not pass their location
        return
    assert signals["resource.count"][-1] == len(reference.NUMBERS)
    assert_array_equal(signals["resource.number"], np.resize(reference.NUMBERS, TICKS + 1))
    assert_array_equal(
        simulated_by_fmpy(reference_fmu, "resource", version)["number"][1:], signals["resource.number"][:-1]
    )


MESSAGES = {
    ("1.0", 0): "stair: fmiDoStep returned fmiDiscard at 0.078125 s",
    ("3.0", 1): "stair: fmi3DoStep returned early, having reached 0.03515625 s, which is not allowed, at 0.03125 s",
    ("3.0", 2): "stair: fmi3DoStep asked for event mode, which is not used, at 0.03125 s",
    ("3.0", 4): "stair: fmi3DoStep returned fmi3Error at 0.03125 s: the stair has a broken step",
    ("3.0", 5): "stair: fmi3DoStep returned fmi3Fatal at 0.03125 s: the stair fell down",
    ("3.0", 6): "stair: crashed with SIGSEGV in fmi3DoStep at 0.03125 s",
    ("2.0", 5): "stair: fmi2DoStep returned fmi2Fatal at 0.03125 s: the stair fell down",
    # statuses that no version knows, or not this one; below 0 too
    ("1.0", 109): "stair: fmiDoStep returned the unknown status -1 at 0.03125 s",
    ("1.0", 115): "stair: fmiDoStep returned fmiPending at 0.03125 s",
    ("2.0", 109): "stair: fmi2DoStep returned the unknown status -1 at 0.03125 s",
    ("2.0", 115): "stair: fmi2DoStep returned fmi2Pending at 0.03125 s",
    ("2.0", 117): "stair: fmi2DoStep returned the unknown status 7 at 0.03125 s",
    ("3.0", 109): "stair: fmi3DoStep returned the unknown status -1 at 0.03125 s",
    ("3.0", 115): "stair: fmi3DoStep returned the unknown status 5 at 0.03125 s",
}


BROKEN = [(*key, False) for key in MESSAGES if key[1] != 6]  # which would end this process
BROKEN += [("1.0", 0, True), *(("3.0", mode, True) for mode in (1, 5, 6)), ("2.0", 109, True)]


@pytest.mark.parametrize(("version", "mode", "isolated"), BROKEN)
def test_end_or_failure_is_one_line_and_earlier_steps_are_kept(reference_fmu, tmp_path, version, mode, isolated):
    stair = Component(
        name="stair",
        source=reference_fmu("stair", version),
        period=STEP,
        kind="sampled",
        parameters={"mode": mode, "at": 5 if mode else -1},
        isolated=isolated,
    )
    with pytest.raises(RunError) as caught:
        simulate(System(name="s", tick=STEP, stop_time=STOP, components=(stair,)), tmp_path / "out")

    assert str(caught.value) == MESSAGES[version, mode]
    signals = read_signals(tmp_path / "out")
    assert signals["stair.counter"].tolist() == list(range(1, 5 if mode else 11))
    log = (tmp_path / "out" / "events.jsonl").read_text()
    assert ('"terminated"' in log) == (mode < 4)  # neither after an error nor after fatal; nor after a crash


@pytest.mark.parametrize("isolated", [False, True])
def test_what_is_not_finite_and_not_used_is_recorded_and_reported(reference_fmu, tmp_path, isolated):
    stair = Component(
        name="stair",
        source=reference_fmu("stair", "3.0"),
        period=STEP,
        kind="sampled",
        parameters={"mode": 3, "at": 5},
        isolated=isolated,
    )
    summary = simulate(System(name="s", tick=STEP, stop_time=STOP, components=(stair,)), tmp_path / "out")

    assert summary.warnings == (
        "recorded though not finite, as no connection uses it: stair.height (nan at 0.03125 s)",
    )
    finite = np.isfinite(read_signals(tmp_path / "out")["stair.height"])
    assert not finite[4]
    assert finite[:4].all()


ENDED = {
    # version, mode: where the step that asks for the end begins, what it reaches, and how many rows there are
    ("2.0", 0): ("fmi2DoStep returned fmi2Discard and", 0.078125, 0.078125, 11),
    ("3.0", 0): ("fmi3DoStep", 0.078125, 0.078125, 11),
    ("2.0", 7): ("fmi2DoStep returned fmi2Discard and", 0.03125, 0.0390625, 6),
    ("3.0", 7): ("fmi3DoStep", 0.03125, 0.0390625, 6),
}


@pytest.mark.parametrize("isolated", [False, True], ids=["inside", "isolated"])
@pytest.mark.parametrize(("version", "mode"), ENDED)
def test_a_regular_end_completes_the_run_with_its_last_row(reference_fmu, tmp_path, version, mode, isolated):
    """The end comes instead of the 11th step, or after the 5th; a continuous reader sees all values before it."""
    stair = Component(
        name="stair", source=reference_fmu("stair", version), period=STEP, kind="sampled", isolated=isolated,
        parameters={"mode": mode, "at": 5 if mode else -1},
    )  # fmt: skip
    reader = Component(
        name="reader", source=reference_fmu("integrator", version), period=STEP, kind="continuous", isolated=isolated,
        parameters={"rate": 1e-300, "x0": 0.0},
    )  # fmt: skip
    wire = Connection(from_component="stair", output="height", to_component="reader", input="u")
    system = System(name="s", tick=STEP, stop_time=STOP, components=(stair, reader), connections=(wire,))
    summary = simulate(system, tmp_path / "out")

    call, begins, reached, rows = ENDED[version, mode]
    asked = f"stair: {call} asked for the end of the simulation, having reached {reached!r} s"
    assert summary.terminated == f"{asked}, in the step from {begins:.9g} s"
    assert (summary.rows, summary.simulated_time) == (rows, reached)
    record, _ = read_run_record(tmp_path / "out")
    assert (record["status"], record["reason"]) == ("terminated", summary.terminated)
    assert record["simulated_time"] == reached
    signals = read_signals(tmp_path / "out")
    steps = [*range(1, 11), 10] if mode == 0 else [1, 2, 3, 4, 5, 5]  # no step begins at the end
    assert signals["stair.counter"].tolist() == steps
    assert signals.time.tolist() == [k * STEP / 1e9 for k in range(rows)]
    last = json.loads((tmp_path / "out" / "events.jsonl").read_text().splitlines()[-1])
    assert (last["event"], last["status"], last["time"]) == ("end", "terminated", reached)
    integral = [0.5 * STEP / 1e9 * sum(range(1, k + 1)) for k in range(rows)]
    assert signals["reader.x"].tolist() == pytest.approx(integral, rel=1e-12)


def test_the_last_row_has_values_that_no_row_before_it_needed(reference_fmu, tmp_path):
    """Of a sampled component recorded every fifth step, only the step at a row is read; the end comes before it."""
    stair = Component(name="stair", source=reference_fmu("stair", "2.0"), period=STEP, kind="sampled", isolated=False,
                      parameters={"mode": 7, "at": 5})  # fmt: skip
    simulate(System(name="s", tick=STEP, stop_time=STOP, components=(stair,), record_period=5 * STEP), tmp_path / "out")
    signals = read_signals(tmp_path / "out")
    assert (signals.time.tolist(), signals["stair.counter"].tolist()) == ([0.0, 5 * STEP / 1e9], [1, 5])
