"""The line of a key is where a reader looks for it."""

import pytest

from flexsat.description.lines import line_of

TEXT = """\
name = "one" # the first
wheels = [
  { at = "bus", axes = ["+x"] },
  { at = "tip", axes = [[1, 0, 1],
                        [0, 1, 1]] },
]

[bus]
mass = "4 kg"
note = '''
[wheel]
inertia = 1
'''

[wheel]
inertia = [ 1,
  2,
]
controller.robust.mrp = 1
"""


@pytest.mark.parametrize(
    ("keys", "line"),
    [
        (["name"], 1),
        (["wheels"], 2),
        (["wheels", 0], 3),
        (["wheels", 0, "axes", 0], 3),
        (["wheels", 1], 4),
        (["bus"], 8),
        (["bus", "mass"], 9),
        (["wheel"], 15),  # not the text above that looks like it
        (["wheel", "inertia", 0], 16),
        (["wheel", "inertia", 1], 17),
        (["wheel", "controller", "robust", "mrp"], 19),
        (["nothing"], None),
        (["wheels", 7], None),
        (["name", "inner"], None),
    ],
)
def test_the_line_of_a_key(keys, line):
    assert line_of(TEXT, keys) == line
