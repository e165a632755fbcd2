"""SIGTERM and SIGHUP end a run as Ctrl-C does: the folder is closed, temporary folders are removed, 128 + number."""

import os
import signal
import threading
import time
import tomllib

import numpy as np
import pytest

from fmus.wanderer.wanderer import wanderer
from lockstep import Component, System, read_signals, simulate, write_ssd
from lockstep.__main__ import main
from lockstep.interrupt import Stopped, deferred_interrupt, ended_by_signals, exit_code

SIGNALS = {signal.SIGINT: (130, "interrupted"), signal.SIGTERM: (143, "interrupted by SIGTERM"),
           signal.SIGHUP: (129, "interrupted by SIGHUP")}  # fmt: skip
START = {"u": 0.0, "offset": 0.0, "number": 0, "flag": False}


@pytest.fixture(scope="module")
def system(tmp_path_factory):
    """Return a system of one FMU in the process of the master and one in its own."""
    folder = tmp_path_factory.mktemp("system")
    fmu = wanderer(folder, "good")
    parts = [
        Component(name=n, source=fmu, period=1_000_000, kind="sampled", isolated=n == "b", parameters=START)
        for n in ("a", "b")
    ]
    return System(name="pair", tick=1_000_000, stop_time=10**14, components=tuple(parts), connections=())


@pytest.fixture
def temporary(tmp_path, monkeypatch):
    """Return an empty folder for temporary files."""
    folder = tmp_path / "temporary"
    folder.mkdir()
    monkeypatch.setattr("tempfile.tempdir", str(folder))
    return folder


def signalled(number, out):
    """Send a signal to this process once a run has written rows; return the thread that waits for it."""

    def send():
        stream, deadline = out / "signals.arrows", time.monotonic() + 60.0
        while not (stream.exists() and stream.stat().st_size > 20_000) and time.monotonic() < deadline:
            time.sleep(0.01)
        os.kill(os.getpid(), number)

    thread = threading.Thread(target=send)
    thread.start()
    return thread


def assert_closed(out, reason):
    run, signals = tomllib.loads((out / "run.toml").read_text()), read_signals(out)
    assert (run["status"], run.get("reason")) == ("interrupted", reason)
    assert sorted(path.name for path in out.iterdir()) == ["events.jsonl", "run.toml", "signals.parquet"]
    np.testing.assert_array_equal(signals["b.steps"], np.arange(len(signals.time)) + 1)
    assert run["simulated_time"] == len(signals.time) / 1000  # every row is there


@pytest.mark.parametrize("number", SIGNALS)
def test_a_signal_closes_the_folder_and_is_the_exit_code(system, tmp_path, temporary, capsys, number):
    write_ssd(system, tmp_path / "pair.ssd")
    code, message = SIGNALS[number]
    before = [signal.getsignal(each) for each in SIGNALS]
    thread = signalled(number, tmp_path / "out")
    assert main(["run", str(tmp_path / "pair.ssd"), "--out", str(tmp_path / "out")]) == code
    thread.join()
    assert capsys.readouterr().err.splitlines()[-1] == f"lockstep: {message}"
    assert_closed(tmp_path / "out", None if number == signal.SIGINT else signal.Signals(number).name)
    assert list(temporary.iterdir()) == []
    assert [signal.getsignal(each) for each in SIGNALS] == before


def test_a_signal_ends_a_run_of_the_interface_in_python_with_an_exception(system, tmp_path, temporary):
    thread = signalled(signal.SIGTERM, tmp_path / "out")
    with pytest.raises(Stopped) as caught:
        simulate(system, tmp_path / "out")
    thread.join()
    assert exit_code(caught.value) == 143
    assert_closed(tmp_path / "out", "SIGTERM")
    assert list(temporary.iterdir()) == []


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP])
def test_a_signal_that_is_ignored_or_handled_stays_so(number):
    for handler in (signal.SIG_IGN, lambda *_: None):
        before = signal.signal(number, handler)
        try:
            with ended_by_signals(), deferred_interrupt() as interrupt:
                signal.raise_signal(number)
                assert not interrupt.requested
                assert signal.getsignal(number) == handler
        finally:
            signal.signal(number, before)


@pytest.mark.parametrize("number", SIGNALS)
def test_a_signal_outside_a_run_is_an_exception_at_once(number):
    with pytest.raises(KeyboardInterrupt) as caught, ended_by_signals():
        signal.raise_signal(number)
    assert exit_code(caught.value) == SIGNALS[number][0]
