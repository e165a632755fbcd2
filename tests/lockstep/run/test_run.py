"""Whole runs of real FMUs, each in a fresh process: results, failures, kills, a full disk, memory."""

import json
import os
import resource
import signal
import subprocess
import sys
import time
import tomllib
import zipfile
from dataclasses import replace
from hashlib import sha256
from pathlib import Path

import numpy as np
import pytest

from lockstep import read_signals, write_ssd
from lockstep.__main__ import main

MS = 1_000_000
COMMAND = [sys.executable, "-W", "error", "-m", "lockstep", "run"]


def events(folder):
    return [json.loads(line) for line in (folder / "events.jsonl").read_text().splitlines()]


def run_record(folder):
    return tomllib.loads((folder / "run.toml").read_text())


def files(folder):
    return sorted(path.name for path in folder.iterdir())


FINISHED = ["events.jsonl", "run.toml", "signals.parquet"]


def test_every_sample_carries_the_time_at_which_it_is_true(loop_ssd, tmp_path, cli):
    done = cli("run", loop_ssd, "--out", tmp_path / "out", "--stop-time", "0.02")
    assert (done.returncode, files(tmp_path / "out")) == (0, FINISHED), done.stderr
    signals = read_signals(tmp_path / "out")
    tick = np.arange(21)  # with the row at the stop time
    np.testing.assert_array_equal(signals.time, tick / 1000)
    np.testing.assert_array_equal(signals["counter.count"], tick + 1)  # made in the tick of the row
    np.testing.assert_array_equal(signals["counter.began"], tick / 1000)
    np.testing.assert_array_equal(signals["counter.even"], (tick + 1) % 2 == 0)
    latest = tick // 5 * 5  # when the echo, every 5 ticks, last read the counter of the same tick
    np.testing.assert_array_equal(signals["echo.y"], np.column_stack([latest + 1.0, np.full(21, 7.0)]))
    np.testing.assert_array_equal(signals["echo.number_out"], latest + 1)
    np.testing.assert_array_equal(signals["echo.flag_out"], (latest + 1) % 2 == 0)
    np.testing.assert_allclose(signals["plant.clock"], tick / 1000, atol=1e-17)  # its state is true at the row
    held = np.maximum(0, np.arange(21) - 1)  # count of two ticks ago, 0 before there was one
    expected = 3.0 + np.concatenate([[0.0], np.cumsum(held)[:-1]]) / 1000
    np.testing.assert_allclose(signals["plant.x"], expected, rtol=1e-15 * 20)  # 20 rounded additions


@pytest.mark.parametrize("delay", [0, 1, 5, 6])
def test_a_delay_is_a_number_of_ticks(loop_ssd, tmp_path, cli, delay):
    done = cli("run", loop_ssd, "--out", tmp_path / "out", "--delay", f"counter:echo={delay}", "--stop-time", "0.03")
    assert done.returncode == 0, done.stderr
    read_at = np.arange(31) // 5 * 5
    np.testing.assert_array_equal(read_signals(tmp_path / "out")["echo.y[1]"], np.maximum(0, read_at - delay + 1))


def test_the_run_record_describes_the_run(loop_ssd, loop, tmp_path, cli):
    options = ("--set", "plant.x0=1.5", "--record", "plant.*", "--record-period", "0.002")
    done = cli("run", loop_ssd, "--out", tmp_path / "out", *options)
    assert done.returncode == 0, done.stderr
    run = run_record(tmp_path / "out")
    assert (run["status"], run["simulated_time"], run["stop_time"], run["tick"]) == ("completed", 0.01, 0.01, 0.001)
    assert run["system"]["sha256"] == sha256(loop_ssd.read_bytes()).hexdigest()
    assert run["component"][0]["sha256"] == sha256(loop.components[0].source.read_bytes()).hexdigest()
    assert run["component"][2]["parameters"] == {"x0": 1.5}
    assert (run["record"], run["record_period"], run["overrides"]) == (["plant.*"], 0.002, {"plant.x0": "1.5"})
    assert run["latency"][1] == {"from": "counter", "to": "plant", "delay": 2}
    assert run["versions"]["python"] == sys.version.split()[0]
    assert run["versions"]["numpy"] == np.__version__
    assert [event["event"] for event in events(tmp_path / "out")] == ["start", "end"]
    signals = read_signals(tmp_path / "out", ["plant.x"])
    assert signals.time.tolist() == [0.0, 0.002, 0.004, 0.006, 0.008, 0.01]
    assert list(signals.columns) == ["plant.x"]


def test_two_runs_give_the_same_bytes(loop_ssd, tmp_path, cli):
    for name in ("a", "b"):
        assert cli("run", loop_ssd, "--out", tmp_path / name).returncode == 0
    assert (tmp_path / "a/signals.parquet").read_bytes() == (tmp_path / "b/signals.parquet").read_bytes()


def test_units_and_start_values_reach_the_fmus(toys, tmp_path, cli):
    from lockstep import Component, Connection, System

    values = {"a": {"radians": 0.0, "kelvin": 0.0, "free": 2.5}, "b": {"free": 2.5}}
    parts = [
        Component(name=n, source=toys / "toy_angle.fmu", period=MS, kind="sampled", parameters=v)
        for n, v in values.items()
    ]
    ends = [("degrees", "radians"), ("celsius", "kelvin")]
    wires = [Connection(from_component="a", output=o, to_component="b", input=i) for o, i in ends]
    write_ssd(System(name="u", tick=MS, components=tuple(parts), connections=tuple(wires)), tmp_path / "u.ssd")
    done = cli("run", tmp_path / "u.ssd", "--out", tmp_path / "out", "--stop-time", "0.002")
    assert done.returncode == 0, done.stderr
    signals = read_signals(tmp_path / "out")
    assert signals["b.radians_seen"][0] == pytest.approx(np.pi, rel=1e-15)  # one rounding
    assert signals["b.kelvin_seen"][0] == 293.15
    assert signals["b.free_seen"][0] == 2.5
    assert (signals.units["a.degrees"], signals.units["a.bare"]) == ("deg", "")


def test_an_archive_runs(loop, tmp_path, cli):
    parts = tuple(replace(c, source=tmp_path / c.source.name) for c in loop.components)
    for old, new in zip(loop.components, parts, strict=True):
        new.source.write_bytes(old.source.read_bytes())
    write_ssd(replace(loop, components=parts), tmp_path / "SystemStructure.ssd")
    with zipfile.ZipFile(tmp_path / "loop.ssp", "w") as archive:
        for file in (tmp_path / "SystemStructure.ssd", *(part.source for part in parts)):
            archive.write(file, file.name)
    temporary = tmp_path / "temporary"
    temporary.mkdir()
    done = cli("run", tmp_path / "loop.ssp", "--out", tmp_path / "out", env={**os.environ, "TMPDIR": str(temporary)})
    assert done.returncode == 0, done.stderr
    assert files(temporary) == []
    assert read_signals(tmp_path / "out")["counter.count"][-1] == 11


BAD = [
    (("--set", "counter.gian=2"), r"lockstep: counter.gian: no such parameter; counter has gain"),
    (("--set", "counter.gain"), "lockstep: --set counter.gain: write COMPONENT.PARAMETER=VALUE"),
    (("--stop-time", "soon"), "lockstep: --stop-time: 'soon' is not a number of seconds"),
    (("--stop-time", "0.0015"), "lockstep: stop time 0.0015 s is not a whole multiple of the tick 0.001 s"),
    (("--record", "plant.y"), "lockstep: record 'plant.y' matches no output"),
    (("--record-period", "0.0001"), "lockstep: record period 0.0001 s is not a whole multiple of the tick"),
    (("--delay", "plant=3"), "lockstep: --delay plant=3: write FROM:TO=TICKS"),
    (("--delay", "echo:plant=3"), "lockstep: echo -> plant: no such connection"),
]


@pytest.mark.parametrize(("options", "message"), BAD)
def test_bad_input_is_one_line_and_leaves_nothing(loop_ssd, tmp_path, cli, options, message):
    done = cli("run", loop_ssd, "--out", tmp_path / "out", *options)
    assert done.returncode == 2
    assert done.stderr.startswith(message)
    assert done.stderr.count("\n") == 1
    assert files(tmp_path) == ["loop.ssd"]


def test_a_folder_with_a_run_is_kept_without_overwrite(loop_ssd, tmp_path, cli):
    out = tmp_path / "out"
    assert cli("run", loop_ssd, "--out", out).returncode == 0
    before = (out / "run.toml").read_bytes()
    refused = cli("run", loop_ssd, "--out", out)
    assert (refused.returncode, (out / "run.toml").read_bytes()) == (2, before)
    assert "holds a run already; choose another folder, or replace it (--overwrite)" in refused.stderr
    bad = cli("run", loop_ssd, "--out", out, "--overwrite", "--set", "counter.gian=2")
    assert (bad.returncode, (out / "run.toml").read_bytes()) == (2, before)
    assert cli("run", loop_ssd, "--out", out, "--overwrite", "--stop-time", "0.005").returncode == 0
    assert run_record(out)["stop_time"] == 0.005
    assert files(tmp_path) == ["loop.ssd", "out"]
    (tmp_path / "other").mkdir()
    (tmp_path / "other/precious.txt").write_text("keep")
    assert cli("run", loop_ssd, "--out", tmp_path / "other", "--overwrite").returncode == 2
    assert files(tmp_path / "other") == ["precious.txt"]


@pytest.mark.parametrize(
    ("option", "when", "message"),
    [
        ("counter.nan_at=5", 0.004, "counter.count: is nan at 0.004 s; every exchanged value must be finite"),
        ("counter.fail_at=5", 0.004, "counter: fmi2DoStep returned fmi2Fatal at 0.004 s: "),
        ("echo.refuse_at=0.005", 0.005, "echo: fmi2DoStep returned fmi2Discard at 0.005 s: the echo refuses"),
    ],
)
def test_a_failure_names_component_and_time_and_keeps_earlier_rows(loop_ssd, tmp_path, cli, option, when, message):
    out = tmp_path / "out"
    done = cli("run", loop_ssd, "--out", out, "--set", option)
    assert done.returncode == 1
    assert done.stderr.startswith(f"lockstep: {message}")
    assert done.stderr.count("\n") == 1
    assert files(out) == FINISHED
    assert (run_record(out)["status"], run_record(out)["simulated_time"]) == ("failed", when)
    assert run_record(out)["reason"].startswith(message)
    assert read_signals(out).time.tolist() == [k / 1000 for k in range(round(when * 1000))]
    assert events(out)[-1]["time"] == when


def test_messages_of_an_fmu_are_events_under_its_name(loop_ssd, tmp_path, cli):
    assert cli("run", loop_ssd, "--out", tmp_path / "out", "--set", "echo.refuse_at=0.005").returncode == 1
    logged = [event for event in events(tmp_path / "out") if event["event"] == "log"]
    assert [(e["component"], e["level"], e["message"], e["time"]) for e in logged] == [
        ("echo", "error", "the echo refuses", 0.005)
    ]


def start(loop_ssd, out, *options, **keywords):
    """Start a long run and wait until it has written two batches."""
    command = [*COMMAND, str(loop_ssd), "--out", str(out), "--stop-time", "100000", *options]
    process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True, **keywords)
    stream = out / "signals.arrows"
    deadline = time.monotonic() + 60
    while not stream.exists() or stream.stat().st_size < 200_000:
        assert process.poll() is None, process.stderr.read()
        assert time.monotonic() < deadline
        time.sleep(0.02)
    return process


def test_ctrl_c_closes_everything(loop_ssd, tmp_path, capsys):
    temporary = tmp_path / "temporary"
    temporary.mkdir()
    process = start(loop_ssd, tmp_path / "out", env={**os.environ, "TMPDIR": str(temporary)})
    for options in ((), ("--overwrite",)):  # of a second run, which does not disturb the first
        assert main(["run", str(loop_ssd), "--out", str(tmp_path / "out"), *options]) == 2
        message = "another run is writing to it; choose another folder, or wait until that has ended"
        assert capsys.readouterr().err == f"lockstep: {tmp_path / 'out'}: {message}\n"
    process.send_signal(signal.SIGINT)
    _, error = process.communicate(timeout=60)
    *progress, last = error.splitlines()  # a slow machine reports its progress before
    assert (process.returncode, last) == (130, "lockstep: interrupted")
    assert all(line.startswith("loop: ") for line in progress)
    assert (files(tmp_path / "out"), files(temporary)) == (FINISHED, [])
    run, signals = run_record(tmp_path / "out"), read_signals(tmp_path / "out")
    assert run["status"] == "interrupted"
    np.testing.assert_array_equal(signals["counter.count"], np.arange(len(signals.time)) + 1)
    assert run["simulated_time"] == (len(signals.time)) / 1000  # the tick of the last row was completed


def test_a_killed_run_lacks_at_most_its_last_second(loop_ssd, tmp_path):
    out = tmp_path / "out"
    # nothing is removed after a kill: the FMUs are extracted to where the test runner removes them
    process = start(loop_ssd, out, env={**os.environ, "TMPDIR": str(tmp_path)})
    size = (out / "signals.arrows").stat().st_size
    process.kill()
    process.communicate(timeout=60)
    assert files(out) == ["events.jsonl", "run.toml", "signals.arrows"]
    assert run_record(out)["status"] == "running"
    signals = read_signals(out)
    row = 8 * (1 + len(signals.columns))
    assert len(signals.time) >= size // row - 2000  # a batch of a second and the batches' headers may be missing
    np.testing.assert_array_equal(signals["counter.count"], np.arange(len(signals.time)) + 1)
    whole = (out / "signals.arrows").read_bytes()
    (out / "signals.arrows").write_bytes(whole[: len(whole) - len(whole) // 4 - 3])  # cut within a batch
    assert 0 < len(read_signals(out, ["counter.count"]).time) < len(signals.time)


def limit_file_size():
    resource.setrlimit(resource.RLIMIT_FSIZE, (1_000_000, 1_000_000))


def test_a_full_disk_ends_the_run_with_one_line_and_readable_data(loop_ssd, tmp_path, cli):
    out = tmp_path / "out"
    done = cli("run", loop_ssd, "--out", out, "--stop-time", "100000", preexec_fn=limit_file_size)
    assert done.returncode == 1
    assert done.stderr.splitlines()[-1].startswith(f"lockstep: cannot write to {out}: File too large, after ")
    assert "Traceback" not in done.stderr
    assert run_record(out)["status"] == "failed"
    signals = read_signals(out)
    assert len(signals.time) >= 10_000  # of about 11 360 rows of 88 bytes that fit
    np.testing.assert_array_equal(signals["counter.count"], np.arange(len(signals.time)) + 1)


MEMORY = """
import resource, sys
import lockstep.results.conversion
from lockstep import load_system, simulate
lockstep.results.conversion._GROUP_BYTES = 400_000  # bounds the conversion's memory; here both runs fill it
simulate(load_system(sys.argv[1]), sys.argv[2], stop_time=sys.argv[3])
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
"""


def test_memory_does_not_grow_with_the_length_of_a_run(loop_ssd, tmp_path):
    def peak(stop):
        command = [sys.executable, "-c", MEMORY, str(loop_ssd), str(tmp_path / stop), stop]
        return int(subprocess.run(command, check=True, capture_output=True, text=True).stdout)

    short, long = peak("10"), peak("100")
    # 90 000 more rows of 88 bytes are 7.9 MB: kept in memory once they would exceed this, allocators' slack stays below
    assert long - short < 5_000  # [kB]


def test_show_prints_the_order_of_a_tick(loop_ssd, cli):
    done = cli("show", loop_ssd)
    assert done.returncode == 0
    assert done.stdout.splitlines()[1] == "  counter  every 0.001 s from 0 s, sampled, toy_counter.fmu"
    assert "  counter -> echo: 3 values, same tick" in done.stdout
    assert "  counter -> plant: 1 value, delay 2 ticks" in done.stdout


def test_help_has_an_example(cli):
    done = cli("run", "--help")
    assert done.returncode == 0
    assert "python -m lockstep run orbit.ssd --out results/slew" in done.stdout


def test_the_spacecraft_is_never_imported():
    code = (
        "import sys, lockstep.__main__; print([m for m in sys.modules if m.split('.')[0] in ('flexsat', 'flexbench')])"
    )
    assert subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True).stdout == "[]\n"


def test_a_library_that_lacks_a_function_is_refused(loop, tmp_path, cli):
    broken = tmp_path / "broken.fmu"
    with zipfile.ZipFile(loop.components[0].source) as old, zipfile.ZipFile(broken, "w") as new:
        for name in old.namelist():
            new.writestr(name, b"no library" if name.endswith(".so") else old.read(name))
    write_ssd(
        replace(loop, components=(replace(loop.components[0], source=broken), *loop.components[1:])), tmp_path / "b.ssd"
    )
    done = cli("run", tmp_path / "b.ssd", "--out", tmp_path / "out")
    assert done.returncode == 1
    assert done.stderr.startswith("lockstep: counter: cannot load the FMU: Failed to load shared library")
    assert (done.stderr.count("\n"), Path(tmp_path / "out").exists()) == (1, False)
