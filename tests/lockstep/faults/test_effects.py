"""Arithmetic of faults on values that no toy FMU has."""

import numpy as np
import pytest

from lockstep.faults import effects


@pytest.mark.parametrize("kind", [np.int32, np.int64, np.uint64])
def test_integers_are_rounded_within_the_range_of_their_type(kind):
    info = np.iinfo(kind)
    values = np.array([0, 7, info.max], kind)
    limits = effects.limits_of([int(info.min)] * 3, [int(info.max)] * 3)

    added = effects.Change(effects.bias(np.array([0.6, 0.4, 0.0])), limits).act(0, values)
    assert (added.dtype, added[:2].tolist()) == (kind, [1, 7])
    scaled = effects.Change(effects.scale(np.array([1.0, 1e30, 2.0])), limits).act(0, values).tolist()
    assert scaled[0] == 0
    assert all(0 <= info.max - value < 4096 for value in scaled[1:])  # the last double that fits
    assert effects.Change(effects.bias(np.full(3, -1e30)), limits).act(0, values).tolist() == [info.min] * 3


def test_integers_that_a_fault_does_not_change_keep_every_digit():
    values = np.array([2**53 + 1, -(2**60) - 1, 5], np.int64)
    limits = effects.limits_of([-(2**63)] * 3, [2**63 - 1] * 3)
    for function in (effects.scale(np.ones(3)), effects.bias(np.zeros(3)), effects.bias(np.array([0.0, 0.0, 2.0]))):
        found = effects.Change(function, limits).act(0, values).tolist()
        assert found[:2] == [2**53 + 1, -(2**60) - 1]
    assert found[2] == 7


def test_texts_are_held_and_delayed():
    first, second, third = (np.array([text], np.object_) for text in ("a", "b", "c"))
    stuck, delay = effects.Stuck(1), effects.Delay(2)
    for tick, values in enumerate((first, second, third)):
        stuck.observe(tick, values)
        delay.observe(tick, values)

    assert stuck.act(2, third).tolist() == ["a"]
    assert delay.act(2, third).tolist() == ["a"]


def test_delay_keeps_only_the_history_that_it_can_need():
    delay = effects.Delay(3)
    for tick in range(0, 100, 2):
        delay.observe(tick, np.array([float(tick)]))
        assert delay.act(tick, np.zeros(1))[0] == max(0, tick - 4)  # transfers are 2 ticks apart

    assert len(delay.saved()) == 3


def test_draws_of_different_ticks_and_names_are_independent():
    ticks = np.array([effects.drawn_from(1, ["a"])(tick).standard_normal() for tick in range(2000)])
    other = np.array([effects.drawn_from(1, ["b"])(tick).standard_normal() for tick in range(2000)])
    bound = 4.0 / np.sqrt(2000)  # four standard deviations of each of these numbers

    assert abs(ticks.mean()) < bound
    assert abs(ticks.std() - 1.0) < bound
    assert abs(np.corrcoef(ticks[1:], ticks[:-1])[0, 1]) < bound
    assert abs(np.corrcoef(ticks, other)[0, 1]) < bound
    assert effects.drawn_from(1, ["a"])(1999).standard_normal() == ticks[-1]
