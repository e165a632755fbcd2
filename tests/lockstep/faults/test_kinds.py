"""Each kind of fault on known sequences, in runs of real FMUs, each in a new process."""

import json
import tomllib
from hashlib import sha256

import numpy as np

from lockstep import read_signals
from lockstep.faults.effects import drawn_from

TICKS = np.arange(101)  # with the row at the stop time
CLEAN = TICKS + 1.0  # the counter's count, which the echo gives in the same tick

REALS = """
[[fault]]
name = "stuck at what was last"
connection = "echo.u[1]"
kind = "stuck"
from = 0.010
to = 0.013

[[fault]]
connection = "counter.count -> echo.*"
kind = "stuck"
value = 0.5
from = 0.0195                    # the first tick of the window is the one at 20 ms
to = 0.023

[[fault]]
connection = ["echo.u[1..1]"]
kind = "bias"
value = 1000
at = 0.030
duration = 0.003

[[fault]]
connection = "echo.u[1]"
kind = "scale"
factor = -0.5
from = 0.040
to = 0.043

[[fault]]
connection = "echo.u[1]"
kind = "quantisation"
step = 4
from = 0.050
to = 0.054

[[fault]]
connection = "echo.u[1]"
kind = "delay"
ticks = 3
from = 0.060
to = 0.064

[[fault]]
connection = "echo.u[1]"
kind = "spike"
value = -1e3
at = 0.070

[[fault]]                         # two on one value: in the order of the file
connection = "echo.u"
kind = "bias"
value = [1.0, 2.0]
from = 0.080
to = 0.082

[[fault]]
connection = "echo.u[1]"
kind = "scale"
factor = 10.0
from = 0.081
to = 0.083

[[fault]]
connection = "echo.u[1]"
kind = "noise"
deviation = 0.25
seed = 7
from = 0.090
"""

OTHERS = """
[[fault]]
connection = "echo.flag"
kind = "stuck"
value = true
from = 0.010
to = 0.014

[[fault]]
connection = ["echo.flag", "echo.u"]
kind = "dropout"
from = 0.020
to = 0.024

[[fault]]
connection = "echo.number"
kind = "bias"
value = 0.6
from = 0.030
to = 0.032

[[fault]]
connection = "echo.number"
kind = "scale"
factor = 1e9
from = 0.034
to = 0.036

[[fault]]
connection = "echo.u[1]"
kind = "dropout"
validity = "echo.number"
invalid = -1
from = 0.040
to = 0.044

[[fault]]
connection = ["echo.flag", "echo.number"]
kind = "delay"
ticks = 1
from = 0.050
to = 0.054

[[fault]]
connection = "gain.u"
kind = "NaN"
from = 0.060
to = 0.062

[[fault]]
parameter = "gain.gain"
kind = "bias"
value = 3
from = 0.070
to = 0.072

[[fault]]
parameter = ["gain.shift", "gain.on"]
kind = "stuck"
value = [0, false]
from = 0.080
to = 0.082
"""


def events(folder):
    return [json.loads(line) for line in (folder / "events.jsonl").read_text().splitlines()]


def test_every_kind_gives_its_sequence(bench_ssd, scenario, cli, tmp_path):
    path, out = scenario(REALS), tmp_path / "out"
    done = cli("run", bench_ssd, "--faults", path, "--out", out)
    assert done.returncode == 0, done.stderr
    signals = read_signals(out)
    expected = CLEAN.copy()
    expected[10:13] = 10.0  # the count of tick 9
    expected[20:23] = 0.5
    expected[30:33] += 1000.0
    expected[40:43] *= -0.5
    expected[50:54] = [52.0, 52.0, 52.0, 56.0]  # 51, 52, 53, and 54: a half goes to the even multiple
    expected[60:64] -= 3.0
    expected[70] -= 1000.0
    expected[80:83] = [82.0, 830.0, 830.0]
    draw = drawn_from(7, ["echo.u[1]"])
    expected[90:] += [0.25 * draw(tick).standard_normal(1)[0] for tick in range(90, 101)]

    np.testing.assert_array_equal(signals["echo.y[1]"], expected)
    other = TICKS / 1000
    other[80:82] += 2.0
    np.testing.assert_array_equal(signals["echo.y[2]"], other)
    np.testing.assert_array_equal(signals["gain.y"], 2.0 * CLEAN)  # reads the same output of the counter, unharmed
    np.testing.assert_array_equal(signals["counter.count"], CLEAN)

    faults = [event for event in events(out) if event["event"] == "fault"]
    assert len(faults) == 20
    assert [fault["time"] for fault in faults] == sorted(fault["time"] for fault in faults)
    what = {"kind": "stuck", "component": "echo", "variables": ["u[1]"], "name": "stuck at what was last",
            "values": {}, "event": "fault"}  # fmt: skip
    assert faults[0] == {**what, "time": 0.01, "state": "begin", "from": 0.01, "to": 0.013}
    assert faults[1] == {**what, "time": 0.013, "state": "end"}
    assert (faults[2]["time"], faults[2]["from"], faults[2]["name"]) == (0.02, 0.0195, "fault 2")
    assert faults[6]["values"] == {"factor": -0.5}
    spike = [fault for fault in faults if fault["kind"] == "spike"]
    assert [(fault["state"], fault["time"]) for fault in spike] == [("begin", 0.07), ("end", 0.071)]
    noise = [fault for fault in faults if fault["kind"] == "noise"]
    assert [(fault["state"], fault["time"]) for fault in noise] == [("begin", 0.09), ("end", 0.1)]
    assert noise[0]["values"] == {"deviation": 0.25, "seed": 7}

    kept = tomllib.loads((out / "run.toml").read_text())["faults"]
    assert kept == [{"path": str(path), "sha256": sha256(path.read_bytes()).hexdigest(), "text": REALS}]


def test_faults_on_other_types_flags_and_parameters(bench_ssd, scenario, cli, tmp_path):
    done = cli("run", bench_ssd, "--faults", scenario(OTHERS), "--out", tmp_path / "out")
    assert done.returncode == 0, done.stderr
    signals = read_signals(tmp_path / "out")
    flag, number, real = (TICKS + 1) % 2 == 0, TICKS + 1, CLEAN.copy()
    flag[10:14] = True
    flag[20:24] = False
    real[20:24] = 20.0
    number[30:32] = [32, 33]  # 31.6, 32.6
    number[34:36] = 2**31 - 1
    number[40:44] = -1
    real[40:44] = 40.0
    flag[50:54] = ~flag[50:54]
    number[50:54] -= 1
    np.testing.assert_array_equal(signals["echo.flag_out"], flag)
    np.testing.assert_array_equal(signals["echo.number_out"], number)
    np.testing.assert_array_equal(signals["echo.y[1]"], real)
    held = TICKS / 1000
    held[20:24] = 0.019
    np.testing.assert_array_equal(signals["echo.y[2]"], held)

    gained = 2.0 * CLEAN
    gained[60:62] = gained[59]  # the FMU survives what is no number
    gained[70:72] = 5.0 * CLEAN[70:72]
    gained[80:82] = 0.0
    np.testing.assert_array_equal(signals["gain.y"], gained)
    assert signals["gain.bad"][-1] == 2
    bad = next(event for event in events(tmp_path / "out") if event.get("kind") == "nan")
    assert (bad["component"], bad["variables"], bad["values"]) == ("gain", ["u"], {})


def test_nan_is_transferred_and_what_the_consumer_makes_of_it_recorded(bench_ssd, scenario, cli, tmp_path):
    """Nobody uses the output that becomes NaN: it is reported once, and the run goes on."""
    text = '[[fault]]\nconnection = "echo.u[1]"\nkind = "nan"\nfrom = 0.004\nto = 0.005\n'
    done = cli("run", bench_ssd, "--faults", scenario(text), "--out", tmp_path / "out")
    assert done.returncode == 0
    warning = "warning: recorded though not finite, as no connection uses it: echo.y[1] (nan at 0.004 s)"
    assert done.stderr.splitlines()[-1] == warning
    recorded = [(event["event"], event.get("state")) for event in events(tmp_path / "out")]
    assert recorded == [("start", None), ("fault", "begin"), ("not-finite", None), ("fault", "end"), ("end", None)]
    value = read_signals(tmp_path / "out")["echo.y[1]"]
    assert np.flatnonzero(np.isnan(value)).tolist() == [4]


def test_noise_depends_on_seed_names_and_time_alone(bench_ssd, scenario, cli, tmp_path):
    noise = '[[fault]]\nconnection = "echo.u"\nkind = "noise"\ndeviation = 1.0\nseed = {}\nfrom = {}\n'
    spikes = '[[fault]]\nconnection = "gain.u"\nkind = "spike"\nvalue = 5\nprobability = 0.3\nseed = 1\nfrom = 0.0\n'
    alone = run(cli, bench_ssd, scenario(noise.format(1, 0.02)), tmp_path / "alone")
    more = run(cli, bench_ssd, scenario(spikes + noise.format(1, 0.03)), tmp_path / "more", "--record", "echo.y",
               "--record", "gain.y", "--record-period", "0.005")  # fmt: skip
    other = run(cli, bench_ssd, scenario(noise.format(2, 0.02)), tmp_path / "other")
    np.testing.assert_array_equal(alone["echo.y"][30::5], more["echo.y"][6:])
    drawn = alone["echo.y[1]"][20:] - CLEAN[20:]
    assert np.abs(drawn).max() < 5.0
    assert 0.7 < drawn.std() < 1.3  # 81 draws: 3.5 standard deviations
    assert np.abs(np.corrcoef(drawn, alone["echo.y[2]"][20:] - TICKS[20:] / 1000)[0, 1]) < 0.4
    assert np.all(other["echo.y[1]"][20:] != alone["echo.y[1]"][20:])
    hits = 0.5 * more["gain.y"] - CLEAN[::5]
    assert set(hits) == {0.0, 5.0, -5.0}


def run(cli, system, faults, out, *more):
    done = cli("run", system, "--faults", faults, "--out", out, *more)
    assert done.returncode == 0, done.stderr
    return read_signals(out)


def test_fault_acts_on_transfers_and_held_values_stay(bench_ssd, scenario, cli, tmp_path):
    """An echo of 5 ms: a window from 22 to 33 ms meets its steps at 25 and 30 ms; delays are in ticks of the system."""
    text = """
[[fault]]
connection = "echo.u[1]"
kind = "bias"
value = 0.5
from = 0.022
to = 0.033

[[fault]]
connection = "echo.u[1]"
kind = "delay"
ticks = 7
from = 0.05
to = 0.06
"""
    signals = run(cli, bench_ssd, scenario(text), tmp_path / "out", "--step-size", "echo=0.005")
    expected = TICKS // 5 * 5 + 1.0
    expected[25:35] += 0.5
    expected[50:60] -= 10.0  # transfers are 5 ticks apart: the newest that is at least 7 ticks old is 10 ticks old
    np.testing.assert_array_equal(signals["echo.y[1]"], expected)


def test_faults_reach_an_isolated_fmu(bench_ssd, scenario, cli, tmp_path):
    text = """
[[fault]]
connection = "gain.u"
kind = "scale"
factor = 3.0
from = 0.01
to = 0.02

[[fault]]
parameter = "gain.gain"
kind = "stuck"
value = 7.0
from = 0.015
to = 0.025
"""
    isolated = run(cli, bench_ssd, scenario(text), tmp_path / "out", "--isolate", "gain", "--stop-time", "0.03")
    expected = 2.0 * CLEAN[:31]
    expected[10:20] *= 3.0
    expected[15:25] *= 3.5
    np.testing.assert_array_equal(isolated["gain.y"], expected)


def test_faults_on_an_adapted_component_name_its_ports_and_the_parameters_of_the_fmu(
    bench_ssd, toys, scenario, cli, tmp_path
):
    (tmp_path / "foreign.toml").write_text(
        '[[input]]\nport = "u"\nvariable = "u"\nsign = -1\n\n[[output]]\nport = "y"\nvariable = "y"\n\n'
        '[[output]]\nport = "bad"\nvariable = "bad"\n\n[parameters]\nshift = 5\n'
    )
    text = """
[[fault]]
connection = "gain.u"
kind = "bias"
value = 100.0
from = 0.01
to = 0.02

[[fault]]
parameter = "gain.shift"
kind = "scale"
factor = -1.0
from = 0.015
to = 0.025
"""
    replaced = ("--replace", f"gain={toys / 'toy_gain.fmu'}", "--adapter", tmp_path / "foreign.toml")
    signals = run(cli, bench_ssd, scenario(text), tmp_path / "out", "--stop-time", "0.03", *replaced)
    expected = 5.0 - 2.0 * CLEAN[:31]
    expected[10:20] -= 200.0
    expected[15:25] -= 10.0
    np.testing.assert_array_equal(signals["gain.y"], expected)
