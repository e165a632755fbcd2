"""`flexsat budget`, `spectra` and `waterfall` on real co-simulations, short ones."""

import json
import re

import numpy as np
import pytest

from flexbench.cli.parser import PROGRAM
from lockstep import read_signals

WINDOWS = ("--window", "0.5", "--separation", "1", "--observation", "1")


@pytest.fixture(scope="module")
def split(flexsat, fmus, tmp_path_factory):
    """Return the folder of a split of 4 s, and what was printed."""
    folder = tmp_path_factory.mktemp("split")
    system = fmus / "centralised" / "fine_pointing.ssd"
    done = flexsat("budget", "--split", system, "--seed", "3", "--stop-time", "4", "--out", folder, *WINDOWS)
    assert done.returncode == 0, done.stderr
    return folder, done.stdout


def values(folder):
    content = json.loads((folder / "split.json").read_text())
    return {
        name: {(e["index"], e["axis"]): e["rms"] for e in entries}
        for name, entries in content["contributions_rad"].items()
    }


def test_nothing_moves_with_all_sources_off(split):
    folder, _ = split
    rounding = 1e-30  # rad, rad/s: roundings of torques that cancel; the errors of the sources are 1e-7 rad
    assert max(values(folder)["none"].values()) < rounding
    assert np.abs(read_signals(folder / "none")["plant.rate"]).max() < rounding


def test_sources_add_up_to_all_as_the_loop_is_nearly_linear(split):
    folder, printed = split
    found = values(folder)
    ape = ("APE", "line_of_sight")
    for source in ("sensor noise", "jitter", "initial error and slew"):
        assert found[source][ape] > 0.0
        assert source in printed
    # second-order terms, and the wheels' tilting forces: far below a percent of the error
    assert found["residual"][ape] < 0.01 * found["all"][ape]
    assert 0.0 < found["gyroscopics"][ape] < found["all"][ape]
    assert found["guidance"][ape] == 0.0
    assert "root-sum-square of sources" in printed


def test_the_seed_is_that_of_every_run(split):
    folder, _ = split
    both = [read_signals(folder / name)["plant.wheel.speed"][0] for name in ("all", "jitter")]
    assert np.array_equal(*both)
    assert json.loads((folder / "split.json").read_text())["seed"] == 3


def test_budget_judges_requirements_by_its_exit_code(split, flexsat, tmp_path):
    folder, _ = split
    line = '[[requirement]]\nname = "r"\nindex = "APE"\naxis = "angle"\nunit = "arcsec"\nlimit = '
    met, missed, wrong = (tmp_path / f"{name}.toml" for name in ("met", "missed", "wrong"))
    for path, limit in ((met, "1e3"), (missed, "1e-6"), (wrong, '"much"')):
        path.write_text(line + limit)

    codes = {}
    for path in (met, missed, wrong):
        done = flexsat("budget", folder / "all", "--requirements", path, *WINDOWS)
        codes[path.stem] = done.returncode
        assert "Traceback" not in done.stderr
    assert codes == {"met": 0, "missed": 1, "wrong": 2}
    assert "limit = 'much': must be a number" in done.stderr
    content = json.loads((folder / "all" / "budget.json").read_text())
    assert content["requirements"][0]["met"] is False
    assert {entry["index"] for entry in content["indices"]} == {"APE", "MPE", "RPE", "PDE", "PRE"}


def test_results_that_may_only_be_read_are_evaluated_into_another_folder(split, tmp_path, capsys):
    run = split[0] / "jitter"
    before = sorted(run.rglob("*"))

    assert PROGRAM.run(["budget", str(run), *WINDOWS, "--out", str(tmp_path / "one")]) == 0
    assert PROGRAM.run(["spectra", str(run), "--resolution", "2", "--out", str(tmp_path / "one")]) == 0
    assert sorted(run.rglob("*")) == before
    found = {path.name for path in (tmp_path / "one").rglob("*")}
    assert {"budget.json", "budget.png", "spectra.json", "spectra.png"} <= found

    (tmp_path / "file").write_text("")
    capsys.readouterr()
    assert PROGRAM.run(["spectra", str(run), "--resolution", "2", "--out", str(tmp_path / "file")]) == 2
    assert re.fullmatch(
        r"flexsat: \S*file\S*: cannot be written \(.*\); give another folder with --out\n", capsys.readouterr().err
    )


def test_spectra_leave_figure_and_numbers(split, flexsat):
    folder, _ = split
    run = folder / "all"
    done = flexsat("spectra", run, "--resolution", "2")
    assert done.returncode == 0, done.stderr
    assert "95 % bounds" in done.stdout
    content = json.loads((run / "spectra.json").read_text())["channels"]["deformation"]
    signals = read_signals(run)
    later = (signals.time >= 2.0) & (signals.time < 4.0)  # without the row at the stop time
    expected = np.sqrt(np.mean(signals["plant.rms_deformation"][later] ** 2))
    assert abs(content["rms"] / expected - 1.0) < 1e-9
    assert (run / "figures" / "spectra.svg").is_file()


def test_waterfall_of_three_speeds_peaks_at_the_resonance(flexsat, fmus, tmp_path):
    """The allowed band of the wheels about z holds a mode; away from it the harmonic shakes less."""
    system = fmus / "centralised" / "fine_pointing.ssd"
    done = flexsat(
        "waterfall", system, "--points", "3", "--speed-range", "150", "400", "--stop-time", "2", "--out", tmp_path
    )
    assert done.returncode == 0, done.stderr
    content = json.loads((tmp_path / "waterfall.json").read_text())
    assert content["speed_rpm"] == pytest.approx([150.0, 275.0, 400.0])
    speeds = read_signals(tmp_path / "speed-0275.00rpm")["plant.wheel.speed"]
    assert np.abs(speeds / (275.0 * np.pi / 30.0) - 1.0).max() < 1e-3  # all wheels, and they stay
    flagged = [crossing for crossing in content["crossings"] if crossing["inside_band_of_wheels"]]
    assert flagged
    for crossing in flagged:
        assert crossing["linear_deformation_of_those_m"] > 0.0
    assert all(value > 0.0 for value in content["deformation_rms_m"])
    assert (tmp_path / "figures" / "waterfall.svg").is_file()
    assert "inside an allowed band" in done.stdout
    refused = flexsat("waterfall", system, "--points", "1", "--out", tmp_path)
    assert refused.returncode == 2
    assert "--points 1: must be 2 or more" in refused.stderr
