"""Orders, versions and refusals of the schedule, from its definitions alone."""

import itertools
from pathlib import Path

import pytest

from lockstep import Component, Connection, InputError, System
from lockstep.plan.schedule import Task, build_schedule, cycle_length, ring_size, whole_ticks

MS = 1_000_000


def component(name, period=1, offset=0, kind="sampled"):
    return Component(name=name, source=Path("none.fmu"), period=period * MS, offset=offset * MS, kind=kind)


def connection(start, end, delay=0):
    return Connection(from_component=start, output="y", to_component=end, input=f"from_{start}", delay=delay)


def system(components, connections=()):
    return System(name="s", tick=MS, components=tuple(components), connections=tuple(connections))


def names(schedule):
    return [task.name for task in schedule.tasks]


def test_producers_come_first_and_free_choices_keep_the_file_order():
    parts = [component("plant", kind="continuous"), component("controller", 5), component("sensors"), component("free")]
    wires = [connection("plant", "sensors", 1), connection("sensors", "controller"), connection("controller", "plant")]
    assert names(build_schedule(system(parts, wires))) == ["sensors", "controller", "plant", "free"]


def test_a_cycle_is_refused_with_the_cycle_printed():
    parts = [component(name) for name in ("outside", "a", "b", "c")]
    wires = [connection("a", "b"), connection("b", "c"), connection("c", "a"), connection("a", "outside")]
    with pytest.raises(InputError, match=r"cycle: (a -> b -> c -> a|b -> c -> a -> b|c -> a -> b -> c); give one"):
        build_schedule(system(parts, wires))


@pytest.mark.parametrize(
    ("wires", "members"),
    [
        (["ab", "ba", "bc", "cd", "da"], ["ab", "abcd"]),  # a short cycle within a long one
        (["ab", "bc", "cb", "ca"], ["abc", "bc"]),
        (["xa", "ab", "bc", "ca", "cy", "yz"], ["abc"]),  # a source, and those that wait for the cycle
        (["ab", "ba", "bc", "cd", "dc"], ["ab", "cd"]),  # one after the other
    ],
)
def test_printed_members_form_a_cycle_among_nested_ones(wires, members):
    parts = [component(name) for name in "zyxdcba"]
    connections = [connection(*ends) for ends in wires]
    with pytest.raises(InputError) as refused:
        build_schedule(system(parts, connections))
    printed = str(refused.value).partition("cycle: ")[2].partition(";")[0].split(" -> ")
    assert printed[0] == printed[-1]
    assert {a + b for a, b in itertools.pairwise(printed)} <= set(wires)
    assert "".join(sorted(printed[1:])) in members


def test_one_delay_breaks_a_cycle():
    parts = [component("a"), component("b")]
    schedule = build_schedule(system(parts, [connection("a", "b", 1), connection("b", "a")]))
    assert names(schedule) == ["b", "a"]


def test_components_without_common_steps_are_not_ordered():
    parts = [component("a", 2, 0), component("b", 2, 1)]
    schedule = build_schedule(system(parts, [connection("a", "b"), connection("b", "a")]))
    assert names(schedule) == ["a", "b"]


def test_a_component_that_feeds_itself_in_the_same_tick_is_a_cycle():
    with pytest.raises(InputError, match="cycle: a -> a"):
        build_schedule(system([component("a")], [connection("a", "a")]))


def test_a_same_tick_value_of_a_continuous_component_is_refused():
    parts = [component("plant", kind="continuous"), component("sensors")]
    with pytest.raises(InputError, match=r"plant\.y -> sensors\.from_plant: .* of the future; .* delay of 1 tick"):
        build_schedule(system(parts, [connection("plant", "sensors")]))


@pytest.mark.parametrize(
    ("period", "offset", "message"),
    [
        (
            2_500_000,
            0,
            r"a: period 0\.0025 s is not a whole multiple of the tick 0\.001 s; choose 0\.002 s or 0\.003 s",
        ),
        (500_000, 0, r"a: period 0\.0005 s is not .*; choose 0\.001 s"),
        (5 * MS, 1_500_000, r"a: offset 0\.0015 s is not a whole multiple"),
    ],
)
def test_period_or_offset_between_ticks_is_refused(period, offset, message):
    part = Component(name="a", source=Path("none.fmu"), period=period, kind="sampled", offset=offset)
    with pytest.raises(InputError, match=message):
        build_schedule(system([part]))


def test_an_offset_beyond_the_period_is_refused():
    with pytest.raises(InputError, match=r"a: offset 0\.003 s must be in \[0, 0\.003\) s"):
        component("a", 3, 3)


def test_periods_in_a_ratio_of_three_to_two():
    schedule = build_schedule(system([component("a", 3), component("b", 2, 1)]))
    steps = [[task.name for task in schedule.tasks if task.steps_at(tick)] for tick in range(6)]
    assert steps == [["a"], ["b"], [], ["a", "b"], [], ["b"]]
    assert schedule.hyperperiod() == 6
    assert schedule.hyperperiod(5) == 30


@pytest.mark.parametrize("continuous", [False, True])
@pytest.mark.parametrize(("period", "offset"), [(1, 0), (2, 0), (2, 1), (3, 0), (3, 2), (5, 0), (5, 2)])
@pytest.mark.parametrize("delay", [0, 1, 2, 6])
def test_the_version_seen_is_the_newest_produced_by_then(continuous, period, offset, delay):
    task = Task(name="a", period=period, offset=offset, continuous=continuous)
    begins = range(offset, 60, period)
    for tick in range(10, 40):
        produced = [begin + (period - 1 if continuous else 0) for begin in begins]
        assert max(0, task.seen(tick, delay)) == sum(end <= tick - delay for end in produced)


@pytest.mark.parametrize("period", [1, 2, 5])
@pytest.mark.parametrize("delay", [1, 2, 7])
def test_no_reader_sees_a_continuous_value_of_the_future(period, delay):
    task = Task(name="plant", period=period, continuous=True)
    for tick in range(50):
        ends_at = max(0, task.seen(tick, delay)) * period
        assert ends_at <= max(0, tick - delay + 1)
        assert task.true_at(tick) * period <= tick  # and no recorded row holds one


def test_rings_are_powers_of_two_that_hold_the_lag():
    assert [ring_size([lag]) for lag in (0, 1, 2, 3, 4, 6, 8)] == [1, 2, 4, 4, 8, 8, 16]
    assert ring_size([]) == 1


def test_every_ring_repeats_after_the_cycle():
    tasks = [Task(name="a", period=1), Task(name="b", period=5)]
    assert cycle_length(5, {"a": 1, "b": 1}, tasks) == 5
    assert cycle_length(5, {"a": 8, "b": 2}, tasks) == 40
    with pytest.raises(InputError, match="shorter delays"):
        cycle_length(5, {"a": 2**20, "b": 1}, tasks)


def test_periods_without_a_small_common_multiple_are_refused():
    parts = [component("a", 997), component("b", 991)]
    with pytest.raises(InputError, match=r"repeat after 988027 ticks only.*a 0\.997 s, b 0\.991 s"):
        build_schedule(system(parts)).hyperperiod()
    with pytest.raises(InputError, match=r"a 0\.001 s, recording 60 s; choose"):
        build_schedule(system([component("a")])).hyperperiod(60_000)


def test_stop_time_must_be_positive_and_whole_ticks():
    assert whole_ticks(3 * MS, MS, "stop time") == 3
    with pytest.raises(InputError, match=r"stop time 0 s must be > 0"):
        whole_ticks(0, MS, "stop time")
