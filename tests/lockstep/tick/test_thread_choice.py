"""Which steps threads make: judged by rates of ticks, with threads and in turn, on a clock that the test moves."""

import pytest

from lockstep.tick.thread_choice import NONE, ThreadChoice

BOTH = frozenset({0, 1})


def looked(choice, until, means, rates, start=0.0, tick=0):
    """Look every 0.1 s; ticks pass at the rate of the way that is chosen. Return what was chosen at each look."""
    found, now, done = [], start, float(tick)
    while now < until:
        chosen = choice.look(now, int(done), means)
        found.append(chosen)
        done += 0.1 * rates[bool(chosen)]
        now += 0.1
    return found


def test_long_steps_that_gain_stay_in_threads():
    found = looked(ThreadChoice(BOTH), 10.0, (500e-6, 500e-6), {False: 1000, True: 1900})

    assert found[0] == NONE  # measured in turn first
    assert found.index(BOTH) <= 2
    assert found[3:] == [BOTH] * len(found[3:])  # no comparison as long as ticks come as fast


def test_steps_without_a_gain_stay_in_turn():
    """Another program has the second core."""
    found = looked(ThreadChoice(BOTH), 30.0, (500e-6, 500e-6), {False: 1000, True: 1010})

    assert BOTH in found
    assert found[50:].count(BOTH) / len(found[50:]) < 0.1


def test_threads_are_left_when_another_program_takes_the_core():
    choice = ThreadChoice(BOTH)
    looked(choice, 3.0, (500e-6, 500e-6), {False: 1000, True: 1900})
    found = looked(choice, 8.0, (500e-6, 500e-6), {False: 1000, True: 900}, start=3.0, tick=5700)

    assert NONE in found[:4]
    assert found[-20:] == [NONE] * 20


def test_a_run_that_goes_back_is_measured_from_there():
    choice = ThreadChoice(BOTH)
    assert choice.look(0.1, 1000, (500e-6, 500e-6)) == BOTH
    assert choice.look(0.2, 500, (500e-6, 500e-6)) == BOTH  # an interval without ticks is no rate
    assert choice.look(0.3, 690, (500e-6, 500e-6)) == NONE  # 1900 ticks a second, of 10000 in turn


@pytest.mark.parametrize("means", [(5e-6, 5e-6), (0.0, 0.0)])
def test_short_steps_are_never_in_threads(means):
    found = looked(ThreadChoice(BOTH), 5.0, means, {False: 100_000, True: 200_000})

    assert set(found) == {NONE}


def test_only_the_long_steps_are_in_threads():
    choice = ThreadChoice(frozenset({0, 1, 2}))
    found = looked(choice, 2.0, (500e-6, 5e-6, 300e-6), {False: 1000, True: 1900})

    assert set(found) == {NONE, frozenset({0, 2})}


def test_steps_that_become_long_are_found():
    choice = ThreadChoice(BOTH)
    looked(choice, 5.0, (5e-6, 5e-6), {False: 1000, True: 1900})
    found = looked(choice, 40.0, (500e-6, 500e-6), {False: 1000, True: 1900}, start=5.0, tick=5000)

    assert found[-1] == BOTH


def test_steps_without_another_beside_them_stay_in_turn_and_those_always_in_threads_too():
    alone = looked(ThreadChoice(NONE), 2.0, (500e-6,), {False: 1000, True: 1900})
    always = looked(ThreadChoice(BOTH, always=True), 2.0, (5e-6, 5e-6), {False: 1000, True: 100})

    assert (set(alone), set(always)) == ({NONE}, {BOTH})
