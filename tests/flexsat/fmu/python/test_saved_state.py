"""The bytes of a saved state: exact, documented, refused in one line where they do not fit."""

import json

import numpy as np
import pytest

from flexsat.fmu.python.saved_state import DIGEST, digest, pack_state, prefixed, section, unpack_state


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
    packed = pack_state("{guid}", {"a": np.array([1.0, 2.0]), "n": np.array(5, dtype=np.int32)})
    line, _, memory = packed[:-DIGEST].partition(b"\n")

    assert packed[-DIGEST:] == digest(packed[:-DIGEST])
    assert json.loads(line) == {"component": "{guid}", "layout": 2, "values": {"a": ["<f8", [2]], "n": ["<i4", []]}}
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
        ({"layout": 1}, "the saved state has layout 1; this component reads layout 2"),
        ({"values": {"a": ["O", [1]]}}, r"a has the type 'O'; there are <f8, <i4, <i8, <u4, <u8, \|b1, \|u1"),
        ({"values": {"a": ["<f8,<f8", [1]]}}, "a has the type '<f8,<f8'; there are"),
        ({"values": {"a": ["<f8", [-1]]}}, r"a has the shape \[-1\]"),
        ({"values": {"a": ["<f8", [True]]}}, r"a has the shape \[True\]"),
        ({"values": {"a": ["<f8", [2**62, 4]]}}, "a has 8 of its 147573952589676412928 bytes"),
        ({"values": {"a": ["<f8", [2**70]]}}, "a has 8 of its"),
        ({"values": {"a": ["<f8", [2]]}}, "a has 8 of its 16 bytes"),
        ({"values": {}}, "8 bytes follow the last array"),
        ({"values": {"a": 5}}, "not a saved state"),
    ],
)
def test_content_that_does_not_fit_is_refused(head, message):
    whole = {"component": "{guid}", "layout": 2, "values": {"a": ["<f8", [1]]}} | head
    content = json.dumps(whole).encode() + b"\n" + np.ones(1).tobytes()
    with pytest.raises(ValueError, match=message):
        unpack_state("{guid}", content + digest(content))


def test_every_flipped_bit_and_every_shorter_text_is_refused():
    packed = pack_state("{guid}", values())
    assert unpack_state("{guid}", packed)
    for k in range(8 * len(packed)):
        damaged = bytearray(packed)
        damaged[k // 8] ^= 1 << k % 8
        with pytest.raises(ValueError, match=r"^these bytes are not a saved state of this component: cut short, or"):
            unpack_state("{guid}", bytes(damaged))
    for length in range(len(packed)):
        with pytest.raises(ValueError, match=r"^these bytes are not a saved state of this component: cut short, or"):
            unpack_state("{guid}", packed[:length])


def test_deeply_nested_first_line_is_refused():
    content = b"[" * 100_000 + b"\n"
    with pytest.raises(ValueError, match="not a saved state"):
        unpack_state("{guid}", content + digest(content))


def test_array_of_another_type_is_not_packed():
    with pytest.raises(ValueError, match=r"^state.x has the type '<f4'; there are "):
        pack_state("{guid}", {"state.x": np.ones(2, np.float32)})
