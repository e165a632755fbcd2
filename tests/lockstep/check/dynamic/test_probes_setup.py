"""The probe of start values finds FMUs that lose what is set before fmi2SetupExperiment, and those that lose all."""

import shutil
import zipfile
from dataclasses import replace

import pytest

from fmus.setup.setup_fmu import setup_fmu
from lockstep.check.dynamic.experiment import read_experiment
from lockstep.check.dynamic.probe_process import ProbeTask
from lockstep.check.dynamic.probes_setup import start_values
from lockstep.processes.last_call import SIZE, LastCall

pytestmark = pytest.mark.skipif(shutil.which("gcc") is None, reason="the FMUs are compiled with gcc")


def probed(folder, resets, **changes):
    """Return what the probe finds."""
    with zipfile.ZipFile(setup_fmu(folder, resets=resets)) as archive:
        archive.extractall(folder / "unpacked")
    experiment = replace(read_experiment(folder / "unpacked"), **changes)
    memory = LastCall(bytearray(SIZE))
    task = ProbeTask(experiment=experiment, folder=folder / "unpacked", work=folder, options={}, last_call=memory)
    return start_values(task)


@pytest.mark.parametrize(
    ("resets", "status", "message"),
    [
        ("", "pass", "3 variables are kept, set before fmi2SetupExperiment or after it"),
        (
            "RESETS",
            "warning",
            "loses what is set before fmi2SetupExperiment: p, whole, u; p is 0.5 instead of 0.501",
        ),
        ("RESETS_LATE", "warning", "loses start values even if they are set after fmi2SetupExperiment: p, whole, u"),
    ],
)
def test_lost_start_values_are_found(tmp_path, resets, status, message):
    found = probed(tmp_path, resets)

    assert (found.status, found.message) == (status, message)


def test_fmu_without_a_value_to_set_is_skipped(tmp_path):
    assert probed(tmp_path, "RESETS", parameters=(), inputs=()).status == "skipped"
