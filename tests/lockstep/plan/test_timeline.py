"""The timeline against the schedule worked out by hand, and against what a run really delivers."""

from dataclasses import replace
from html import escape
from xml.etree import ElementTree

import pytest

from lockstep import InputError, read_signals, simulate
from lockstep.plan.timeline import routes, timeline, timeline_lines
from lockstep.plan.timeline_svg import timeline_svg

MS = 1_000_000


@pytest.fixture
def steps(loop):
    return timeline(loop, 7)


def of(steps, component, tick):
    return next(step for step in steps if (step.component, step.tick) == (component, tick))


def test_components_step_at_their_periods_producers_first(steps):
    assert [s.component for s in steps if s.tick == 0] == ["counter", "echo", "plant"]
    assert [s.component for s in steps if s.tick == 4] == ["counter", "plant"]
    assert [s.tick for s in steps if s.component == "echo"] == [0, 5]
    assert {s.end - s.start for s in steps if s.component == "echo"} == {5 * MS}


def test_reads_have_the_time_of_their_delay(steps):
    (now,) = of(steps, "echo", 5).reads
    assert (now.producer, now.count, now.delay, now.since, now.initial) == ("counter", 3, 0, 5 * MS, False)
    (then,) = of(steps, "plant", 6).reads
    assert (then.producer, then.delay, then.since, then.initial) == ("counter", 2, 4 * MS, False)
    assert [of(steps, "plant", tick).reads[0].initial for tick in (0, 1, 2)] == [True, True, False]


def test_a_continuous_value_is_true_at_the_end_of_its_step(loop):
    back = replace(loop.connections[0], from_component="plant", output="x", to_component="echo", input="u[2]", delay=1)
    system = replace(loop, connections=(*loop.connections, back))
    read = next(r for r in of(timeline(system, 6), "echo", 5).reads if r.producer == "plant")
    assert (read.since, read.initial) == (5 * MS, False)


def test_offsets_shift_the_first_step(loop):
    counter, echo, plant = loop.components
    system = replace(loop, components=(counter, replace(echo, offset=2 * MS), plant))
    assert [s.tick for s in timeline(system, 8) if s.component == "echo"] == [2, 7]


def test_values_of_a_run_have_the_times_of_the_timeline(loop, tmp_path):
    """The counter counts its steps from 1, so a count gives the time from which it was held."""
    simulate(loop, tmp_path / "run", record=("echo.y[1]", "counter.count"), record_period="0.001")
    signals = read_signals(tmp_path / "run")
    times = signals.time.round(9)
    by_time = dict(zip(times, signals.columns["counter.count"], strict=True))
    echoed = dict(zip(times, signals.columns["echo.y[1]"], strict=True))
    assert by_time[0.005] == 6.0
    for step in timeline(loop, 10):
        if step.component == "echo":
            assert echoed[step.start / 1e9] == by_time[step.reads[0].since / 1e9]


def test_lines_name_component_source_and_time(loop):
    text = "\n".join(timeline_lines(loop, 3))
    assert "loop: the first 3 ticks of 0.001 s" in text
    assert "3 from counter of 0 s (same tick)" in text
    assert "1 from counter initial (delay 2)" in text
    assert "outputs true at 0.003 s" in text


def test_connected_ports_are_listed_with_their_latency(loop):
    twice = replace(loop.connections[0], output="steps", input="u[2]")
    system = replace(loop, connections=(*loop.connections, twice, replace(twice, output="steps", input="u[3]")))

    lines = timeline_lines(system, 2)

    assert lines[lines.index("connections:") + 1 :] == [
        "  counter -> echo (same tick): count -> u, even -> flag, steps -> number, steps -> u[2]",
        "  counter -> plant (delay 2 ticks): count -> u",
    ]
    assert all(f"{escape(str(route))}</title>" in timeline_svg(system, 2) for route in routes(system))


def test_figure_has_a_box_for_each_step_and_an_arrow_for_each_read(loop):
    steps = timeline(loop, 6)
    root = ElementTree.fromstring(timeline_svg(loop, 6))
    space = "{http://www.w3.org/2000/svg}"
    assert len(root.findall(f"{space}rect")) == len(steps)
    arrows = [line for line in root.findall(f"{space}line") if line.get("marker-end")]
    assert len(arrows) == sum(len(step.reads) for step in steps)


def test_system_that_cannot_run_has_no_timeline(loop):
    with pytest.raises(InputError, match="not a whole multiple"):
        timeline(replace(loop, components=(replace(loop.components[0], period=1_500_000),), connections=()), 3)
