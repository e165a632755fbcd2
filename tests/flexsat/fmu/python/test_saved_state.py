"""The bytes of a saved state: exact, documented, refused in one line where they do not fit."""

import json

import numpy as np
import pytest

from flexsat.fmu.python.saved_state import pack_state, prefixed, section, unpack_state


def values():
    return {
        "life_cycle.phase": np.array(3),
        "ports.string": np.frombuffer("toy\0Größe\0".encode(), dtype=np.uint8),
        "state.matrix": np.arange(6.0).reshape(2, 3),
        "state.tiny": np.array([5e-324, -0.0, np.inf, np.nan]),
        "state.empty": np.empty((0, 3)),
        "state.flag": np.array(True),
        "state.noise.state.state": np.array([2**64 - 1, 7], dtype=np.uint64),
    }


def test_values_come_back_bitwise():
    packed = pack_state("{guid}", values())
    back = unpack_state("{guid}", packed)

    assert list(back) == list(values())
    for name, array in values().items():
        assert back[name].tobytes() == array.tobytes()
        assert (back[name].dtype, back[name].shape) == (array.dtype, array.shape)
        assert back[name].flags.writeable
    assert pack_state("{guid}", back) == packed


def test_layout_is_the_documented_one():
    line, _, memory = pack_state("{guid}", {"a": np.array([1.0, 2.0]), "n": np.array(5, dtype=np.int32)}).partition(
        b"\n"
    )

    assert json.loads(line) == {"component": "{guid}", "layout": 1, "values": {"a": ["<f8", [2]], "n": ["<i4", []]}}
    assert memory == np.array([1.0, 2.0]).tobytes() + (5).to_bytes(4, "little")


def test_sections_of_names():
    assert list(section(values(), "state")) == ["matrix", "tiny", "empty", "flag", "noise.state.state"]
    assert list(prefixed({"phase": np.array(3)}, "life_cycle")) == ["life_cycle.phase"]


@pytest.mark.parametrize("damage", [slice(0, -1), slice(0, 0), slice(1, None), slice(0, 1), slice(9, -9)])
def test_damaged_bytes_are_refused(damage):
    with pytest.raises(ValueError, match=r"^these bytes are not a saved state of this component: .*$"):
        unpack_state("{guid}", pack_state("{guid}", values())[damage])


@pytest.mark.parametrize(
    ("head", "message"),
    [
        ({"component": "{other}"}, r"the saved state belongs to \{other\}, this is \{guid\}"),
        ({"layout": 2}, "the saved state has layout 2; this component reads layout 1"),
        ({"values": {"a": ["O", [1]]}}, "a has the type 'O', which is no number"),
        ({"values": {"a": ["<f8", [2]]}}, "a has 8 of its 16 bytes"),
        ({"values": {}}, "8 bytes follow the last array"),
        ({"values": {"a": 5}}, "not a saved state"),
    ],
)
def test_content_that_does_not_fit_is_refused(head, message):
    whole = {"component": "{guid}", "layout": 1, "values": {"a": ["<f8", [1]]}} | head
    with pytest.raises(ValueError, match=message):
        unpack_state("{guid}", json.dumps(whole).encode() + b"\n" + np.ones(1).tobytes())
