"""Corrections found by check-adapter are written into the file; what else is in it stays."""

import pytest

from flexbench.adapt.corrected_file import corrected
from flexbench.adapt.verdict import Correction
from lockstep.adapter.read import read_adapter
from lockstep.errors import InputError

TEXT = """\
# of the vendor
step = 0.01
[[input]]
port = "gyro.rate[1..3]"
variable = "w[*]"

[[ input ]]
port = "star_tracker.mrp"
variable = "q[*]"
attitude = "quaternion"
direction = "body-from-inertial"  # UNDECIDED
scalar = "first"

[[output]]
port = "wheel.torque"
variable = "tau[*]"
sign = 1
[constants]
direction = 2
"""


def change(folder, number, key, remedy, text=TEXT):
    """Return a change of an entry of an adapter file."""
    path = folder / "input 3 (x).toml"
    path.write_text(text, encoding="utf-8")
    return Correction(number=number, key=key, error="wrong", remedy=remedy, entry=read_adapter(path).entries[number])


def test_a_key_is_replaced_or_added_in_its_entry_alone(tmp_path):
    changes = [
        change(tmp_path, 1, "direction", 'direction = "inertial-from-body"'),
        change(tmp_path, 1, "scalar", 'scalar = "last"'),
        change(tmp_path, 0, "unit", 'unit = "deg/s"'),
        change(tmp_path, 2, "sign", "sign = [-1, 1, -1, 1]"),
    ]
    text = corrected(TEXT, changes, "vendor.toml")
    path = tmp_path / "corrected.toml"
    path.write_text(text, encoding="utf-8")
    rate, attitude, torque = read_adapter(path).entries

    assert (rate.unit, attitude.rotation, attitude.scalar) == ("deg/s", "inertial-from-body", "last")
    assert torque.sign == (-1.0, 1.0, -1.0, 1.0)
    kept = [line for line in text.splitlines() if not line.endswith("# by check-adapter")]
    replaced = {'direction = "body-from-inertial"  # UNDECIDED', 'scalar = "first"', "sign = 1"}
    assert kept == [line for line in TEXT.splitlines() if line not in replaced]


@pytest.mark.parametrize(("old", "new"), [("sign = 1\n", "sign = [\n1, 1,\n]\n"), ("[[output]]", "output = [{}]\n[x]")])
def test_a_file_in_another_form_is_refused_with_the_line_to_write(tmp_path, old, new):
    with pytest.raises(InputError, match=r"vendor\.toml: wrong: is not written as `sign = \.\.\.` .*; write sign = -1"):
        corrected(TEXT.replace(old, new), [change(tmp_path, 2, "sign", "sign = -1")], "vendor.toml")
