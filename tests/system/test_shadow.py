"""Shadows of the LQG in the closed loop: itself, a softer build of it, and a foreign controller that takes over."""

import io
import json
import shutil
import tomllib
import zipfile
from pathlib import Path

import numpy as np
import pytest

from flexbench.cli.parser import main
from flexbench.report.sections.shadow import section
from flexbench.runs.run_folder import read_run
from flexbench.studies.health.replay import replay
from flexsat.fmu.export import build_fmu
from flexsat.fmu.reproducible_zip import npz_bytes
from flexsat.runtime.rotations import quaternion_from_mrp
from fmus.vendor.vendor_fmu import ADAPTER, vendor_fmu
from lockstep import read_signals

SYSTEM = Path("centralised", "fine_pointing.ssd")
SHARE = 0.2  # by which the softer controller is softer


@pytest.fixture(scope="module")
def softer(fmus, tmp_path_factory):
    """Return our controller, built with 0.8 of its feedback, and of its torque against the jitter."""
    with zipfile.ZipFile(fmus / "centralised" / "controller.fmu") as archive:
        arrays = dict(np.load(io.BytesIO(archive.read("resources/model.npz"))))
    scaled = ("feedback", "jitter_torque")
    model = {name: (1.0 - SHARE) * values if name.endswith(scaled) else values for name, values in arrays.items()}
    path = tmp_path_factory.mktemp("softer") / "softer.fmu"
    build_fmu("flexsat.fmu.python.controller:Controller", path, {"model.npz": npz_bytes(model)}, "controller_softer")
    return path


@pytest.fixture(scope="module")
def taken_over(flexsat, fmus, softer, tmp_path_factory):
    """Return the results of a run in which the softer controller takes over at 0.5 s and blends in until 0.7 s."""
    out = tmp_path_factory.mktemp("taken-over") / "run"
    done = flexsat(
        "run", fmus / SYSTEM, "--stop-time", 1, "--out", out, "--record", "all", "--record-period", "0.005",
        "--shadow", f"controller={softer}", "--switchover", "0.5", "--blend", "0.2",
        "--set", "controller.shadow.open_loop=false", "--checkpoint", "0.6",
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return out


def test_the_lqg_as_its_own_shadow_changes_nothing_bitwise(flexsat, fmus, tmp_path, capsys):
    given = ("run", fmus / SYSTEM, "--stop-time", "0.4", "--record", "all")
    shadow_options = (
        "--shadow",
        f"controller={fmus / 'centralised' / 'controller.fmu'}",
        "--switchover",
        "0.2",
        "--blend",
        "0.1",
    )
    assert flexsat(*given, "--out", tmp_path / "alone").returncode == 0
    done = flexsat(*given, "--out", tmp_path / "shadowed", *shadow_options)
    assert done.returncode == 0, done.stderr
    alone, shadowed = read_signals(tmp_path / "alone"), read_signals(tmp_path / "shadowed")

    assert np.any(alone["controller.wheel.torque"][-1])
    for name, values in alone.columns.items():
        np.testing.assert_array_equal(shadowed[name], values, err_msg=name)
    assert not np.any(shadowed["controller.residual.wheel.torque"])
    assert "jump 0 N.m, without blending 0" in done.stdout
    assert main(["shadow", str(tmp_path / "alone")]) == 2
    assert "this run had no shadow; run with --shadow COMPONENT=FMU" in capsys.readouterr().err


REPLAY = """
import fmpy
import numpy as np
from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Slave
from lockstep import read_signals
import tomllib

run = read_signals(given[1])
manifest = tomllib.loads((Path(given[1]) / "run.toml").read_text())
result = next(component for component in manifest["component"] if component["name"] == "controller")
description, folder = read_model_description(given[0]), extract(given[0])
number = {v.name: v.valueReference for v in description.modelVariables}
kind = {v.name: v.type for v in description.modelVariables}
fmu = FMU2Slave(guid=description.guid, unzipDirectory=folder, modelIdentifier="controller_softer", instanceName="alone")
fmu.instantiate()
put = {"Real": fmu.setReal, "Boolean": fmu.setBoolean, "String": fmu.setString}
fmu.setupExperiment(startTime=0.0, stopTime=1.005)  # it samples at 1 s, too
for name, value in result["parameters"].items():
    name = name.removeprefix("shadow.")
    put[kind[name]]([number[name]], [value])
fmu.enterInitializationMode()
fmu.exitInitializationMode()
fmu.setBoolean([number["applied.valid"]], [True])
measured = [v.name for v in description.modelVariables
            if v.causality == "input" and f"sensors.{v.name}" in run.columns]
wheels = [f"wheel.torque[{k}]" for k in range(1, 7)]
torque, acted = [], np.zeros(6)
for row in range(len(run.time)):
    for name in measured:
        value = run[f"sensors.{name}"][row]
        put[kind[name]]([number[name]], [value if kind[name] == "Real" else bool(value)])
    fmu.setReal([number[f"applied.{w}"] for w in wheels], list(acted))
    fmu.doStep(float(run.time[row]), 0.005)
    torque.append(fmu.getReal([number[w] for w in wheels]))
    acted = run["controller.wheel.torque"][row]
fmu.terminate()
result = torque
"""


def test_the_residual_is_what_a_replay_of_the_measurements_gives(taken_over, softer, python):
    run = read_signals(taken_over)
    replayed = np.array(python(REPLAY, softer, taken_over))
    before = run.time < 0.5
    original = run["controller.original.wheel.torque"]

    np.testing.assert_array_equal(run["controller.shadow.wheel.torque"], replayed)
    np.testing.assert_array_equal(run["controller.residual.wheel.torque"], replayed - original)
    # with the applied torque as its input, its estimate is that of the original: only the feedback differs
    scale = np.max(np.abs(original))
    np.testing.assert_allclose(replayed[before], (1.0 - SHARE) * original[before], rtol=0.0, atol=1e-12 * scale)


def test_it_takes_over_without_a_jump(taken_over):
    run = read_signals(taken_over)
    acting, original, shadow = (run[f"controller.{kind}wheel.torque"] for kind in ("", "original.", "shadow."))
    at, over = int(np.argmin(np.abs(run.time - 0.5))), run.time >= 0.7 - 1e-9

    np.testing.assert_array_equal(acting[: at + 1], original[: at + 1])
    np.testing.assert_array_equal(acting[over], shadow[over])
    assert np.all(np.any(acting[at + 1 :] != original[at + 1 :], axis=1))
    steps = np.max(np.abs(np.diff(acting, axis=0)), axis=1)
    assert np.max(steps[at - 1 : at + 1]) <= np.max(steps[at - 40 : at - 1])  # to the switchover, and from it on
    assert np.max(np.abs(acting[at] - shadow[at])) > 0.0  # there was something to jump
    events = [json.loads(line) for line in (taken_over / "events.jsonl").read_text().splitlines()]
    (event,) = [event for event in events if event["event"] == "switchover"]
    assert event["time"] == 0.5
    np.testing.assert_array_equal(event["offset"], original[at] - shadow[at])


def test_a_run_goes_on_in_the_middle_of_the_blend_bitwise(taken_over, flexsat, tmp_path):
    done = flexsat("run", "--restart-from", taken_over / "checkpoints" / "t=0.6.ckpt", "--out", tmp_path / "branch")
    assert done.returncode == 0, done.stderr
    whole, branch = read_signals(taken_over), read_signals(tmp_path / "branch")
    rows = whole.time >= 0.6 - 1e-9

    assert len(branch.time) == np.count_nonzero(rows) == 81
    for name, values in whole.columns.items():
        np.testing.assert_array_equal(branch[name], values[rows], err_msg=name)


def test_the_report_shows_residuals_and_the_loop_before_and_after(taken_over, capsys):
    assert main(["shadow", str(taken_over)]) == 0
    printed = capsys.readouterr().out
    result = json.loads((taken_over / "shadow.json").read_text())
    run = read_signals(taken_over)
    before, after = run.time < 0.5 - 1e-9, (run.time >= 0.7 - 1e-9) & (run.time < 1.0 - 1e-9)
    residual, acting = run["controller.residual.wheel.torque"], run["controller.wheel.torque"]

    rms = np.sqrt(np.mean(residual[before] ** 2, axis=0))
    np.testing.assert_allclose([one["rms"] for one in result["residuals"]], rms, rtol=1e-12)
    np.testing.assert_allclose([one["relative"] for one in result["residuals"]], SHARE, rtol=1e-9)
    np.testing.assert_allclose([one["correlation"] for one in result["residuals"]], 1.0, rtol=1e-9)
    assert {one["lag"] for one in result["residuals"]} == {0.0}
    assert result["jump"]["acting"] == 0.0
    windows = result["windows"]
    assert (windows["before"]["start"], windows["before"]["end"]) == pytest.approx((0.2, 0.5))  # as long as the other
    assert (windows["after"]["start"], windows["after"]["end"]) == pytest.approx((0.7, 1.0))
    effort = np.sqrt(np.mean(np.sum(np.abs(acting[after]), axis=1) ** 2))
    assert windows["after"]["metrics"]["torque"] == pytest.approx(effort, rel=1e-12)
    assert windows["after"]["metrics"]["deformation"] == pytest.approx(
        np.sqrt(np.mean(run["plant.rms_deformation"][after] ** 2)), rel=1e-12
    )
    assert "wheel.torque[6]" in printed
    assert "took over at 0.5 s with a jump of 0 N.m" in printed
    assert (taken_over / "figures" / "shadow.svg").is_file()
    assert len(replay(read_run(taken_over)).time) == 200  # of the original, whatever acted
    blocks = section(read_run(taken_over))
    assert [type(block).__name__ for block in blocks] == [
        "Heading", "Paragraph", "Table", "Picture", "Table", "Paragraph",
    ]  # fmt: skip


def test_windows_that_do_not_fit_are_refused(taken_over, capsys):
    for given, message in (
        (("--window", "0.4"), "--window 0.4: must be > 0 and at most 0.3 s"),
        (("--from", "0.5"), "no two rows were recorded from 0.5 s to the switchover"),
    ):
        assert main(["shadow", str(taken_over), *given]) == 2
        assert message in capsys.readouterr().err


@pytest.mark.skipif(shutil.which("gcc") is None, reason="the foreign controller is compiled with gcc")
def test_a_foreign_shadow_at_its_own_rate_holds_the_attitude_after_switchover(flexsat, fmus, tmp_path, capsys):
    vendor_fmu(tmp_path)
    (tmp_path / "vendor.toml").write_text(ADAPTER)
    given = (
        "run", fmus / SYSTEM, "--out", tmp_path / "run", "--record", "sensors.star_tracker.*", "--record",
        "sensors.gyro.rate", "--record", "plant.attitude.mrp", "--shadow", f"controller={tmp_path / 'vendor.fmu'}",
        "--shadow-adapter", tmp_path / "vendor.toml", "--set", "controller.shadow.kp=0.15", "--set",
        "controller.shadow.kd=0.5", "--set", "plant.modes=25",  # with 198 modes it would be unstable
    )  # fmt: skip
    assert main([str(word) for word in (*given, "--switchover", "0.505")]) == 2
    periods = "switchover 0.505 s is no step of controller and its shadow, whose periods are 0.005 s and 0.01 s"
    assert f"{periods}; choose 0.5 s or 0.51 s" in capsys.readouterr().err
    done = flexsat(*given, "--stop-time", 10, "--switchover", "0.5", "--blend", "0.5")
    assert done.returncode == 0, done.stderr
    run = read_signals(tmp_path / "run")

    # its law, from what it measured: it steps every second row, and holds the last valid attitude
    inertia, axes = np.array([217.7e3, 217.7e3, 435.4e3]), np.vstack([np.eye(3), -np.eye(3)])
    angle, expected = np.zeros(3), np.zeros((len(run.time), 6))
    for row in range(0, len(run.time), 2):
        if run["sensors.star_tracker.valid"][row]:
            x, y, z, w = quaternion_from_mrp(run["sensors.star_tracker.mrp"][row].tolist())
            angle = 2.0 * np.sign(w) * np.array([x, y, z])
        body = -inertia * (0.15 * angle + 0.5 * run["sensors.gyro.rate"][row, :3])
        expected[row : row + 2] = np.clip(-0.5 * axes @ body, -4.4, 4.4)
    shadow = run["controller.shadow.wheel.torque"]
    # conversions to degrees and mN.m round, 2e5 N.m.s times 1e-16 of rates of 1e-6
    np.testing.assert_allclose(shadow, expected, rtol=0.0, atol=1e-11)
    np.testing.assert_array_equal(
        run["controller.residual.wheel.torque"], shadow - run["controller.original.wheel.torque"]
    )
    at = int(np.argmin(np.abs(run.time - 0.5)))
    np.testing.assert_array_equal(run["controller.wheel.torque"][at], run["controller.original.wheel.torque"][at])
    np.testing.assert_array_equal(run["controller.wheel.torque"][run.time >= 1.0], shadow[run.time >= 1.0])
    error = np.linalg.norm(run["plant.attitude.mrp"], axis=1)
    assert np.max(error[run.time > 9.0]) < 0.5 * error[at]  # of 0.25 arcsec
    manifest = tomllib.loads((tmp_path / "run" / "run.toml").read_text())
    component = next(c for c in manifest["component"] if c["name"] == "controller")
    assert component["period"] == 0.005
    assert component["shadow"]["period"] == 0.01
    assert component["shadow"]["isolated"]
    assert component["shadow"]["adapter"] == str(tmp_path / "vendor.toml")
    assert (component["shadow"]["switchover"], component["shadow"]["blend"]) == (0.5, 0.5)
    assert component["parameters"]["shadow.kp"] == 0.15
