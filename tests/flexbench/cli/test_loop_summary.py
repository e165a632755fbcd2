"""A run names what its loop does that it should not, with the times: in the summary, run.toml and events.jsonl."""

import json
import shutil
import tomllib

import numpy as np
import pytest

from flexbench.cli.parser import main
from fmus.vendor.vendor_fmu import ADAPTER, vendor_fmu
from lockstep import read_signals

PERIOD = 0.005  # s, of rows and controller


def run(capsys, folder, *words):
    """Run a system; return the findings of run.toml, the events with a state, and what was printed."""
    assert main(["run", *map(str, words), "--out", str(folder)]) == 0
    events = [json.loads(line) for line in (folder / "events.jsonl").read_text(encoding="utf-8").splitlines()]
    record = tomllib.loads((folder / "run.toml").read_text(encoding="utf-8"))
    return record["found"], [e for e in events if "state" in e], capsys.readouterr().out


def test_the_published_controller_on_a_plant_of_28_modes_is_named_a_limit_cycle(delivered, tmp_path, capsys):
    system = delivered / "distributed" / "fine_pointing.ssd"
    words = ("--set", "plant.modes=28", "--set", "controller.design=published", "--stop-time", "1.5")
    found, events, printed = run(capsys, tmp_path / "out", system, *words)

    saturated, cycle = found
    assert (saturated["event"], cycle["event"]) == ("torque-saturation", "limit-cycle")
    assert cycle["first"] == 0.0
    assert cycle["until_the_end"] is True
    assert 11.0 < cycle["torque"] < 17.0  # N.m, sum over the wheels: issue of 11 to 17
    assert 5.0 <= cycle["frequency"] <= 9.0  # Hz: modes 26 to 28 are at 6.9
    torque = np.abs(read_signals(tmp_path / "out")["controller.wheel.torque"])
    first = np.argmax((torque >= 0.8 * (1.0 - 1e-9)).any(axis=1)) * PERIOD
    begins = {e["event"]: e["time"] for e in events if e["state"] == "begin"}
    assert begins == {"torque-saturation": pytest.approx(first, abs=1e-9), "limit-cycle": 0.0}
    assert "limit cycle: once at 0 s, for 1.5 s, to the end: up to 1" in printed
    assert "no wheel speed outside its band, no divergence" in printed


@pytest.mark.skipif(shutil.which("gcc") is None, reason="the foreign controller is compiled with gcc")
def test_the_torque_of_a_foreign_controller_is_watched(delivered, tmp_path, capsys):
    fmu, adapter = vendor_fmu(tmp_path), tmp_path / "vendor.toml"
    adapter.write_text(ADAPTER)
    system = delivered / "centralised" / "fine_pointing.ssd"
    words = ("--replace", f"controller={fmu}", "--adapter", adapter, "--share-process", "controller",
             "--set", "plant.initial.mrp=1e-3,0,0", "--stop-time", "0.3")  # fmt: skip
    (saturated,), events, _ = run(capsys, tmp_path / "out", system, *words)

    torque = np.abs(read_signals(tmp_path / "out")["controller.wheel.torque"])
    at_limit = (torque >= 4.4 * (1.0 - 1e-9)).any(axis=1)
    assert at_limit.any()
    assert events[0]["time"] == pytest.approx(np.argmax(at_limit) * PERIOD, abs=1e-9)
    assert events[0]["wheels"] == [k + 1 for k in np.flatnonzero(torque[np.argmax(at_limit)] >= 4.4 * (1.0 - 1e-9))]
    assert saturated["count"] == 1
