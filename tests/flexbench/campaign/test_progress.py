"""The state of a campaign in words: what is done and failed, the rate of this program, what is left."""

import io

import pytest
from rich.console import Console

from flexbench.campaign import progress
from flexbench.campaign.progress import Counter, shown


@pytest.fixture
def clock(monkeypatch):
    """Return the time that progress goes by."""
    now = [100.0]
    monkeypatch.setattr(progress, "monotonic", lambda: now[0])
    return now


def test_rate_and_time_left_are_of_the_runs_of_this_program(clock):
    counter = Counter(1000, 400, 2)  # found in a journal
    counter.workers = 2
    assert counter.text == "400 of 1000 runs, 2 failed, 2 at once"
    clock[0] += 40.0
    for k in range(20):
        counter.add(k == 0)

    assert counter.text == "420 of 1000 runs, 3 failed, 0.5 a second, 19 min left, 2 at once"
    for _ in range(580):
        counter.add(failed=False)
    assert counter.text == "1000 of 1000 runs, 3 failed, 2 at once"


def test_without_a_terminal_there_is_a_line_every_ten_seconds_and_at_the_end(clock, capsys):
    counter = Counter(4, 0, 0)
    with shown(counter, "toy") as show:
        for _ in range(4):
            clock[0] += 6.0
            counter.add(failed=False)
            show.look()

    assert capsys.readouterr().err.splitlines() == [
        "toy: 2 of 4 runs, 0 failed, 0.167 a second, 12 s left, 0 at once",
        "toy: 4 of 4 runs, 0 failed, 0 at once",
        "toy: 4 of 4 runs, 0 failed, 0 at once",
    ]


def test_on_a_terminal_of_80_columns_nothing_is_cut(monkeypatch):
    out = io.StringIO()
    console = Console(file=out, width=80, force_terminal=True, color_system=None)
    monkeypatch.setattr(progress, "Console", lambda **_: console)
    counter = Counter(10_000, 0, 12)
    counter.workers = 8
    with shown(counter, "a-campaign-with-a-long-name") as show:
        counter.done = 1234
        show.look()
    assert "…" not in out.getvalue()
    assert ", 8 at once" in out.getvalue()
