"""FMUs by name with connections as pairs of names, and what else `simulate` and `open` take as a system."""

from dataclasses import replace

import pytest

import lockstep
from lockstep import Component, Connection, InputError, System, simulate, write_ssd
from lockstep.simulation import as_system

MS = 1_000_000  # [ns]


def inside(fmu):
    """Return a component in this process; the name and the period come later."""
    return Component(name="any", source=fmu, period=1, isolated=False)


@pytest.fixture
def given(fmus, toys):
    """Return two components and a connection of an array and of a scalar."""
    return {
        "system": {
            "counter": inside(toys / "toy_counter.fmu"),
            "one": inside(fmus["echo"]),
            "two": inside(toys / "toy_echo.fmu"),
        },
        "connections": [("counter.count", "one.x"), ("two.y", "two.u")],
        "periods": {"counter": 0.002, "one": "0.004", "two": 0.001},
        "stop_time": 0.02,
    }


def test_pairs_connect_scalars_and_whole_arrays(given):
    kinds = {"counter": "sampled"}
    with lockstep.open(**given, kinds=kinds, record=["counter.count", "one.out.x"]) as run:
        system = run.system
        assert repr(system) == "<System counter+one+two: counter, one, two; 3 connections, tick 0.001 s>"
        found = [(str(c), c.delay) for c in system.connections]
        assert found == [("counter.count -> one.x", 0), ("two.y[1] -> two.u[1]", 1), ("two.y[2] -> two.u[2]", 1)]
        assert [(c.name, c.period, c.kind) for c in system.components] == [
            ("counter", 2 * MS, "sampled"), ("one", 4 * MS, "continuous"), ("two", MS, "continuous")
        ]  # fmt: skip
        for _ in run:
            pass
    assert run.signals["counter.count"].tolist() == [k // 2 + 1 for k in range(21)]
    assert run.signals["one.out.x"].tolist() == [0.0] * 4 + [2.0 * (k // 4) - 1.0 for k in range(4, 21)]


def test_it_is_the_system_that_is_written_out(given, fmus, toys):
    whole = simulate(**given, kinds={"counter": "sampled", "two": "sampled"}, delays={"two:two": 3})
    wire = Connection(from_component="counter", output="count", to_component="one", input="x")
    arrays = [Connection(from_component="two", output=f"y[{k}]", to_component="two", input=f"u[{k}]", delay=3)
              for k in (1, 2)]  # fmt: skip
    system = System(
        name="s", tick=MS, stop_time=20 * MS, connections=(wire, *arrays),
        components=(replace(inside(toys / "toy_counter.fmu"), name="counter", period=2 * MS, kind="sampled"),
                    replace(inside(fmus["echo"]), name="one", period=4 * MS),
                    replace(inside(toys / "toy_echo.fmu"), name="two", period=MS, kind="sampled")),
    )  # fmt: skip
    other = simulate(system)
    assert list(whole) == list(other)
    for name in whole:
        assert whole[name].tolist() == other[name].tolist()


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"connections": [("counter.cont", "one.x")]}, r"counter\.cont: .*did you mean count\?"),
        ({"connections": [("countr.count", "one.x")]}, r"countr\.count: write component\.variable of a component "
                                                       r"that is there; .* counter, one, two; did you mean counter\?"),
        ({"connections": [("count", "one.x")]}, r"count: write component\.variable"),
        ({"connections": [("counter.count", "two.u")]}, r"counter\.count -> two\.u: 1 and 2 elements; connect arr"),
        ({"connections": [("one.x", "one.h")]}, r"one\.x -> one\.h: one\.x is the FMU's input, an output is needed"),
        ({"connections": ["counter.count -> one.x"]}, r"connections: 'counter.count -> one.x' must be a pair of names"),
        ({"periods": {"three": 1.0}}, r"periods: three: no such component; there are counter, one, two"),
        ({"periods": {"one": 0.0}}, r"one: period 0\.0: must be > 0 s"),
        ({"periods": "often"}, r"counter: period: 'often' is not a number of seconds"),
        ({"kinds": {"one": "discrete"}}, r"one: kind 'discrete' must be sampled or continuous"),
        ({"kinds": {"oone": "sampled"}}, r"kinds: oone: no such component; .*did you mean one\?"),
        ({"delays": {"two": 1}}, r"delays: 'two' must name two components, such as 'plant:controller'"),
        ({"delays": {"one:two": 1}}, r"one -> two: no such connection, so it cannot have a delay"),
        ({"system": {}}, r"no FMUs are given; name at least one"),
        ({"system": {"plant": 3}, "connections": [], "periods": 1.0}, r"plant: 3 must be the path of an FMU, or a Com"),
        ({"system": {"plant": "none.fmu"}, "connections": [], "periods": None}, r"plant: .*none\.fmu.*"),
    ],
)  # fmt: skip
def test_what_is_wrong_is_named_with_the_remedy(given, changed, message):
    with pytest.raises(InputError, match=message):
        lockstep.open(**given | changed)


def test_paths_and_systems_are_taken_too(fmus, triple, tmp_path):
    write_ssd(triple, tmp_path / "triple.ssd")
    with lockstep.open(str(fmus["echo"]), periods=0.5) as alone:
        assert (alone.tick, alone.stop_time) == (0.5, 1.0)
    for system in (triple, tmp_path / "triple.ssd"):
        with lockstep.open(system, periods={"b": 0.006}, delays={("b", "p"): 5}, kinds={"a": "sampled"}) as run:
            assert [c.period for c in run.system.components] == [2 * MS, 6 * MS, 2 * MS]
            assert {c.delay for c in run.system.connections if c.from_component == "b"} == {5}
        with pytest.raises(InputError, match="connections: are those of the system; give connections with FMUs"):
            lockstep.open(system, connections=[("a.y", "b.u")])
        with pytest.raises(InputError, match=r"c: no such component; there are a, b, p|c: .*no component"):
            lockstep.open(system, periods={"c": 0.006})


def test_a_component_that_nothing_gives_a_period_says_so(fmus):
    assert as_system({"echo": fmus["echo"]}).warnings == (
        "echo: no period is given, and the FMU has no default step size: stepped every 0.001 s; give "
        "periods={'echo': SECONDS}",
    )
