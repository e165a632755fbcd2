"""Times, names in messages, the text of run.toml, events and progress lines."""

import io
import json
import tomllib

import pytest
from rich.console import Console

from lockstep import InputError
from lockstep.cli import progress
from lockstep.cli.progress import show_progress
from lockstep.errors import compact, siblings, suggestion
from lockstep.results.run_record import Events, to_toml
from lockstep.system.clock import nanoseconds, seconds, seconds_text


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
