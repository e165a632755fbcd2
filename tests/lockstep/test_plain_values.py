"""Values of numpy and other types in the Python interface: kept as what they are, or refused in one line."""

import json
import tomllib
from collections import namedtuple
from pathlib import Path

import numpy as np
import pytest

from lockstep import Component, Connection, InputError, System, Unit
from lockstep.data_text import parse_json, parse_toml
from lockstep.plain_values import plain_value
from lockstep.results.read_events import read_events
from lockstep.results.run_record import Events, to_toml
from lockstep.ssp.documents.xml import SSC, SSV, new_root
from lockstep.ssp.typed_values import literal, read_hop, read_units, write_transformation, write_units
from lockstep.system.clock import nanoseconds
from lockstep.system.transformation import Table

KEPT = [
    (np.float64(0.1), 0.1, "Real"),
    (np.float32(0.5), 0.5, "Real"),
    (np.float64("nan"), float("nan"), "Real"),
    (np.int64(5), 5, "Integer"),
    (np.uint8(5), 5, "Integer"),
    (np.bool_(True), True, "Boolean"),
    (np.str_("a"), "a", "String"),
    (np.array(2.5), 2.5, "Real"),
    (np.array(True), True, "Boolean"),
    (Path("a/b"), "a/b", "String"),
    ([np.float64(0.0), np.int64(1)], [0.0, 1], None),
    ((np.bool_(False), 2.0), [False, 2.0], None),
    (np.array([[1.0, 2.0], [3.0, 4.0]]), [[1.0, 2.0], [3.0, 4.0]], None),
    (range(3), [0, 1, 2], None),
    (namedtuple("Pair", "a b")(np.float64(1.5), "x"), [1.5, "x"], None),
]


@pytest.mark.parametrize(("value", "plain", "kind"), KEPT, ids=lambda value: type(value).__name__)
def test_values_come_back_from_toml_json_and_ssp(value, plain, kind):
    found = [
        plain_value(value, "x"),
        tomllib.loads(to_toml({"x": value}))["x"],
        json.loads(json.dumps(plain_value(value, "x"))),
    ]
    for each in found:
        assert type(each) is type(plain)
        assert repr(each) == repr(plain)  # NaN differs from itself
    if kind is not None:
        text = {"Real": repr(plain), "Boolean": str(plain).lower()}.get(kind, str(plain))
        assert literal(value, {}) == (kind, text)


@pytest.mark.parametrize(
    "value",
    [None, [1.0, None], 1j, object(), {1.0}, b"x", np.array([None]), np.array(1j)],
    ids=lambda value: type(value).__name__,
)
def test_what_cannot_be_kept_is_refused_by_name(value):
    with pytest.raises(InputError, match=r"^x: .* cannot be kept; give a number, a text, True or False, or a list of"):
        to_toml({"x": value})


@pytest.mark.parametrize("time", [np.float64(0.1), np.float32(0.1), np.array(0.1), "0.1", 0.1])
def test_times_of_numpy_are_exact(time):
    assert nanoseconds(time, "t") == 10**8


def test_systems_made_with_numbers_of_numpy_hold_plain_ones():
    part = Component(name="a", source=Path("a.fmu"), period=np.int64(1000), kind="sampled", offset=np.int32(10))
    ends = {"from_component": "a", "output": "y", "to_component": "a", "input": "u"}
    wire = Connection(**ends, delay=np.int64(1), factor=np.float64(2))
    system = System(name="s", tick=np.int64(10), components=(part,), connections=(wire,), stop_time=np.uint32(2000))
    values = [part.period, part.offset, wire.delay, wire.factor, wire.offset, system.tick, system.stop_time]
    assert [type(value) for value in values] == [int, int, int, float, float, int, int]
    with pytest.raises(InputError, match=r"a: period \[ns\]: 0\.5 must be a whole number"):
        Component(name="a", source=Path("a.fmu"), period=0.5, kind="sampled")
    with pytest.raises(InputError, match=r"a\.y -> a\.u: factor: None cannot be kept"):
        Connection(**ends, factor=None)


def test_units_and_tables_with_numbers_of_numpy_are_written_as_plain_ones():
    root = new_root(SSV, "ParameterSet", {"ssv": SSV, "ssc": SSC})
    unit = Unit(name="deg", exponents=(0,) * 7 + (1,), factor=np.float64(0.5), offset=np.float32(2.0))
    write_units(root, SSV, {"deg": unit})
    table = Table(kind="Boolean", entries=((np.bool_(True), np.bool_(False)),))
    write_transformation(root, 1.0, 0.0, table)
    assert read_units(root, "x") == {"deg": Unit(name="deg", exponents=unit.exponents, factor=0.5, offset=2.0)}
    assert read_hop(root).table == Table(kind="Boolean", entries=((True, False),))


def test_events_with_numbers_of_numpy_are_written(tmp_path):
    events = Events(np.float64(1.5))
    events.add("fault", values={"value": np.int64(3), "list": np.arange(2)})
    events.open(tmp_path)
    events.close()
    assert read_events(tmp_path) == [{"time": 1.5, "event": "fault", "values": {"value": 3, "list": [0, 1]}}]


@pytest.mark.parametrize("parse", [parse_json, parse_toml])
def test_text_that_is_too_deep_is_refused_in_one_line(parse):
    deep = "[" * 100_000
    with pytest.raises(InputError, match=r"^f: is nested too deeply to be read; restore it$"):
        parse(deep if parse is parse_json else f"x = {deep}", "f", "restore it")
    with pytest.raises(InputError, match=r"^f: is no (JSON|TOML) file \(.*\)$"):
        parse(b"\xff", "f")
