"""FMUs that share one process: the same rows as in the master's, the right culprit, and which ones share it."""

import json
import time
import tomllib
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from fmus.bad.bad_fmus import XML, bad_fmu
from fmus.reference.build import build
from lockstep import Component, Connection, RunError, System, load_system, read_signals, simulate, write_ssd
from lockstep.checkpoint.schedule import CheckpointSchedule
from lockstep.faults.read import read_scenario
from lockstep.fmi.model_description import read_description
from lockstep.processes import connection as connection_module
from lockstep.processes.isolation_policy import FEW, settle
from lockstep.processes.last_call import CALL
from lockstep.processes.remote_slave import RemoteSlave
from lockstep.run import batched_steps
from lockstep.simulation import resume

STEP = 10_000_000  # [ns]
NAMES = [f"c{k}" for k in range(FEW + 2)]
RECORD = ("*",)
VALUES = {"rate": 1.0}
FAULTS = """
[[fault]]
name = "drift"
connection = "c2.level"
kind = "bias"
from = 0.05
to = 0.12
value = 0.25
"""


@pytest.fixture(scope="module")
def fmus(tmp_path_factory):
    """Return a function that builds an FMU with a defect, each once."""
    made = {}

    def make(*defects):
        if defects not in made:
            made[defects] = bad_fmu(tmp_path_factory.mktemp("fmu"), *defects)
        return made[defects]

    return make


def chain(fmu, *, delays=(1,), others=None, **options):
    """Return a chain of components, each with the level that the one before it gives; `others` have other FMUs."""
    parts = tuple(
        Component(
            name=name, source=(others or {}).get(name, fmu), period=STEP, kind="sampled", parameters=VALUES, **options
        )
        for name in NAMES
    )
    links = tuple(
        Connection(from_component=a, output="scaled", to_component=b, input="level", delay=delays[k % len(delays)])
        for k, (a, b) in enumerate(pairwise(NAMES))
    )
    return System(name="chain", tick=STEP, stop_time=30 * STEP, components=parts, connections=links, record=RECORD)


def changed(system, name, **fields):
    """Return the system with fields of a component changed."""
    return replace(system, components=tuple(replace(c, **fields) if c.name == name else c for c in system.components))


def inside(system):
    """Return the system with all components in the master's process."""
    return replace(system, components=tuple(replace(c, isolated=False) for c in system.components))


def assert_same_rows(one, two):
    """Compare two results bit by bit."""
    first, second = read_signals(one), read_signals(two)
    assert list(first.columns) == list(second.columns)
    for name in second.columns:
        np.testing.assert_array_equal(first[name], second[name], name)


def systems(fmus):
    """Return systems by what is special about them."""
    good, any_step = fmus(), fmus("ACCEPTS_ANY_STEP")
    plain = chain(good)
    first, *rest = plain.connections
    backwards = Connection(from_component="c5", output="scaled", to_component="c0", input="level", delay=1)
    return {
        "a tick later": plain,
        "in the same tick": chain(good, delays=(0,)),
        "mixed delays": chain(good, delays=(0, 1, 3)),
        "a loop": replace(plain, connections=(*plain.connections, backwards)),
        "converted values": replace(plain, connections=(replace(first, factor=2.5, offset=-0.125), *rest)),
        "periods and offsets": changed(
            changed(chain(any_step, delays=(0, 1)), "c2", period=3 * STEP, offset=STEP),
            "c4",
            kind="continuous",
            period=2 * STEP,
        ).with_delay("c4", "c5", 1),
        "one in the master's process": changed(chain(good, delays=(0, 1, 1)), "c2", isolated=False),
        "one in its own process": changed(chain(good, delays=(0, 1, 1)), "c3", isolated=True),
        "one fed by later ones": changed(replace(plain, connections=(*rest, backwards)), "c5", isolated=False),
    }


@pytest.mark.parametrize("case", systems(lambda *_: "bad.fmu"))
def test_rows_equal_those_of_a_run_in_the_masters_process(fmus, tmp_path, case):
    system = systems(fmus)[case]
    simulate(system, tmp_path / "shared")
    simulate(inside(system), tmp_path / "inside")
    assert_same_rows(tmp_path / "shared", tmp_path / "inside")
    grouped = {part["name"]: part.get("grouped", False) for part in record(tmp_path / "shared")["component"]}
    assert sum(grouped.values()) >= FEW + 1


def record(folder):
    return tomllib.loads((folder / "run.toml").read_text())


def events(folder):
    return [json.loads(line) for line in (folder / "events.jsonl").read_text().splitlines()]


@pytest.fixture
def connections(monkeypatch):
    """Return a list of the connections that are made."""
    made = []

    class Listed(connection_module.Connection):
        def __init__(self, *arguments, **named):
            made.append(self)
            super().__init__(*arguments, **named)

    for module in ("start_slave", "remote_slave"):
        monkeypatch.setattr(f"lockstep.processes.{module}.Connection", Listed)
    return made


@pytest.mark.parametrize("delay", [0, 1])
def test_one_process_and_one_message_a_tick_step_all(fmus, tmp_path, connections, delay):
    counts = []
    for stop in (50, 150):
        simulate(chain(fmus(), delays=(delay,)), tmp_path / str(stop), stop_time=stop * STEP / 1e9)
        (one,) = connections
        counts.append(one.link.number)
        connections.clear()
    assert counts[1] - counts[0] == 100
    assert events(tmp_path / "50")[0] == {"time": 0.0, "event": "shared-process", "components": NAMES}


def test_steps_beyond_a_number_are_not_joined(fmus, tmp_path, connections, monkeypatch):
    monkeypatch.setattr(batched_steps, "MOST_JOINED", len(NAMES))  # the first batch of the four
    system = systems(fmus)["mixed delays"]
    simulate(system, tmp_path / "shared", stop_time=0.2)
    assert connections[0].link.number > 20 / 4 * (1 + 3 * len(NAMES))
    simulate(inside(system), tmp_path / "inside", stop_time=0.2)
    assert_same_rows(tmp_path / "shared", tmp_path / "inside")


@pytest.mark.parametrize(
    ("defect", "message"),
    [
        ("CRASHES", "c3: crashed with SIGSEGV in fmi2DoStep at 0.05 s"),
        ("EXITS", "c3: ended its process with exit code 3 in fmi2DoStep at 0.05 s"),
        ("HANGS", "c3: no answer within 2 s in fmi2DoStep at 0.05 s"),
        ("RETURNS_FATAL", "c3: fmi2DoStep returned fmi2Fatal at 0.05 s: beyond repair"),
        ("NOT_A_NUMBER", "c3.scaled: is nan at 0.07 s; every exchanged value must be finite"),
    ],
)
@pytest.mark.parametrize("delay", [0, 1])
def test_the_one_that_fails_is_named_and_rows_before_stay(fmus, tmp_path, defect, message, delay):
    system = chain(fmus(), delays=(delay,), others={"c3": fmus(defect)})
    with pytest.raises(RunError) as caught:
        simulate(system, tmp_path / "out", step_limit=2.0 if defect == "HANGS" else None)
    remedy = "; its process holds 6 FMUs, --isolate c3 gives it one of its own"
    ended = defect in ("CRASHES", "EXITS", "HANGS")
    assert str(caught.value) == message + remedy * ended
    assert len(read_signals(tmp_path / "out").time) == (7 if defect == "NOT_A_NUMBER" else 5)
    assert record(tmp_path / "out")["status"] == "failed"


@pytest.mark.parametrize("parameters", [{"last": 4}, {"at": 4, "mode": 7}], ids=["in a step", "after a step"])
@pytest.mark.parametrize("version", ["2.0", "3.0"])
def test_a_component_that_asks_for_the_end_ends_all_as_in_one_process(tmp_path, version, parameters):
    stair = build("stair", version, tmp_path)
    parts = tuple(
        Component(name=name, source=stair, period=STEP, parameters=parameters if name == "c2" else {}) for name in NAMES
    )
    system = System(name="stairs", tick=STEP, stop_time=30 * STEP, components=parts, record=RECORD)
    found = [simulate(each, tmp_path / name) for name, each in {"shared": system, "inside": inside(system)}.items()]
    assert found[0].terminated == found[1].terminated is not None
    assert (found[0].simulated_time, found[0].rows) == (found[1].simulated_time, found[1].rows)
    assert_same_rows(tmp_path / "shared", tmp_path / "inside")


def test_the_limit_is_for_each_call(fmus, tmp_path):
    """A request that goes from call to call is not ended."""
    part = Component(name="a", source=fmus("HANGS"), period=STEP)
    slave = RemoteSlave(part, read_description(part), tmp_path, lambda *_: None)
    try:
        slave.setup_experiment(0.0, 1.0)
        slave.enter_initialization()
        slave.exit_initialization()
        for k in range(6):
            slave.do_step(k * 0.01, 0.01, 1)
        slave.connection.process.limit = 0.3
        for k in range(10):
            time.sleep(0.1)
            slave.connection.last_call.integers[CALL] = 1 + k % 2
        assert slave.connection.process.cause == ""
        with pytest.raises(RunError, match=r"^a: no answer within 0.3 s "):
            slave.complete()
    finally:
        slave.close()


def test_faults_act_as_in_one_process(fmus, tmp_path):
    (tmp_path / "faults.toml").write_text(FAULTS)
    system, faults = chain(fmus(), delays=(0, 1)), [read_scenario(tmp_path / "faults.toml")]
    simulate(system, tmp_path / "shared", faults=faults)
    simulate(inside(system), tmp_path / "inside", faults=faults)
    assert_same_rows(tmp_path / "shared", tmp_path / "inside")


def test_a_run_goes_on_from_a_checkpoint_in_one_process_again(fmus, tmp_path, connections):
    write_ssd(chain(fmus(), delays=(0, 1)), tmp_path / "chain.ssd")
    system = load_system(tmp_path / "chain.ssd")
    simulate(system, tmp_path / "whole")
    simulate(system, tmp_path / "part", checkpoints=CheckpointSchedule(times=["0.11", "0.2"]))
    text = (tmp_path / "part" / "run.toml").read_text()
    (tmp_path / "part" / "run.toml").write_text(text.replace('"completed"', '"failed"'))
    connections.clear()
    resume(tmp_path / "part")
    assert len(connections) == 1
    assert_same_rows(tmp_path / "part", tmp_path / "whole")


def _described(fmu, **fields):
    found = read_description(Component(name="a", source=fmu, period=STEP))
    return {name: replace(found, sha256=name, **fields) for name in NAMES}


def shared(system, descriptions):
    """Return the components that share a process."""
    return [c.name for c in settle(system, descriptions).components if c.grouped]


@pytest.mark.parametrize("reason", [{"version": "1.0"}, {"once_per_process": True}, {"needs_tool": True}])
def test_a_suspected_fmu_has_a_process_of_its_own(fmus, reason):
    system, descriptions = chain(fmus()), _described(fmus())
    assert shared(system, descriptions) == NAMES
    descriptions["c2"] = replace(descriptions["c2"], **reason)
    assert shared(system, descriptions) == [name for name in NAMES if name != "c2"]


def test_few_fmus_have_a_process_each_and_so_have_those_that_the_user_isolates(fmus):
    system, descriptions = chain(fmus()), _described(fmus())
    isolated = changed(system, "c0", isolated=True)
    assert shared(isolated, descriptions) == NAMES[1:]
    assert shared(changed(isolated, "c1", isolated=True), descriptions) == []
    few = settle(replace(system, components=system.components[:FEW], connections=()), descriptions)
    assert [(c.isolated, c.grouped) for c in few.components] == [(True, False)] * FEW


def test_needs_execution_tool_is_read(tmp_path):
    xml = XML.replace("<CoSimulation ", '<CoSimulation needsExecutionTool="true" ')
    fmu = bad_fmu(tmp_path, xml=xml)
    assert read_description(Component(name="a", source=fmu, period=STEP)).needs_tool
