"""Sums that the master computes have no FMU, but the calls of a slave."""

import numpy as np
import pytest

from lockstep import InputError
from lockstep.fmi.sums_slave import SumsSlave
from lockstep.system.sums import Sums


def references(*numbers):
    return np.array(numbers, np.uint32)


def test_terms_are_added_in_order_and_the_state_is_theirs(tmp_path):
    terms = [1e16, 1.0, 1.0, -1e16, *[1.0] * 8]  # pairs of them have another sum
    slave = SumsSlave(
        "sum", Sums(inputs={"a": tuple(f"a{i}" for i in range(12)), "b": tuple(f"b{i}" for i in range(12))})
    )
    given, seen = np.array(terms), np.zeros(3)
    set_a = slave.setter("Real", references(*range(2, 14)), given)
    get = slave.getter("Real", references(1, 0, 3), seen)
    assert slave.set_start({14: 2.5}, "Real") == set_a() == get() == 0
    expected = 0.0
    for term in terms:
        expected += term
    assert seen.tolist() == [2.5, expected, 1.0]
    slave.save_state(str(tmp_path))
    given[:] = 0.0
    set_a()
    get()
    assert seen.tolist() == [2.5, 0.0, 0.0]
    slave.restore_state(str(tmp_path))
    get()
    assert seen.tolist() == [2.5, expected, 1.0]


def test_sums_have_equally_many_terms():
    with pytest.raises(InputError, match="the same number"):
        Sums(inputs={"a": ("u",), "b": ("v", "w")})
