"""A vendor's first flight: from the example of a foreign controller to a loop that holds, with its own names."""

import json
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest

from flexbench.cli.parser import main
from lockstep import read_signals

SOURCE = Path(__file__).parents[2] / "examples" / "vendor" / "pd_controller.py"
LIKE = ("--like", "controller:centralised")


@pytest.fixture(scope="module")
def vendor(tmp_path_factory):
    """Return the FMU as its docstring says to build it."""
    folder = tmp_path_factory.mktemp("vendor")
    program = Path(sys.executable).with_name("pythonfmu")
    subprocess.run([program, "build", "-f", SOURCE, "-d", folder], check=True, capture_output=True)
    return folder / "PdController.fmu"


@pytest.fixture(scope="module")
def drafted(vendor):
    """Return the text that `adapt` drafts."""
    path = vendor.with_name("draft.toml")
    assert main(["adapt", str(vendor), *LIKE, "--out", str(path)]) == 0
    return path.read_text(encoding="utf-8")


@pytest.fixture
def judged(vendor, tmp_path, capsys):
    """Return a function that judges the text of an adapter: exit code and output."""

    def judge(text):
        path = tmp_path / "vendor.toml"
        path.write_text(text, encoding="utf-8")
        return main(["check-adapter", str(vendor), "--adapter", str(path), *LIKE]), capsys.readouterr().out

    return judge


def test_scalars_named_by_axes_are_recognised_as_arrays_with_the_units_of_their_descriptions(drafted):
    draft = tomllib.loads(drafted)

    assert [entry["variable"] for entry in draft["input"]] == [
        ["rate_x", "rate_y", "rate_z"],
        ["q_s", "q_x", "q_y", "q_z"],
    ]
    assert [entry["port"] for entry in draft["input"]] == ["gyro.rate[1..3]", "star_tracker.mrp"]
    assert draft["input"][0]["unit"] == "deg/s"
    assert (draft["input"][1]["attitude"], draft["input"][1]["scalar"]) == ("quaternion", "first")
    assert draft["output"] == [{"port": "wheel.torque", "variable": "torque_*", "unit": "N.m"}]
    assert draft["constants"] == {"mode": 1}


def test_the_draft_is_right_but_for_the_rotation_which_the_check_names(drafted, judged):
    code, text = judged(drafted)
    assert code == 1
    assert 'wrong: inverse rotation: input 2 (q_s): write direction = "inertial-from-body"' in text

    code, text = judged(drafted.replace("body-from-inertial", "inertial-from-body"))
    assert code == 0
    assert "constants of the adapter: mode = 1" in text


def test_wheels_counted_along_the_body_axes_cancel_and_the_signs_are_named(drafted, judged):
    """The example knows that wheels 4 to 6 point the other way; a sign on them is a controller that does not."""
    right = drafted.replace("body-from-inertial", "inertial-from-body")
    code, text = judged(right.replace('variable = "torque_*"', 'variable = "torque_*"\nsign = [1, 1, 1, -1, -1, -1]'))

    assert code == 1
    assert "but their torques cancel on the body" in text
    assert "output 1 (torque_*): write sign = [1, 1, 1, 1, 1, 1]" in text


def test_a_measurement_fed_as_a_constant_and_a_mode_that_is_off_are_named(drafted, judged):
    entries = [entry for entry in drafted.split("\n\n") if '"q_s"' not in entry]
    constants = '"mode" = 0\n"q_s" = 1.0\n"q_x" = 0.0\n"q_y" = 0.0\n"q_z" = 0.0'
    code, text = judged("\n\n".join(entries).replace('"mode" = 1', constants))

    assert code == 1
    assert "constant, though its name is that of a measurement: q_s, q_x, q_y, q_z; give it an [[input]] entry" in text
    assert "wrong: no wheel responds to any error" in text
    assert "flexsat probe-latency" in text


def test_the_loop_holds_and_without_an_adapter_the_command_that_drafts_one_is_named(
    vendor, drafted, delivered, tmp_path, capsys
):
    system = str(delivered / "centralised" / "native" / "fine_pointing.ssd")
    replaced = ["run", system, "--replace", f"controller={vendor}", "--stop-time", "20", "--out", str(tmp_path / "run")]
    assert main(replaced) == 2
    assert f"flexsat adapt {vendor} --like controller --out FILE" in capsys.readouterr().err

    adapter = tmp_path / "vendor.toml"
    adapter.write_text(drafted.replace("body-from-inertial", "inertial-from-body"), encoding="utf-8")
    assert main([*replaced, "--adapter", str(adapter), "--record", "plant.attitude.mrp"]) == 0
    error = 4.0 * np.linalg.norm(read_signals(tmp_path / "run")["plant.attitude.mrp"], axis=1) * 180.0 / np.pi * 3600.0
    assert error.max() < 0.5  # [arcsec]; noise of the fine sensor


@pytest.mark.skipif(shutil.which("gcc") is None, reason="the other controller is compiled with gcc")
def test_margins_are_measured_through_an_adapter(delivered, tmp_path, capsys):
    from fmus.vendor.vendor_fmu import ADAPTER, vendor_fmu

    fmu = vendor_fmu(tmp_path)
    adapter = tmp_path / "vendor.toml"
    adapter.write_text(ADAPTER, encoding="utf-8")
    system = str(delivered / "centralised" / "native" / "fine_pointing.ssd")
    given = ["margins", system, "--replace", f"controller={fmu}", "--adapter", str(adapter), "--noise-free",
             "--set", "plant.modes=25",  # on 198 it is unstable
             "--length", "10", "--periods", "2", "--settle", "1", "--band", "0.1", "2",
             "--out", str(tmp_path / "m")]  # fmt: skip
    assert main(given) == 0
    assert "measured: x" in capsys.readouterr().out
    measured = json.loads((tmp_path / "m" / "margins.json").read_text(encoding="utf-8"))["measured"]["margins"]
    assert measured["x"]["value"]["disk"] > 0.0
