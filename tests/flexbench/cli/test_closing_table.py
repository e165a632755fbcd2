"""`flexsat run` ends with the numbers of the loop that was flown, of any length and with any controller."""

from __future__ import annotations

import json
import math
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from flexbench.cli.parser import main
from flexbench.runs.run_folder import read_run
from flexbench.studies.budget import steady_error
from flexsat.parameters import ARCSECOND, DEGREE
from fmus.vendor.vendor_fmu import ADAPTER, vendor_fmu
from lockstep import Signals, read_signals

TURN, START = 2e-6, 1.0  # rad about x, s: a slew of less than a second
COMMAND = ("--set", f"controller.command.rotation[1]={TURN}", "--set", f"controller.command.start_time={START}")
FAULT = """\
[[fault]]
name = "gyro bias"
kind = "bias"
connection = "controller.gyro.rate[1]"
from = 0.3
to = 0.6
value = 1e-7
"""


def run(capsys: Any, folder: Path, *words: object) -> tuple[dict[str, Any], Signals, str]:
    """Run a system; return metrics.json, the signals without the row at the stop time, and what was printed."""
    assert main(["run", *map(str, words), "--accept-infeasible", "--out", str(folder)]) == 0
    metrics = json.loads((folder / "metrics.json").read_text())
    whole = read_signals(folder)
    columns = {name: values[:-1] for name, values in whole.columns.items()}
    return metrics, Signals(time=whole.time[:-1], columns=columns, units={}, descriptions={}), capsys.readouterr().out


def root_mean_square(values: Any) -> float:
    """Return the RMS of a history."""
    return float(np.sqrt(np.mean(np.asarray(values) ** 2)))


def printed(table: str, label: str) -> list[float]:
    """Return the numbers of a row of the table."""
    (line,) = [line for line in table.splitlines() if line.startswith(label)]
    return [float(word) for word in line.removeprefix(label).split()[1:]]


def test_the_table_gives_rms_and_peak_during_the_slew_and_after_its_settling(delivered, tmp_path, capsys):
    system = delivered / "centralised" / "slew.ssd"
    metrics, signals, table = run(
        capsys, tmp_path / "out", system, *COMMAND, "--stop-time", "2.2", "--settling-band", "0.15"
    )

    slew, settled = metrics["windows"]
    ((begin, end),), ((since, until),) = slew["spans"], settled["spans"]
    assert (begin, end) == pytest.approx((START - 0.15, START + 0.65), abs=0.03)  # shaped: begins before its time
    assert until == pytest.approx(2.2, abs=1e-6)
    assert metrics["slews"] == [{"start": begin, "end": end}]
    error = 4.0 * np.linalg.norm(signals["plant.attitude.mrp"] - signals["controller.reference.mrp"], axis=1)
    (settling,) = metrics["settling"]
    assert settling["band"] == pytest.approx(0.15 * ARCSECOND)
    rows = signals.time >= end - 1e-9
    if settling["time"] is not None:  # by hand: the row after the last one outside the band
        outside = np.flatnonzero(rows & (error > 0.15 * ARCSECOND))
        expected = 0.0 if not len(outside) else signals.time[outside[-1] + 1] - end
        assert settling["time"] == pytest.approx(expected, abs=1e-9)
    else:
        assert error[-1] > 0.15 * ARCSECOND
    for window, first, last in ((slew, begin, end), (settled, since, until)):
        inside = (signals.time >= first - 1e-9) & (signals.time < last - 1e-9)
        torque = np.abs(signals["controller.wheel.torque"][inside])
        rate = np.linalg.norm(signals["plant.rate"] - signals["controller.reference.rate"], axis=1)[inside]
        expected = {
            "pointing_error": error[inside], "rate_error": rate, "torque": torque.sum(axis=1),
            "wheel_torque": torque.max(axis=1), "deformation": signals["plant.rms_deformation"][inside],
        }  # fmt: skip
        for key, history in expected.items():
            # the angle is 4 x MRP to its square, 1e-12 here
            assert window["rms"][key] == pytest.approx(root_mean_square(history), rel=1e-9), key
            assert window["peak"][key] == pytest.approx(np.max(history), rel=1e-9), key
    units = {"pointing error": ("pointing_error", ARCSECOND), "rate error": ("rate_error", DEGREE),
             "deformation": ("deformation", 1e-6), "torque, sum over wheels": ("torque", 1.0)}  # fmt: skip
    for label, (key, unit) in units.items():
        numbers = [w[kind][key] / unit for w in (slew, settled) for kind in ("rms", "peak")]
        assert printed(table, label) == pytest.approx(numbers, rel=6e-3), label  # three digits
    assert "arcsec" in table
    assert steady_error(read_run(tmp_path / "out")).start == pytest.approx(end, abs=0.006)  # within 5 arcsec
    assert "Errors refer to the reference." in table


def test_a_run_that_ends_in_its_slew_has_no_settling_time_and_windows_of_its_fault(delivered, tmp_path, capsys):
    (tmp_path / "fault.toml").write_text(FAULT)
    words = ("--set", f"controller.command.start_time={START}", "--faults", tmp_path / "fault.toml",
             "--accept-infeasible")  # fmt: skip
    metrics, _, table = run(
        capsys, tmp_path / "out", delivered / "centralised" / "slew.ssd", *words, "--stop-time", "1.5"
    )

    names = [window["name"] for window in metrics["windows"]]
    assert names == ["slew", "before the fault", "during the fault", "after the fault"]
    assert metrics["windows"][2]["spans"] == [[0.3, 0.6]]
    assert [slew["end"] for slew in metrics["slews"]] == [None]
    assert [one["after"] for one in metrics["settling"]] == ["the fault's end"]
    assert "goes on when the run ends: no settling time" in table
    assert metrics["metrics"] == {}  # the paper's rows refer to t > 150 s


@pytest.mark.skipif(shutil.which("gcc") is None, reason="the foreign controller is compiled with gcc")
@pytest.mark.parametrize("constants", ['"reference.*" = 0.0\n', ""], ids=["constants", "left out"])
def test_a_controller_without_a_reference_is_judged_by_the_commanded_attitude(delivered, tmp_path, capsys, constants):
    fmu, adapter = vendor_fmu(tmp_path), tmp_path / "vendor.toml"
    adapter.write_text(ADAPTER.partition("[substitutes]")[0] + (f"[substitutes]\n{constants}" if constants else ""))
    system, turn = delivered / "centralised" / "slew.ssd", 0.5 * DEGREE  # of the system file, from 5 s on
    words = ("--replace", f"controller={fmu}", "--adapter", adapter, "--share-process", "controller")
    metrics, signals, table = run(capsys, tmp_path / "out", system, *words, "--start-time", "4.9", "--stop-time", "5.2")

    assert metrics["reference"] == "the commanded attitude"
    assert metrics["slews"] == [{"start": 5.0, "end": 5.0}]
    commanded = np.where(signals.time[:, None] >= 5.0 - 1e-9, [math.tan(0.25 * turn), 0.0, 0.0], 0.0)
    error = 4.0 * np.linalg.norm(signals["plant.attitude.mrp"] - commanded, axis=1)
    response = metrics["windows"][0]
    ((begin, end),) = response["spans"]
    inside = (signals.time >= begin - 1e-9) & (signals.time < end - 1e-9)
    # 4 x MRP for the angle: its square over 12
    assert response["rms"]["pointing_error"] == pytest.approx(root_mean_square(error[inside]), rel=1e-5)
    assert response["peak"]["pointing_error"] == pytest.approx(turn, rel=1e-2)  # 0.5 deg: it has just begun to turn
    assert metrics["settling"][0]["time"] is None
    assert "Errors refer to the commanded attitude." in table


def test_the_same_fmus_with_flat_names_give_the_same_numbers(delivered, tmp_path, capsys):
    folder = delivered / "centralised"
    plain, _, _ = run(capsys, tmp_path / "a", folder / "fine_pointing.ssd", "--stop-time", "0.3", "--seed", "2")
    flat, _, _ = run(capsys, tmp_path / "b", folder / "flat" / "fine_pointing.ssd", "--stop-time", "0.3", "--seed", "2")
    assert flat["windows"] == plain["windows"]
    assert flat["settling"] == plain["settling"]
    assert plain["settling"][0]["band"] == pytest.approx(0.5 * ARCSECOND)  # of the fine sensor
