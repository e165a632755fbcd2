"""States as named arrays and numbers: complete, restored in place, refused by name."""

from dataclasses import dataclass, field

import numpy as np
import pytest

from flexsat.runtime.named_state import NOT_SAVED, named_values, restore_values


@dataclass(frozen=True, slots=True)
class Plan:
    """Frozen part of a state."""

    count: int
    axis: np.ndarray
    start: float = 0.5


@dataclass
class State:
    """State with one of everything."""

    array: np.ndarray
    plan: Plan
    noise: np.random.Generator
    attitude: tuple[float, float] = (0.1, 5e-324)
    ready: bool = True
    work: np.ndarray = field(default_factory=lambda: np.zeros(4), metadata=NOT_SAVED)


def state(seed=1, kind=np.random.PCG64):
    return State(np.arange(6.0).reshape(2, 3).T, Plan(4, np.ones(3)), np.random.Generator(kind(seed)))


def equal(first, second):
    assert list(first) == list(second)
    return all(first[name].tobytes() == second[name].tobytes() for name in first)


def test_names_are_paths_of_fields_and_work_arrays_are_left_out():
    names = list(named_values(state()))

    assert names == [
        *("array", "plan.count", "plan.axis", "plan.start"),
        *("noise.state.state", "noise.state.inc", "noise.has_uint32", "noise.uinteger", "attitude", "ready"),
    ]
    assert named_values(None) == {}


@pytest.mark.parametrize(
    "kind", [np.random.PCG64, np.random.PCG64DXSM, np.random.MT19937, np.random.Philox, np.random.SFC64]
)
def test_restored_state_equals_the_saved_one(kind):
    live = state(kind=kind)
    live.noise.normal(size=7)
    live.noise.integers(10, dtype=np.int32)  # leaves half a word inside the generator
    saved = named_values(live)
    expected = live.noise.integers(10, dtype=np.int32, size=9).tolist()

    other = state(seed=5, kind=kind)
    other.array[:], other.attitude, other.ready = -1.0, (0.0, 0.0), False
    restore_values(other, saved)

    assert equal(named_values(other), saved)
    assert other.noise.integers(10, dtype=np.int32, size=9).tolist() == expected
    assert (other.plan.count, other.attitude, other.ready) == (4, (0.1, 5e-324), True)
    assert type(other.plan.count) is int
    assert other.array.flags.f_contiguous  # the layout is that of the live array: products round as before


def test_saved_values_are_copies():
    live = state()
    saved = named_values(live)
    before = {name: value.copy() for name, value in saved.items()}

    live.array += 1.0
    live.noise.normal()

    assert equal(saved, before)
    assert not equal(named_values(live), before)


def test_restoring_keeps_views_of_one_buffer_and_generators():
    buffer, live = np.zeros(6), state()
    live.array = buffer.reshape(3, 2)
    saved, generator, plan = named_values(live), live.noise, live.plan
    buffer[:] = -1.0
    live.plan = Plan(9, np.full(3, 2.0))
    kept = live.plan

    restore_values(live, saved)

    assert buffer.tolist() == [0.0] * 6
    assert live.noise is generator
    assert live.plan.count == plan.count
    assert live.plan.axis.tolist() == [1.0, 1.0, 1.0]
    assert kept.count == 9  # a frozen part is replaced: others may hold it
    assert kept.axis.tolist() == [2.0, 2.0, 2.0]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda s: s.pop("plan.count"), "the saved state lacks plan.count, which this component needs"),
        (lambda s: s.update(speed=np.ones(1)), "the saved state has speed, which this component does not know"),
        (
            lambda s: s.update(array=np.ones((2, 3))),
            r"array is float64 \(2, 3\) in the saved state, and float64 \(3, 2\) in this component",
        ),
        (lambda s: s.update(ready=np.array(1)), r"ready is int64 \(\) in the saved state, and bool \(\) in this"),
    ],
)
def test_values_that_do_not_fit_are_refused_and_nothing_is_written(change, message):
    saved = named_values(state())
    change(saved)
    live = state(seed=2)
    live.array[:] = 7.0
    before = named_values(live)

    with pytest.raises(ValueError, match=message):
        restore_values(live, saved)

    assert equal(named_values(live), before)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"array": np.array([object()])}, "state.array: a ndarray cannot be saved"),
        ({"attitude": [0.1, 0.2]}, "state.attitude: a list cannot be saved; a state is arrays and numbers"),
        ({"plan": Plan("many", np.ones(3))}, "state.plan.count: a str cannot be saved"),
        ({"ready": 2**70}, "state.ready: a int cannot be saved"),
    ],
)
def test_a_value_that_cannot_be_saved_is_named(change, message):
    live = state()
    for name, value in change.items():
        setattr(live, name, value)
    with pytest.raises(ValueError, match=message):
        named_values(live)
