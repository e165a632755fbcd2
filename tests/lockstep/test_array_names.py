"""Names of array elements: parsed with any number of dimensions, and ordered by number, not by letter."""

import random

import pytest

from lockstep.array_names import (
    array_of,
    by_array,
    element_name,
    elements_of,
    grid_axes,
    in_order,
    name_and_arrays,
    range_names,
    split_element,
    split_range,
    stem,
)
from lockstep.errors import compact

VECTOR = [f"p[{k}]" for k in range(1, 13)]
MATRIX = [f"a[{row},{column}]" for row in (1, 2) for column in range(1, 11)]


@pytest.mark.parametrize(
    ("name", "array", "index"),
    [
        ("p", "p", ()),
        ("p[2]", "p", (2,)),
        ("gyro.rate[10]", "gyro.rate", (10,)),
        ("a[1,10]", "a", (1, 10)),
        ("wheel[2].speed", "wheel[2].speed", ()),
        ("wheel[2].speed[3]", "wheel[2].speed", (3,)),
        ("p[1..3]", "p[1..3]", ()),
        ("p[]", "p[]", ()),
        ("[1]", "[1]", ()),
    ],
)
def test_name_is_split_into_array_and_index(name, array, index):
    assert split_element(name) == (array, index)
    assert array_of(name) == array
    assert element_name(array, index) == name


@pytest.mark.parametrize("names", [VECTOR, MATRIX])
def test_elements_are_found_in_numeric_row_major_order(names):
    shuffled = random.Random(1).sample([*names, "q[1]", "p", "a", "a[1].b"], len(names) + 4)

    assert elements_of(array_of(names[0]), shuffled) == names


def test_elements_count_from_any_base():
    assert elements_of("p", ["p[10]", "p[0]", "p[2]"]) == ["p[0]", "p[2]", "p[10]"]


def test_elements_are_sorted_among_their_own_positions():
    assert in_order(["p[10]", "x", "q[2]", "p[2]", "q[1]", "p[1]"]) == ["p[1]", "x", "q[1]", "p[2]", "q[2]", "p[10]"]
    assert in_order(["p[2]", "p[1]", "p[2]"]) == ["p[1]", "p[2]", "p[2]"]
    interleaved = ["p[1]", "q[1]", "p[2]", "q[2]"]
    assert in_order(interleaved) == interleaved


def test_names_are_grouped_by_array_in_order_of_appearance():
    groups = by_array(["b[2]", "x", "a[2,10]", "b[1]", "a[2,2]"])

    assert list(groups) == ["b", "x", "a"]
    assert list(groups["b"].values()) == ["b[1]", "b[2]"]
    assert groups["x"] == {}
    assert list(groups["a"]) == [(2, 2), (2, 10)]


def test_range_is_split_and_written_out():
    assert split_range("p[9..11]") == ("p", 9, 11)
    assert split_range("p[9]") is None
    assert range_names("p", 9, 11) == ["p[9]", "p[10]", "p[11]"]
    assert range_names("p", 2, 1) == []
    assert stem("p[9..11]") == stem("p") == "p"


def test_indices_that_fill_a_grid_have_a_shape():
    assert grid_axes(split_element(name)[1] for name in MATRIX) == ((1, 2), tuple(range(1, 11)))
    assert grid_axes([(0,), (2,)]) == ((0, 2),)
    assert grid_axes([(1, 1), (1, 2), (2, 1)]) is None
    assert grid_axes([(1,), (1, 1)]) is None
    assert grid_axes([]) is None


def test_name_is_followed_by_the_arrays_that_hold_it():
    assert list(name_and_arrays("a[1][2,3]")) == ["a[1][2,3]", "a[1]", "a"]
    assert list(name_and_arrays("a[1].b")) == ["a[1].b"]


def test_folded_names_are_in_order():
    assert compact(["p[10]", "x", "p[9]", "p[11]"]) == "p[9], x, p[10..11]"
