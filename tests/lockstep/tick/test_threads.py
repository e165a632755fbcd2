"""Steps of FMUs in threads: rows, events and errors are those of steps in turn, in C, in Python and in processes."""

import json
import threading
import time
import tomllib
from ctypes import CFUNCTYPE, c_double, c_int32, c_void_p, cast, sizeof
from dataclasses import replace

import numpy as np
import pytest

from fmus.busy_fmu import END_AFTER, END_BEFORE, FAIL, NOT_A_NUMBER, WARN, busy_fmu
from lockstep import Component, Connection, System, read_signals, simulate, write_ssd
from lockstep.__main__ import main
from lockstep.errors import InputError, RunError
from lockstep.fmi.log_callbacks import Messages
from lockstep.fmi.native_call import Apart
from lockstep.fmi.slave import FATAL, WARNING
from lockstep.operating_system import available_cores
from lockstep.tick.compiled import load
from lockstep.tick.threads import Jobs, StepJob

TICK = 1_000_000  # [ns]
STOP = 0.06  # [s]


@pytest.fixture(scope="module")
def busy(tmp_path_factory):
    """Return the FMU whose steps take as long as a parameter says."""
    return busy_fmu(tmp_path_factory.mktemp("busy"))


def part(name, fmu, period=1, kind="sampled", **parameters):
    """Return a component that is stepped every so many ticks."""
    return Component(name=name, source=fmu, period=period * TICK, kind=kind, isolated=False, parameters=parameters)


def link(one, two, delay):
    """Connect an output with an input."""
    return Connection(from_component=one, output="y", to_component=two, input="u", delay=delay)


def several(fmu, **troubles):
    """Return five components: two beside each other, two that read those, at other rates too, and one that is alone."""
    parts = [
        part("a", fmu, gain=2.0, work=30.0),
        part("b", fmu, gain=3.0, work=60.0),
        part("c", fmu, 2, gain=2.5),
        part("d", fmu, 1, "continuous", gain=1.5, work=10.0),
        part("e", fmu, 4, gain=2.2, work=100.0),
    ]
    parts = [replace(p, parameters={**p.parameters, **troubles.get(p.name, {})}) for p in parts]
    links = (link("a", "c", 0), link("b", "d", 0), link("c", "a", 1), link("d", "b", 1), link("d", "e", 1))
    return System(name="several", tick=TICK, components=tuple(parts), connections=links, record=("*.y", "*.u"))


def ended(system, folder, stop=STOP, **options):
    """Run; return the rows, the events without those of the start, and the error."""
    try:
        simulate(system, folder, stop_time=stop, **options)
        error = ""
    except RunError as raised:
        error = str(raised)
    found = read_signals(folder)
    events = [json.loads(line) for line in (folder / "events.jsonl").read_text().splitlines()]
    logged = [{k: v for k, v in event.items() if k != "wall_time"} for event in events if event["event"] != "start"]
    table = np.column_stack([found[name] for name in sorted(found)])
    assert len(np.unique(table)) > table.size // 4  # no value is that of another row by chance
    return table.tobytes(), logged, error


WAYS = {
    "python": {"tick": "python"},
    "in turn": {"tick": "c", "threads": 1},
    "two threads": {"tick": "c", "threads": 2},
    "four threads": {"tick": "c", "threads": 4},
    "chosen": {"tick": "c", "threads": "auto"},
}
TROUBLES = {
    "none": {},
    "warning": {"a": {"at": 21, "trouble": WARN}, "b": {"at": 21, "trouble": WARN}},
    "error": {"b": {"at": 20, "trouble": FAIL, "work": 300.0}},
    # in every second tick b is finished first, as d reads it
    "error of the first": {"a": {"at": 21, "trouble": FAIL, "work": 500.0}, "b": {"at": 21, "trouble": FAIL}},
    "end before a step": {"b": {"at": 21, "trouble": END_BEFORE}},
    "end after a step": {"a": {"at": 20, "trouble": END_AFTER}, "b": {"at": 20, "trouble": END_AFTER}},
    "value": {"b": {"at": 21, "trouble": NOT_A_NUMBER}, "e": {"at": 6, "trouble": FAIL}},
    "value of the first, then an error": {"a": {"at": 21, "trouble": NOT_A_NUMBER}, "b": {"at": 21, "trouble": FAIL}},
}


@pytest.mark.parametrize("trouble", TROUBLES)
def test_rows_events_and_errors_are_those_of_steps_in_turn(busy, tmp_path, trouble):
    system = several(busy, **TROUBLES[trouble])
    found = {way: ended(system, tmp_path / way, **options) for way, options in WAYS.items()}

    expected = found.pop("python")
    assert {way: result == expected for way, result in found.items()} == dict.fromkeys(found, True)
    rows, events, error = expected
    assert len(rows) >= 20 * 10 * 8
    assert bool(error) == (trouble not in ("none", "warning", "end before a step", "end after a step"))
    assert (trouble == "warning") == any(event["event"] == "log" for event in events if not error)
    threads = {way: tomllib.loads((tmp_path / way / "run.toml").read_text())["threads"] for way in WAYS}
    assert (threads["in turn"], threads["two threads"], threads["four threads"]) == (1, 2, 4)


def test_rows_of_isolated_components_are_the_same(busy, tmp_path):
    system = several(busy)
    apart = replace(system, components=tuple(replace(c, isolated=c.name != "b") for c in system.components))
    rows, *_ = ended(system, tmp_path / "threads", threads=3)

    assert ended(apart, tmp_path / "isolated", threads=3)[0] == rows
    assert ended(apart, tmp_path / "python", tick="python")[0] == rows


@pytest.mark.parametrize("version", ["1.0", "2.0", "3.0"])
def test_all_versions_of_fmi_are_stepped_in_threads(reference_fmu, tmp_path, version):
    fmu = reference_fmu("dahlquist", version)
    parts = tuple(
        Component(name=name, source=fmu, period=100_000_000, kind="continuous", isolated=False, parameters={"k": k})
        for name, k in (("one", 1.0), ("two", 0.5))
    )
    system = System(name="two", tick=100_000_000, components=parts, record=("*.x",))
    rows = [ended(system, tmp_path / str(threads), stop=2.0, threads=threads)[0] for threads in (1, 2)]

    assert rows[0] == rows[1]


def test_a_step_that_lasts_after_ctrl_c_is_left_alone():
    """In turn nothing can end it. Here its FMU is not called any more, and the other one, which is done, may be."""
    library, may_end, noted = load(), threading.Event(), []
    calls = [
        CFUNCTYPE(c_int32, c_void_p, c_double)(call) for call in (lambda *_: not may_end.wait(30.0), lambda *_: WARNING)
    ]
    steps = {
        name: (Apart(messages=Messages(name, lambda *_: None), failed=lambda s, n=name: noted.append((n, s))), None)
        for name in ("hangs", "ends")
    }
    jobs = Jobs(library, ("hangs", "ends"), steps)
    jobs.start(3, available_cores())
    jobs.choose(frozenset({0, 1}))
    for number, call in enumerate(calls):
        jobs.structures[number].call = cast(call, c_void_p)
        library.job_begin(c_void_p(jobs.pool), c_void_p(jobs.address + number * sizeof(StepJob)), c_double(0.0))
    while any(jobs.structures[number].state == state for number, state in ((0, 1), (1, 1), (1, 2))):
        time.sleep(0.001)  # until the one runs and the other one is done
    began = time.monotonic()
    jobs.settle(0.1)
    lasted = time.monotonic() - began
    jobs.close()  # does not wait
    may_end.set()

    assert noted == [("hangs", FATAL), ("ends", WARNING)]
    assert 0.1 <= lasted < 5.0


@pytest.mark.parametrize("threads", [-1, 1.5, "many", 1000, True])
def test_other_values_are_refused(busy, tmp_path, threads):
    with pytest.raises(InputError, match=r"threads .*must be auto, or a whole number from 0 to 256"):
        simulate(several(busy), tmp_path / "run", stop_time=STOP, threads=threads)
    assert not (tmp_path / "run").exists()


def test_threads_without_the_tick_in_c_are_refused(busy, tmp_path):
    with pytest.raises(InputError, match="threads 2: need the tick in C; choose tick c"):
        simulate(several(busy), tmp_path / "run", stop_time=STOP, threads=2, tick="python")


def test_steps_that_wait_for_each_other_are_in_turn(busy, tmp_path):
    chain = System(
        name="chain",
        tick=TICK,
        components=(part("a", busy, gain=2.0), part("b", busy, gain=3.0)),
        connections=(link("a", "b", 0),),
        record=("*.y",),
    )
    ended(chain, tmp_path / "run", threads=4)

    assert tomllib.loads((tmp_path / "run" / "run.toml").read_text())["threads"] == 1


def test_the_command_line_sets_their_number(busy, tmp_path, capsys):
    write_ssd(several(busy), tmp_path / "several.ssd")
    command = ["run", str(tmp_path / "several.ssd"), "--stop-time", "0.02", "--share-process", "*"]
    found = {}
    for threads in ("1", "3", "none"):
        code = main([*command, "--out", str(tmp_path / threads), "--threads", threads])
        record = tmp_path / threads / "run.toml"
        found[threads] = code, tomllib.loads(record.read_text())["threads"] if record.exists() else None

    assert found == {"1": (0, 1), "3": (0, 3), "none": (2, None)}
    assert "threads 'none': must be auto, or a whole number from 0 to 256; 0 and 1: in turn" in capsys.readouterr().err
