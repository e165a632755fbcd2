"""Saving state: exact, complete, restored in place, refused by place."""

from collections import deque
from dataclasses import dataclass, field

import numpy as np
import pytest

from flexsat.fmu.python.saved_state import decode, encode, restored


@dataclass(frozen=True, slots=True)
class Inner:
    """Frozen part of a state."""

    count: int
    past: tuple[float, ...]


@dataclass
class Outer:
    """State with one of everything."""

    array: np.ndarray
    inner: Inner
    generator: np.random.Generator
    queue: deque = field(default_factory=lambda: deque([np.zeros(2), 1.5], maxlen=3))
    table: dict = field(default_factory=lambda: {"a": [None, True, float("inf"), -0.0], "b": np.float32(0.1)})
    words: np.ndarray = field(default_factory=lambda: np.array(["x", "yz"]))
    empty: np.ndarray = field(default_factory=lambda: np.empty((0, 3)))


def outer(seed=1, kind=np.random.PCG64):
    return Outer(np.arange(6.0).reshape(2, 3).T, Inner(2**70, (0.1, 5e-324)), np.random.Generator(kind(seed)))


@pytest.mark.parametrize(
    "kind", [np.random.PCG64, np.random.PCG64DXSM, np.random.MT19937, np.random.Philox, np.random.SFC64]
)
def test_a_state_comes_back_exactly(kind):
    state = outer(kind=kind)
    state.generator.normal(size=7)
    state.generator.integers(10, dtype=np.int32)  # leaves half a word inside the generator

    back = decode(encode(state))

    assert encode(back) == encode(state)
    assert back.inner == state.inner
    assert back.queue.maxlen == 3
    assert back.array.flags.f_contiguous  # products round as before
    assert not back.array.flags.c_contiguous
    assert type(back.table["b"]) is np.float32
    assert (
        back.generator.integers(10, dtype=np.int32, size=9).tolist()
        == state.generator.integers(10, dtype=np.int32, size=9).tolist()
    )


def test_saved_bytes_do_not_follow_the_state():
    state = outer()
    before = encode(state)

    state.array += 1.0
    state.generator.normal()

    assert encode(decode(before)) == before != encode(state)


def test_restoring_keeps_views_of_one_buffer_and_shared_generators():
    buffer = np.arange(5.0)
    generator = np.random.default_rng(3)
    live = {"low": buffer[:3], "high": buffer[3:], "a": generator, "b": generator, "inner": Inner(1, (1.0,))}
    saved = encode(live)
    expected = generator.normal()
    generator.normal(size=4)
    buffer[:] = -1.0
    live["inner"] = Inner(9, (1.0,))

    live = restored(live, decode(saved))

    assert buffer.tolist() == [0.0, 1.0, 2.0, 3.0, 4.0]
    assert live["a"] is live["b"] is generator
    assert generator.normal() == expected
    assert live["inner"] == Inner(1, (1.0,))


def test_restoring_a_frozen_part_makes_a_new_one():
    live, kept = outer(), outer().inner
    live.inner = kept
    saved = outer()
    object.__setattr__(saved.inner, "count", 5)

    restored(live, saved)

    assert live.inner.count == 5
    assert kept.count == 2**70


@pytest.mark.parametrize(
    ("value", "place"),
    [
        ({"a": [1, object()]}, r"state\['a'\]\[1\]: a object cannot be saved"),
        ({1: 2}, "state: a dict cannot be saved"),
        (np.array([object()]), "state: a ndarray cannot be saved"),
        (Inner(1, (lambda: 0,)), r"state.past\[0\]: a function cannot be saved"),
    ],
)
def test_what_cannot_be_saved_is_named_by_place(value, place):
    with pytest.raises(ValueError, match=place):
        encode(value)


@pytest.mark.parametrize("damage", [slice(0, -1), slice(0, 0), slice(1, None), slice(0, 1), slice(9, -9)])
def test_damaged_bytes_are_refused(damage):
    with pytest.raises(ValueError, match="not a saved state"):
        decode(encode(outer())[damage])


def test_only_dataclasses_are_made():
    with pytest.raises(ValueError, match="not a dataclass"):
        decode(b'{"dataclass":["subprocess","Popen",{}]}\n')
