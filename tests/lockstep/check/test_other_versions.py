"""Checks of FMUs of FMI 1.0 and 3.0: fewer checks, and the report states their scope."""

import pytest

from lockstep.check.check_fmu import check_fmu
from lockstep.check.report.check_report import fails


def found(path, **options):
    """Return status and message of each check."""
    report = check_fmu(path, **options)
    return {finding.check: (finding.status, finding.message) for finding in report.findings}, fails([report], False)


@pytest.mark.parametrize("version", ["1.0", "3.0"])
def test_good_fmu_passes_and_runs(reference_fmu, version):
    findings, failed = found(reference_fmu("feedthrough", version))

    assert not failed
    assert findings["static.kind"] == ("pass", f"feedthrough, {10 if version == '1.0' else 62} scalars")
    assert findings["static.fmpy"][0] == "pass"
    assert findings["dynamic.run"] == ("pass", "20 steps of 0.01 s in a process of its own, every output finite")
    assert findings["static.scope"][0] == "info"
    assert f"checked for FMI 2.0 only; this is FMI {version}" in findings["static.scope"][1]


def test_fmu_that_does_not_run_fails_with_its_message(reference, tmp_path):
    path = reference.build("stair", "3.0", tmp_path, token="another")
    findings, failed = found(path)

    assert failed
    assert findings["dynamic.run"] == ("error", "cannot be instantiated: wrong instantiation token")
    static, failed = found(path, dynamic=False)
    assert not failed
    assert "dynamic.run" not in static


def test_fmu_that_the_master_does_not_support_fails(reference, tmp_path):
    clock = '<Clock name="tick" valueReference="901" causality="input" intervalVariability="triggered"/>'
    findings, failed = found(reference.build("stair", "3.0", tmp_path, more=clock))

    assert failed
    assert findings["static.kind"][0] == "error"
    assert "has clocks (tick), which the master cannot drive" in findings["static.kind"][1]
