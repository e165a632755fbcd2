"""A bundle gives the outputs of the master bit by bit, whatever the periods, offsets, kinds, delays and conversions."""

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from fmus.bundle_host import MS, alone, bits, bundled, recorded
from lockstep import Component, System
from lockstep.bundle.ports import Choice

FUTURE = {"arm.text"}  # of a step that is longer than the tick


@pytest.fixture(scope="module")
def expected(cells):
    """Return what the master records."""
    return recorded(cells, 0.042)


@pytest.mark.parametrize("ticks", [1, 3], ids=["tick by tick", "three ticks a step"])
def test_every_output_is_that_of_the_master(cells, expected, tmp_path, ticks):
    path = bundled(cells, tmp_path / "four.fmu", step=ticks * MS)
    found = alone(path, 0.042)

    assert {name for name in found if "." in name} == {name for name in expected if "." in name} - FUTURE
    assert len(expected) == 24
    for name in expected.keys() - FUTURE:
        assert bits(found[name]) == bits(expected[name][::ticks]), name
    assert np.ptp(expected["body.y[1]"]) > 0.1
    assert len(set(expected["slow.n"].tolist())) > 3


def test_a_bundle_in_a_bundle_is_the_same(cells, expected, tmp_path):
    inner = Component(name="in", source=bundled(cells, tmp_path / "four.fmu"), period=MS, isolated=False)
    outer = bundled(System(name="outer", tick=MS, components=(inner,)), tmp_path / "outer.fmu")
    found = alone(outer, 0.02)

    for name in expected.keys() - FUTURE:
        assert bits(found[f"in.{name}"]) == bits(expected[name][:21]), name


def test_start_time_and_ticks_that_are_no_whole_nanoseconds_are_those_of_the_master(cells, tmp_path):
    tick = Fraction(10**9, 60)
    parts = tuple(
        replace(c, period=c.period // MS * tick, offset=c.offset // MS * tick, isolated=False) for c in cells.components
    )
    system = replace(cells, tick=tick, components=parts, stop_time=None, start_time=7 * 10**9)
    found = alone(bundled(system, tmp_path / "film.fmu"), "23/3", record_period="1/60")
    expected = recorded(system, "23/3")

    for name in expected.keys() - FUTURE:
        assert bits(found[name]) == bits(expected[name]), name


def test_plant_and_sensors_in_a_bundle_with_the_controller_outside_are_the_whole_loop(cells, tmp_path):
    """No input of the bundle reaches the sensors, so that the controller has their sample at the same time."""
    loop = closed_loop(cells)
    inside = System(
        name="rig",
        tick=MS,
        components=loop.components[:1] + loop.components[2:],
        connections=tuple(c for c in loop.connections if "controller" not in (c.from_component, c.to_component)),
    )
    choice = Choice(inputs=("body.u[1]", "body.k"), outputs=("all",))
    rig = Component(name="rig", source=bundled(inside, tmp_path / "rig.fmu", choice), period=MS, kind="continuous")
    found = recorded(outside(loop, rig, "controller", {"sensors", "body"}, 1, 0), 0.05)

    compare(found, recorded(loop, 0.05))


def test_sensors_and_controller_in_a_bundle_with_the_plant_outside_are_the_whole_loop(cells, tmp_path):
    """An input of the bundle reaches both, so that it is sampled itself: it takes its sample in the step."""
    loop = closed_loop(cells)
    inside = System(
        name="avionics",
        tick=MS,
        components=loop.components[:2],
        connections=tuple(c for c in loop.connections if "body" not in (c.from_component, c.to_component)),
    )
    choice = Choice(inputs=("sensors.u[2]",), outputs=("all",))
    path = bundled(inside, tmp_path / "avionics.fmu", choice)
    found = recorded(outside(loop, Component(name="box", source=path, period=MS, kind="sampled"), "body",
                             {"sensors", "controller"}, 0, 1), 0.05)  # fmt: skip

    compare(found, recorded(loop, 0.05))


def closed_loop(cells):
    """Return sensors, a controller at a fifth of their rate, and a plant; nothing of them counts at initialization."""
    source, wire = cells.components[0].source, cells.connections[0]

    def part(name, period, kind):
        return Component(
            name=name, source=source, period=period * MS, kind=kind, parameters={"gain": 30.0, "u[3]": 1.0}
        )

    def link(start, output, end, target, delay):
        ends = {"from_component": start, "output": output, "to_component": end, "input": target}
        return replace(wire, **ends, delay=delay, convert_units=False)

    return System(
        name="loop",
        tick=MS,
        components=(part("sensors", 1, "sampled"), part("controller", 5, "sampled"), part("body", 1, "continuous")),
        connections=(
            link("body", "y[1]", "sensors", "u[2]", 1),
            link("sensors", "y[2]", "controller", "u[2]", 0),
            link("controller", "y[2]", "body", "u[1]", 0),
            link("controller", "n", "body", "k", 0),
        ),
    )


def outside(loop, bundle, single, inner, to_single, from_single):
    """Return the loop with a bundle in the place of two components, and the delays between it and the third one."""

    def moved(connection):
        start, end = connection.from_component, connection.to_component
        if start in inner and end in inner:
            return None
        if start in inner:
            output = f"{start}.{connection.output}"
            return replace(connection, from_component=bundle.name, output=output, delay=to_single)
        target = f"{end}.{connection.input}"
        return replace(connection, to_component=bundle.name, input=target, delay=from_single)

    parts = (bundle, loop.component(single))
    return System(
        name="split", tick=MS, components=parts, connections=tuple(filter(None, map(moved, loop.connections)))
    )


def compare(found, expected):
    """Compare all outputs by the names without that of the bundle."""
    names = {name.removeprefix("rig.").removeprefix("box."): name for name in found}
    assert names.keys() == expected.keys()
    assert min(np.ptp(expected[f"{part}.y[2]"]) for part in ("sensors", "controller")) > 1e-3
    for name, values in expected.items():
        assert bits(found[names[name]]) == bits(values), name
