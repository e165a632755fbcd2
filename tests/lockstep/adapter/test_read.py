"""Reading of adapter files: every key, the former keys, and what is refused in one line with key, value and remedy."""

import pytest

from lockstep.adapter.read import read_adapter
from lockstep.errors import InputError

INPUT = '[[input]]\nport = "rate"\nvariable = "w[*]"\n'


@pytest.fixture
def read(tmp_path):
    def read(text):
        path = tmp_path / "vendor.toml"
        path.write_text(text)
        return read_adapter(path)

    return read


def test_every_key_is_read(read):
    adapter = read(
        'step = 0.01\nkind = "continuous"\nignore = ["x*"]\n'
        '[[input]]\nport = "a"\nvariable = "b[*]"\nindex_base = 0\nunit = "deg/s"\nscale = 2\noffset = [1, 2, 3]\n'
        'sign = [1, -1, 1]\norder = [3, 1, 2]\nframe = [[0, 1, 0], [0, 0, 1], [1, 0, 0]]\nhold = "f"\n'
        '[[output]]\nport = "q"\nvariable = ["s", "x", "y", "z"]\nattitude = "quaternion"\nscalar = "first"\n'
        'direction = "inertial-from-body"\n'
        '[constants]\nmode = 2\n[parameters]\nkp = [0.1, 0.2]\n[substitutes]\n"e.rate" = 0.0\n'
    )

    rate, attitude = adapter.entries
    assert (adapter.step, adapter.kind, adapter.ignore) == (10_000_000, "continuous", ("x*",))
    assert (rate.direction, rate.index_base, rate.unit, rate.scale, rate.hold) == ("input", 0, "deg/s", (2.0,), "f")
    assert (rate.order, rate.sign, rate.offset) == ((3, 1, 2), (1.0, -1.0, 1.0), (1.0, 2.0, 3.0))
    assert attitude.variables == ("s", "x", "y", "z")
    assert (attitude.scalar, attitude.rotation) == ("first", "inertial-from-body")
    assert adapter.constants == {"mode": 2}
    assert adapter.parameters == {"kp[1]": 0.1, "kp[2]": 0.2}
    assert adapter.substitutes == {"e.rate": 0.0}


def test_what_an_entry_leaves_out_is_as_the_ports_are(read):
    """Numbered from 1, unchanged, and an attitude is scalar-last, body from inertial."""
    rate, attitude = read(
        '[[input]]\nport = "a"\nvariable = "b[*]"\n[[input]]\nport = "q"\nvariable = "p"\nattitude = "quaternion"\n'
    ).entries

    assert (rate.index_base, rate.scale, rate.offset, rate.sign) == (1, (1.0,), (0.0,), (1.0,))
    assert (rate.unit, rate.order, rate.frame, rate.hold, rate.true, rate.false) == (None, None, None, None, 1.0, 0.0)
    assert (attitude.scalar, attitude.rotation) == ("last", "body-from-inertial")
    assert (attitude.body_frame, attitude.inertial_frame) == (None, None)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("step = ", "is no TOML file"),
        ("steps = 0.01", "vendor.toml: steps = 0.01: no such key; there are step, kind"),
        ('step = "10 ms"', "step = '10 ms' must be a number of seconds, for example 0.01"),
        ("step = 0", "step = 0 must be in (0, 10] s"),
        ("step = 100.0", "step = 100.0 must be in (0, 10] s"),
        ('kind = "analog"', "kind = 'analog' must be sampled or continuous"),
        ("ignore = 3", "ignore = 3 must be a list of texts"),
        ('[input]\nport = "a"', "write [[input]]"),
        ('[[input]]\nport = "a"', "vendor.toml: input 1: variable is missing; every [[input]] needs port and variable"),
        (INPUT + 'units = "deg/s"', "input 1 (w[*]): units = 'deg/s': no such key"),
        (INPUT + 'unit = "degrees/s"', "unit = 'degrees/s' is unknown; there are 1, %, rad"),
        (INPUT + "scale = 0", "scale = 0 must not be 0"),
        (INPUT + "scale = true", "scale = True must be a finite number"),
        (INPUT + "offset = nan", "offset = nan must be a finite number"),
        (INPUT + "sign = 2", "sign = 2 must be 1 or -1; for other factors there is scale"),
        (INPUT + "order = [1, 1, 3]", "order = [1, 1, 3] must hold each of 1 to the number of elements once"),
        (INPUT + "index_base = -1", "index_base = -1 must be a whole number from 0"),
        (INPUT + 'scalar = "first"', "scalar = 'first' needs attitude"),
        (INPUT + 'attitude = "euler"', "attitude = 'euler' must be quaternion or mrp"),
        (INPUT + 'attitude = "quaternion"\nscalar = "middle"', "scalar = 'middle' must be first or last"),
        (INPUT + 'attitude = "mrp"\nscalar = "first"', "an MRP has no scalar; remove it"),
        (INPUT + 'attitude = "mrp"\ndirection = "up"', "direction = 'up' must be body-from-inertial or inert"),
        (INPUT + "frame = [[1, 0], [0, 1]]", "must be three rows of three numbers"),
        (INPUT + "frame = [[1, 0, 0], [0, 1, 0], [0, 0, 2]]", "its rows must be orthogonal and of length 1"),
        (INPUT + "frame = [[1, 0, 0], [0, 1, 0], [0, 0, -1]]", "its determinant is -1: it mirrors"),
        (INPUT + "true = 0", "true = 0 and false = 0 must differ"),
        ('[[output]]\nport = "a"\nvariable = "b"\nhold = "f"', "hold = 'f' must name a Boolean interface port, and"),
        (INPUT + 'attitude = "mrp"\nunit = "rad"', "unit = 'rad': an attitude has no unit; remove it"),
        ("[constants]\na.b = 2", "quote names with dots"),
        ('[parameters]\nkp = [0.1, 0.2]\n"kp[2]" = 0.3', "parameters: kp[2] has two values; remove one of them"),
    ],
)
def test_bad_input_is_refused_in_one_line(read, text, message):
    with pytest.raises(InputError) as caught:
        read(text)

    assert message in str(caught.value)
    assert "vendor.toml" in str(caught.value)
    assert "\n" not in str(caught.value)


FORMER = '[[input]]\nours = "rate"\ntheirs = "w[*]"\n[[output]]\nours = "torque"\ntheirs = "t"\n'


def test_former_keys_are_read_with_one_warning_line(read, capsys):
    former = read(FORMER).entries

    assert [(entry.ports, entry.variables) for entry in former] == [(("rate",), ("w[*]",)), (("torque",), ("t",))]
    assert capsys.readouterr().err == (
        "vendor.toml: the keys ours and theirs are now named port and variable; rename them\n"
    )
    assert read(FORMER.replace("ours", "port").replace("theirs", "variable")).entries == former
    assert capsys.readouterr().err == ""


def test_former_and_present_key_together_are_refused(read):
    with pytest.raises(InputError, match=r"input 1: has ours and port, which are one key; remove ours"):
        read(INPUT + 'ours = "rate"')
