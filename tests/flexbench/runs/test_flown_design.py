"""A run is evaluated with the matrices of the FMUs that flew, and keeps them."""

from __future__ import annotations

import io
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from flexbench.cli.parser import main
from flexbench.report.derived_histories import derived_histories
from flexbench.runs.flown_design import FILE, planned_slew
from flexbench.runs.histories import lqr_cost, wheel_speed_deviation
from flexbench.runs.run_folder import read_run
from flexsat.fmu.reproducible_zip import npz_bytes
from flexsat.parameters import RPM
from flexsat.variants import AS_PUBLISHED
from lockstep import InputError

FASTER = 10.0 * RPM  # rad/s
MODEL = "resources/model.npz"


def changed_plant(original: Path, out: Path) -> dict[str, Any]:
    """Copy a plant's FMU with wheels that turn faster and stiffer modes; return its matrices."""
    with zipfile.ZipFile(original) as archive, zipfile.ZipFile(out, "w") as copy:
        for name in archive.namelist():
            content = archive.read(name)
            if name == MODEL:
                with np.load(io.BytesIO(content)) as arrays:
                    matrices = dict(arrays)
                matrices["corrected.nominal_speed"] = matrices["corrected.nominal_speed"] + FASTER
                matrices["corrected.frequency"] = 1.01 * matrices["corrected.frequency"]
                content = npz_bytes(matrices)
            copy.writestr(archive.getinfo(name), content)
    return {key.removeprefix("corrected."): value for key, value in matrices.items() if key.startswith("corrected.")}


@pytest.fixture(scope="module")
def flown(delivered: Path, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path, dict[str, Any]]:
    """Return a run of a plant with other matrices, its FMU, and these."""
    folder = tmp_path_factory.mktemp("flown")
    plant = folder / "plant.fmu"
    matrices = changed_plant(delivered / "centralised" / "plant.fmu", plant)
    system = delivered / "centralised" / "slew.ssd"
    words = [
        "--replace",
        f"plant={plant}",
        "--stop-time",
        "0.05",
        "--accept-infeasible",
        "--set",
        "controller.wheel.torque_limit=2",
    ]
    assert main(["run", str(system), *words, "--out", str(folder / "run")]) == 0
    return folder / "run", plant, matrices


def test_wheels_modes_and_weights_are_those_of_the_fmus(flown):
    folder, _, matrices = flown
    design = read_run(folder).flown

    assert np.array_equal(design.nominal_speed, matrices["nominal_speed"])
    assert np.array_equal(design.frequency, matrices["frequency"])
    assert np.array_equal(design.rotation, matrices["mass_matrix"][3:6, 6:])
    slope = [axis @ slope for axis, slope in zip(matrices["wheel_axis"], matrices["wheel_slope"], strict=True)]
    assert np.allclose(design.wheel_axial_slope, slope, rtol=1e-12, atol=1e-15)
    assert design.period == 0.005
    assert design.cost is not None
    assert list(design.cost.modes) == list(range(25))
    # the wheels start at the speed that is nominal for this plant, and hold it for a moment
    run = read_run(folder)
    (deviation,) = (one for one in derived_histories(run.signals(), run) if one.name == "wheel speed less nominal")
    assert np.abs(deviation.values[0]).max() < 1e-3  # rpm; 10 with the stock design


def test_the_slew_is_planned_with_the_parameters_of_the_run(flown):
    run = read_run(flown[0])
    command = run.command
    assert command is not None
    design = run.flown
    plan = planned_slew(design, command)
    # two wheels an axis, 80 % of 2 N.m each, against the inertia about x
    assert plan.coast_rate / plan.ramp == pytest.approx(2.0 * 0.8 * 2.0 / design.slew_inertia[0, 0], rel=1e-9)
    assert plan.start == command.time == 5.0


def test_what_needs_the_whole_design_refuses_another_one(flown):
    with pytest.raises(InputError, match=r"flew another design than this version's \(nominal_speed differs\)"):
        _ = read_run(flown[0]).design


def test_the_design_stays_with_the_results_when_the_fmus_change(flown):
    folder, plant, matrices = flown
    content = plant.read_bytes()
    kept = (folder / FILE).read_bytes()
    try:
        plant.write_bytes(content + b"later")
        assert np.array_equal(read_run(folder).flown.frequency, matrices["frequency"])
        (folder / FILE).unlink()
        with pytest.raises(InputError, match=r"plant\.fmu: has changed since it flew as plant, and .* simulate again"):
            _ = read_run(folder).flown
        plant.unlink()
        with pytest.raises(InputError, match=r"plant\.fmu: the FMU of plant that flew is gone"):
            _ = read_run(folder).flown
        plant.write_bytes(content)
        assert np.array_equal(read_run(folder).flown.frequency, matrices["frequency"])  # a run without design.npz
        (folder / FILE).write_bytes(b"torn")
        with pytest.raises(InputError, match=r"design\.npz: cannot be read"):
            _ = read_run(folder).flown
    finally:
        plant.write_bytes(content)
        (folder / FILE).write_bytes(kept)


def test_as_published_has_fewer_modes_than_the_plant_has_ports(delivered, tmp_path):
    system = delivered / "centralised" / "slew.ssd"
    words = ["--as-published", "--stop-time", "0.02", "--accept-infeasible"]
    assert main(["run", str(system), *words, "--out", str(tmp_path / "run")]) == 0
    run = read_run(tmp_path / "run")
    design, signals = run.flown, run.signals()

    assert (design.variant, design.modes) == (AS_PUBLISHED, 25)
    assert signals["plant.modal.velocity"].shape[1] > design.modes
    assert np.abs(wheel_speed_deviation(signals, design)).max() < 1e-3  # rad/s: at rest at the nominal speed
    total, control = lqr_cost(signals, design)
    assert np.all(total >= control)
    assert np.isfinite(total).all()
