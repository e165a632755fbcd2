"""The names and values of several branches of one checkpoint."""

import pytest

from flexbench.engine.branches import varied
from lockstep import InputError


def test_all_combinations_are_named_by_their_values():
    runs = varied([["a.gain", "1", "2.5", "1"], ["a.offset[2]", "0,1", "-1e-3"]], {"b.gain": "3"})
    assert runs == {
        "a.gain=1,a.offset.2=0_1": {"b.gain": "3", "a.gain": "1", "a.offset[2]": "0,1"},
        "a.gain=1,a.offset.2=-1e-3": {"b.gain": "3", "a.gain": "1", "a.offset[2]": "-1e-3"},
        "a.gain=2.5,a.offset.2=0_1": {"b.gain": "3", "a.gain": "2.5", "a.offset[2]": "0,1"},
        "a.gain=2.5,a.offset.2=-1e-3": {"b.gain": "3", "a.gain": "2.5", "a.offset[2]": "-1e-3"},
    }


@pytest.mark.parametrize(
    ("texts", "message"),
    [
        ([["a.gain"]], r"--vary a\.gain: write COMPONENT\.PARAMETER VALUE VALUE"),
        ([["a.gain=1", "2"]], r"--vary a\.gain=1 2: write COMPONENT\.PARAMETER VALUE VALUE"),
        ([["a.gain", "1"], ["a.gain", "2"]], r"--vary a\.gain: is given twice"),
        ([["b.gain", "1"]], r"--vary b\.gain: is given twice"),
        ([["a.x", *map(str, range(40))], ["a.y", *map(str, range(40))]], "--vary: more than 1000 combinations"),
    ],
)
def test_what_cannot_be_varied_is_refused(texts, message):
    with pytest.raises(InputError, match=message):
        varied(texts, {"b.gain": "3"})
