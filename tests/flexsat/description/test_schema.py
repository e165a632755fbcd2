"""The tables of keys: every key that a file may have, with what its class says; the page in docs/ is the latest."""

from pathlib import Path

import pytest

from flexsat.description.schema import schema, schema_markdown
from flexsat.description.spacecraft_file import KEYS, parse_spacecraft
from flexsat.errors import SpacecraftFileError

PAGE = Path(__file__).parents[3] / "docs" / "spacecraft_file.md"
LEAST = """
name = "one"
wheels = [{ at = "bus", axes = ["+x", "+y", "+z"] }]
gyros = [{ at = "bus", axes = ["+x"] }]
accelerometers = [{ at = "bus", axes = ["+z"] }]
"""


def test_the_page_is_written_from_the_classes():
    assert PAGE.read_text() == schema_markdown(), "write it: flexsat spacecraft --schema > docs/spacecraft_file.md"


def test_units_defaults_ranges_and_remarks():
    rows = {(table.title, row.key): row for table in schema() for row in table.rows}
    band = rows["[wheel]", "speed_band"]
    assert (band.unit, band.default, band.range) == ("rad/s, deg/s, rpm, deg/h", "2.617994", "> 0 and <= 1e+06")
    assert band.meaning == "either side of the nominal speed; P: 50 rpm wide in all"
    assert rows["[sites] NAME = { ... }", "on_bus"].unit == "m, mm, um"
    assert rows["[modes]", "design_by"].range == "frequency or coupling"
    assert rows["[plate]", "damping_frequencies"].range == "2 numbers, each > 0"
    assert rows["[slew]", "rotation"].default == "[0.008726646, 0, 0]"
    assert rows["[[appendages]]", "name"].default == ""


def test_each_table_of_a_file_is_there():
    titles = " ".join(table.title for table in schema())
    keys = " ".join(row.key for table in schema() for row in table.rows)
    missing = [key for key in KEYS if f"[{key}" not in titles and key not in keys and key != "wheel_kinds"]
    assert missing == []


@pytest.mark.parametrize(
    "table", ["bus", "wheel", "plate", "modes", "noise", "sensor_errors", "rates", "slew", "speeds"]
)
def test_a_refusal_names_the_keys_of_the_page(table):
    with pytest.raises(SpacecraftFileError) as refusal:
        parse_spacecraft(f"{LEAST}[{table}]\nno_such = 1\n", "one.toml")
    known = str(refusal.value).partition("there are ")[2].partition(";")[0].split(", ")
    rows = next(one for one in schema() if one.title == f"[{table}]").rows
    assert sorted(known) == sorted(row.key for row in rows)
