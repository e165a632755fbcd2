"""Records of runs that have not the shape of one are refused by file, name, value and remedy."""

import pytest

from lockstep import InputError
from lockstep.results.read_run_record import read_run_record

GOOD = """status = "completed"
simulated_time = 1.0
overrides = {}
[system]
name = "s"
path = ""
sha256 = ""
[[component]]
name = "plant"
[component.parameters]
seed = 1
[[latency]]
from = "a"
to = "b"
delay = 1
"""


def test_a_record_is_returned_as_tables_and_text(tmp_path):
    (tmp_path / "run.toml").write_text(GOOD)
    record, text = read_run_record(tmp_path)
    assert (record["component"][0]["parameters"], text) == ({"seed": 1}, GOOD)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('status = "completed"', "status = 5", "status = 5 must be a text"),
        ("simulated_time = 1.0", 'simulated_time = "1"', "simulated_time = '1' must be a number"),
        ("simulated_time = 1.0", "simulated_time = true", "simulated_time = True must be a number"),
        ("overrides = {}", "overrides = []", r"overrides = \[\] must be a table"),
        ('path = ""', "path = 1", "system.path = 1 must be a text"),
        ('name = "plant"', "", r"component\[1\].name is missing"),
        ("[[component]]", "[component]", r"component = {'name': 'plant', .* must be a list"),
        ("[component.parameters]\nseed = 1", "parameters = 3", r"component\[1\].parameters = 3 must be a table"),
        ("delay = 1", "delay = 1.5", r"latency\[1\].delay = 1.5 must be a whole number"),
        (GOOD, "", "component is missing"),
        (GOOD, "x = " + "[" * 100_000, "is nested too deeply to be read"),
        (GOOD, "x = [np.float64(0.0)]", "is no TOML file"),
    ],
)
def test_another_shape_is_refused_by_name(tmp_path, old, new, message):
    assert old in GOOD
    (tmp_path / "run.toml").write_text(GOOD.replace(old, new))
    with pytest.raises(InputError, match=rf"run\.toml: {message}.*; run again, or restore the file$"):
        read_run_record(tmp_path)
