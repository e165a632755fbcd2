"""Times, names in messages, the text of run.toml, events and progress lines."""

import io
import json
import tomllib
from fractions import Fraction

import pytest
from rich.console import Console

from lockstep import InputError
from lockstep.cli import progress
from lockstep.cli.progress import show_progress
from lockstep.errors import compact, siblings, suggestion
from lockstep.results.run_record import Events, to_toml
from lockstep.system.clock import (
    common_divisor,
    common_multiple,
    nanoseconds,
    read_nanoseconds,
    seconds,
    seconds_text,
    stored_nanoseconds,
    stored_seconds,
)


@pytest.mark.parametrize(
    ("given", "time"),
    [("0.001", 10**6), (0.1, 10**8), ("1e-9", 1), (300, 3 * 10**11), (" 2.5 ", 25 * 10**8), (0.3, 3 * 10**8)],
)
def test_seconds_become_whole_nanoseconds_exactly(given, time):
    assert nanoseconds(given, "t") == time
    assert nanoseconds(seconds_text(time), "t") == time


@pytest.mark.parametrize("given", ["1e-10", "0.0000000015", "inf", "nan", "", "1 ms", float("inf")])
def test_other_times_are_refused_by_name(given):
    with pytest.raises(InputError, match=r"^t: "):
        nanoseconds(given, "t")


@pytest.mark.parametrize(
    ("given", "seconds_exact"),
    [
        ("1/60", Fraction(1, 60)),
        (" -2/3 ", Fraction(-2, 3)),
        (1 / 60, Fraction(1, 60)),
        ("0.0166666666667", Fraction(1, 60)),  # rounded
        ("0.01666666666666", Fraction(1, 60)),  # cut off
        (1001 / 30000, Fraction(1001, 30000)),
        (100 / 3, Fraction(100, 3)),
        ("2.2675736961451248e-05", Fraction(1, 44100)),
        ("4/8", Fraction(1, 2)),
        ("0.016666667", Fraction(16_666_667, 10**9)),  # whole nanoseconds are what is written
    ],
)
def test_fractions_of_a_second_are_exact_also_from_their_rounded_value(given, seconds_exact):
    time = nanoseconds(given, "t")
    assert time == seconds_exact * 10**9
    assert nanoseconds(seconds_text(time), "t") == nanoseconds(stored_seconds(time), "t") == time
    assert seconds(time) == float(seconds_exact)
    assert type(read_nanoseconds(stored_nanoseconds(time), "t")) is type(time)
    assert read_nanoseconds(stored_nanoseconds(time), "t") == time


@pytest.mark.parametrize(
    "given", ["1/0", "0.01666666667", "1.23456789e-12", "1e-13", "0.123456789012", "1.5/3", "1//2"]
)
def test_other_fractions_are_refused_with_the_remedy(given):
    with pytest.raises(InputError, match=r"^t: .*1/60$"):
        nanoseconds(given, "t")


def test_a_stored_time_is_a_number_only_where_that_gives_it_back():
    assert stored_seconds(nanoseconds("1/60", "t")) == 1 / 60
    assert stored_seconds(nanoseconds("1/300007", "t")) == "1/300007"


def test_common_divisor_and_multiple_of_times():
    sixtieth = nanoseconds("1/60", "t")
    assert common_divisor(sixtieth, 10**7) == Fraction(10**9, 300)
    assert common_multiple(sixtieth, 10**7) == 5 * 10**7
    assert (common_divisor(6, 4), common_multiple(6, 4)) == (2, 12)


def test_a_time_is_the_nearest_double():
    # a sum of steps would be off after a few: 0.1 + 0.1 + 0.1 != 0.3
    assert [seconds(k * 100_000_000) for k in range(12)] == [k / 10 for k in range(12)]
    assert seconds(299_999_000_000) == 299.999


def test_names_of_arrays_are_folded():
    assert compact(["a[1]", "a[2]", "a[3]", "b", "a[5]", "c[7]"]) == "a[1..3], b, a[5], c[7]"
    assert compact([]) == "none"
    assert compact([f"x{k}y" for k in range(15)]).endswith("x11y, and 3 more")


def test_only_a_near_name_is_suggested():
    assert suggestion("plnat", ["plant", "sensors"]) == "; did you mean plant?"
    assert suggestion("zzz", ["plant", "sensors"]) == ""
    assert suggestion("a[4]", ["a[1]", "a[2]"]) == ""  # the index is wrong, not the name
    assert siblings("a[4]", ["a[1]", "a[2]", "b"]) == ["a[1]", "a[2]"]


def test_the_run_record_is_toml():
    content = {
        "text": 'quote " backslash \\ tab \t line \n ä \x7f \x9b31m \u202e \U000e0001',
        "number": 1e-06,
        "flag": True,
        "list": ["a", 1.5],
        "empty": {},
        "table": {"u[2]": 7.0, "a.b": 1},
        "rows": [{"name": "x", "inner": {"k": 1}}, {"name": "y", "inner": {}}],
    }
    text = to_toml(content)
    assert tomllib.loads(text) == content
    assert text.replace("\n", "").isprintable()  # no control character reaches a terminal


def test_messages_of_an_fmu_keep_their_control_characters_as_escapes(tmp_path):
    events = Events()
    events.open(tmp_path)
    message = "\x1b[2J\x9b31m\x7f ä\u202e\U000e0001"
    events.log("c", 1, "category", message)
    events.close()
    text = (tmp_path / "events.jsonl").read_text(encoding="utf-8")

    assert json.loads(text)["message"] == message
    assert text.rstrip("\n").isprintable()


def test_events_wait_for_their_file_and_are_limited_in_number(tmp_path):
    events = Events()
    events.add("start")
    events.time = 1.5
    events.open(tmp_path)
    for number in range(1500):
        events.log("c", 1, "category", f"message {number}")
    events.log("d", 3, "", "other")
    events.log("d", 0, "", "chatter")
    events.close()
    lines = [json.loads(line) for line in (tmp_path / "events.jsonl").read_text().splitlines()]
    assert (lines[0]["event"], lines[0]["time"], lines[1]["time"]) == ("start", 0.0, 1.5)
    assert len(lines) == 1 + 1000 + 1 + 1
    assert lines[-2]["message"] == "further messages are not listed"
    assert (lines[-1]["component"], lines[-1]["level"]) == ("d", "error")


def test_event_of_a_message_names_the_status_only_if_fmi_does(tmp_path):
    events = Events()
    events.open(tmp_path)
    for status in (5, 6, -1):
        events.log("c", status, "", "text")
    events.close()
    lines = [json.loads(line) for line in (tmp_path / "events.jsonl").read_text().splitlines()]
    assert [line["level"] for line in lines] == ["pending", "unknown", "unknown"]


def test_progress_is_plain_lines_without_a_terminal():
    stream = io.StringIO()
    with show_progress("orbit", stream) as report:
        report(1.0, 10.0)
        report(10.0, 10.0)
    assert stream.getvalue().startswith("orbit: 10 of 10 s, ")
    assert stream.getvalue().count("\n") == 1


def test_progress_is_a_bar_on_a_terminal(monkeypatch):
    stream = io.StringIO()
    monkeypatch.setattr(progress, "Console", lambda file: Console(file=file, force_terminal=True, width=120))
    with show_progress("orbit", stream) as report:
        report(2.5, 10.0)
    assert "2.5 of 10 s" in stream.getvalue()
    assert "x real time" in stream.getvalue()
