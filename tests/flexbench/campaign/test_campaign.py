"""A campaign gives the same bytes whatever happens to its processes, and one bad run takes no other down."""

import errno
import json
import os
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import psutil
import pytest

from flexbench.campaign import journal
from flexbench.campaign.campaign import read_entries
from flexbench.campaign.rerun import rerun
from flexbench.campaign.result_file import read_results
from lockstep import InputError, RunError, read_signals

INPUTS = """
[input.seed]
parameter = "a.seed"
distribution = "case"

[input.u]
parameter = "a.u"
distribution = "norm"
loc = 1.0
scale = 0.5
"""
TEN = "cases = 10"
FLEXSAT = [sys.executable, "-c", "from flexbench.cli.parser import program; program()"]
TABLES = """
[input.seed]
parameter = "a.seed"

[input.gain]
parameter = "a.gain"

[input.sleep]
parameter = "a.sleep"

[input.at]
parameter = "a.sleep_at"

[set]
"a.u" = 1.0
"""


def content(folder):
    """Return the bytes of the results."""
    return (folder / "results.parquet").read_bytes()


def table(path, rows):
    """Write the cases of a table."""
    lines = ["seed,gain,sleep,at", *(",".join(map(str, row)) for row in rows)]
    (path / "cases.csv").write_text("\n".join(lines) + "\n")
    return 'sampling = "table"\ntable = "cases.csv"\nhang_after = 3.0'


def children():
    """Return the worker processes of this one."""
    return [one for one in psutil.Process().children() if "flexbench.engine.worker_process" in one.cmdline()]


def test_any_number_of_processes_gives_the_same_bytes_and_what_it_says_is_so(campaign_file, fly, tmp_path):
    path = campaign_file(TEN, INPUTS)
    one = fly(path, tmp_path / "one", 1).results
    fly(path, tmp_path / "three", 3)

    assert content(tmp_path / "one") == content(tmp_path / "three")
    assert one.numbers.tolist() == list(range(1, 11))
    assert one.completed.all()
    again = read_results(tmp_path / "one")
    assert again.inputs == one.inputs
    found = rerun(tmp_path / "one", 7, record=("all",))
    assert found.same is True
    signals = read_signals(tmp_path / "one/runs/7")
    assert signals["a.y"].max() == one.metrics["largest"][6]
    rows = (signals.time > 0.0049) & (signals.time < 0.0201)
    assert np.sqrt(np.mean(signals["a.y"][rows] ** 2)) == pytest.approx(one.metrics["spread"][6], rel=1e-14)
    assert children() == []


def test_a_campaign_that_is_killed_goes_on_and_ends_with_the_same_bytes(campaign_file, fly, tmp_path):
    path = campaign_file(TEN, INPUTS + '[set]\n"a.sleep_at" = -1\n"a.sleep" = 0.005\n')
    fly(path, tmp_path / "whole", 1)
    for _ in range(2):
        command = [*FLEXSAT, "campaign", str(path), "--out", str(tmp_path / "killed")]
        before = len(read_entries(tmp_path / "killed"))
        process = subprocess.Popen([*command, "--jobs", "1"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        deadline = time.monotonic() + 60.0
        while len(read_entries(tmp_path / "killed")) < before + 2:
            assert time.monotonic() < deadline
            time.sleep(0.01)
        process.kill()
        process.wait()
    kept = read_entries(tmp_path / "killed")
    line = min((tmp_path / "killed/journal").iterdir())
    with line.open("ab") as stream:
        stream.write(b'0123abcd {"number":9,"cut')  # as a kill may leave it
    with pytest.raises(InputError, match="its campaign is not finished"):
        read_results(tmp_path / "killed")
    fly(path, tmp_path / "killed")

    assert 4 <= len(kept) < 10
    assert content(tmp_path / "killed") == content(tmp_path / "whole")
    for number, entry in kept.items():  # not simulated again
        assert read_entries(tmp_path / "killed")[number] == entry


def test_a_crash_and_a_hang_are_rows_and_nothing_else_is_lost(campaign_file, fly, tmp_path):
    keys = table(tmp_path, [(1, 1.0, 0, 0), (2, -1.0, 0, 0), (3, 1.0, 1000, 3), (4, 2.0, 0, 0)])
    done = fly(campaign_file(keys, TABLES), tmp_path / "out", 2)

    assert list(done.results.failures) == ["", "crash", "hang", ""]
    assert list(done.results.causes) == ["", "its process ended by SIGABRT", "no progress in 3 s", ""]
    assert np.isnan(done.results.metrics["largest"]).tolist() == [False, True, True, False]
    assert {number: entry["attempts"] for number, entry in read_entries(tmp_path / "out").items()} == {
        1: 1, 2: 2, 3: 2, 4: 1}  # fmt: skip
    assert rerun(tmp_path / "out", 2).failure == "its process ended by SIGABRT"
    assert children() == []


def test_a_process_that_is_killed_is_replaced_and_its_run_repeated(campaign_file, fly, tmp_path):
    keys = table(tmp_path, [(1, 1.0, 0.02, -1), (2, 1.0, 0.02, -1), (3, 1.0, 0, 0)])
    path = campaign_file(keys, TABLES)

    def kill_first():
        deadline = time.monotonic() + 60.0
        while not children() and time.monotonic() < deadline:
            time.sleep(0.01)
        while len(read_entries(tmp_path / "out")) < 1 and time.monotonic() < deadline:
            time.sleep(0.01)
        time.sleep(0.1)
        children()[0].kill()

    thread = threading.Thread(target=kill_first)
    thread.start()
    fly(path, tmp_path / "out")
    thread.join()
    fly(path, tmp_path / "whole")

    assert sorted(entry["attempts"] for entry in read_entries(tmp_path / "out").values()) == [1, 1, 2]
    assert content(tmp_path / "out") == content(tmp_path / "whole")


def test_a_full_disk_ends_a_campaign_in_order_and_it_goes_on(campaign_file, fly, tmp_path, monkeypatch):
    path = campaign_file(TEN, INPUTS)
    fly(path, tmp_path / "whole")
    write, left = journal._write_all, iter([True] * 4)

    def full(stream, line):
        if next(left, False):
            return write(stream, line)
        write(stream, line[:20])
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(journal, "_write_all", full)
    with pytest.raises(RunError, match=r"journal: cannot be written \(No space left on device\); free space there and"):
        fly(path, tmp_path / "full")
    monkeypatch.undo()
    (file,) = (tmp_path / "full/journal").iterdir()
    assert file.read_bytes().endswith(b"}\n")
    assert len(read_entries(tmp_path / "full")) == 4
    fly(path, tmp_path / "full")

    assert content(tmp_path / "full") == content(tmp_path / "whole")
    assert children() == []


@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_a_signal_ends_a_campaign_in_order(campaign_file, tmp_path, number, code):
    path = campaign_file(TEN, INPUTS + '[set]\n"a.sleep_at" = -1\n"a.sleep" = 0.01\n')
    command = [*FLEXSAT, "campaign", str(path), "--out", str(tmp_path / "out"), "--jobs=1"]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    deadline = time.monotonic() + 60.0
    while len(read_entries(tmp_path / "out")) < 1:
        assert time.monotonic() < deadline
        time.sleep(0.01)
    workers = psutil.Process(process.pid).children()
    process.send_signal(number)
    _, errors = process.communicate(timeout=60.0)

    assert process.returncode == code
    assert "finished runs are kept; the same command continues" in errors
    assert "Traceback" not in errors
    assert not any(one.is_running() and one.status() != psutil.STATUS_ZOMBIE for one in workers)
    assert 1 <= len(read_entries(tmp_path / "out")) < 10


def test_a_folder_says_what_its_campaign_is_and_takes_no_other(campaign_file, fly, tmp_path):
    required = '[[requirement]]\nmetric = "largest"\nmost = 3.0\nprobability = 0.9\n'
    results = fly(campaign_file("cases = 2", INPUTS + required), tmp_path / "out").results
    about = json.loads((tmp_path / "out/campaign.json").read_text())
    assert about["inputs"][1] == {"name": "u", "kind": "parameter", "targets": ["a.u"], "unit": "", "discrete": False,
                                  "distribution": "norm(loc=1, scale=0.5)"}  # fmt: skip
    (requirement,) = results.requirement_list()
    assert (requirement.metric, requirement.most, requirement.probability) == ("largest", 3.0, 0.9)
    assert [one.name for one in results.metric_list()] == ["largest", "spread"]

    before = content(tmp_path / "out")
    with pytest.raises(InputError, match="out: holds a campaign already, and the campaign file, or a file that it nam"):
        fly(campaign_file("cases = 3", INPUTS), tmp_path / "out")
    assert content(tmp_path / "out") == before


def test_the_worst_runs_and_bands_are_kept(campaign_file, fly, tmp_path):
    keys = 'cases = 6\nhistories = "worst"\nworst = 2\nby = "largest"'
    worst = fly(campaign_file(keys, INPUTS), tmp_path / "worst").results
    order = np.argsort(-worst.metrics["largest"])[:2] + 1
    assert sorted(int(path.name) for path in (tmp_path / "worst/runs").iterdir()) == sorted(order.tolist())
    every = fly(campaign_file('cases = 6\nhistories = "all"', INPUTS, "all.toml"), tmp_path / "all").results
    assert np.array_equal(every.metrics["largest"], worst.metrics["largest"])

    band = '\n[[band]]\nsignal = "a.y"\nperiod = 0.004\nresolution = 1e-3\n'
    fly(campaign_file('cases = 6\nhistories = "bands"', INPUTS + band, "bands.toml"), tmp_path / "bands")
    import pyarrow.parquet as pq

    found = pq.read_table(tmp_path / "bands/bands.parquet").to_pydict()
    values = np.array([read_signals(tmp_path / f"all/runs/{k}")["a.y"][::4] for k in range(1, 7)])
    assert found["time"] == pytest.approx([0.0, 0.004, 0.008, 0.012, 0.016, 0.02], abs=1e-12)
    assert found["runs"] == [6] * 6
    assert np.max(np.abs(found["p50"] - np.quantile(values, 0.5, axis=0, method="inverted_cdf"))) <= 0.5001e-3
    assert np.max(np.abs(found["largest"] - values.max(axis=0))) <= 0.5001e-3
    assert np.max(np.abs(found["least"] - values.min(axis=0))) <= 0.5001e-3


def test_a_campaign_ends_when_its_first_runs_are_enough(campaign_file, fly, tmp_path):
    path = campaign_file("cases = 120", INPUTS)
    asked = []

    def until(results):
        asked.append(len(results.numbers))
        return len(results.numbers) >= 50

    done = fly(path, tmp_path / "out", 2, until=until)
    assert asked == [50]
    assert done.stopped
    assert read_results(tmp_path / "out").numbers.tolist() == list(range(1, 51))
