"""`flexsat run` runs what has no spacecraft: one FMU alone."""

import shutil

import numpy as np
import pytest

from flexbench.cli.parser import main
from lockstep import read_signals


def test_one_fmu_alone_runs_with_a_default_step_and_without_metrics(reference_fmu, tmp_path, capsys):
    fmu = tmp_path / "model.fmu"
    shutil.copy(reference_fmu("integrator", "2.0"), fmu)
    words = ["run", str(fmu), "--out", str(tmp_path / "out"), "--share-process", "model", "--set", "model.u=2"]
    assert main([*words, "--stop-time", "0.01"]) == 0
    said = capsys.readouterr()
    assert "model: neither the file nor the FMU gives a step size: stepped every 0.001 s" in said.err
    assert f"no metrics.json: {tmp_path / 'out'}: not a run of a flexsat system" in said.out
    assert not (tmp_path / "out" / "metrics.json").exists()
    x = read_signals(tmp_path / "out")["model.x"]
    # dx/dt = u - x / 2, from 1, with u = 2: steps that are exact but for rounding
    assert x[:6] == pytest.approx(4.0 - 3.0 * np.exp(-0.5e-3 * np.arange(6)), rel=1e-13)
