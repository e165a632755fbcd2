"""Checks of whole files: FMUs of FMI 1.0 and 3.0, faults of other platforms, and one error for one cause."""

import zipfile

import pytest

from lockstep.check.check_fmu import check_fmu
from lockstep.check.report.check_report import fails
from lockstep.fmi.platforms import PLATFORMS


def found(path, **options):
    """Return status and message of each check."""
    report = check_fmu(path, **options)
    return {finding.check: (finding.status, finding.message) for finding in report.findings}, fails([report], False)


def errors(findings):
    """Return the checks with an error."""
    return [check for check, (status, _) in findings.items() if status == "error"]


@pytest.mark.parametrize(
    ("version", "expected"),
    [
        ("1.0", {"static.kind": ("pass", "feedthrough, made by an unnamed tool"),
                 "static.unknowns": ("skipped", "FMI 1.0 has no ModelStructure"),
                 "static.functions": ("pass", "25 functions; no optional capability"),
                 "static.names": ("pass", "10 names, flat")}),
        ("3.0", {"static.kind": ("pass", "feedthrough, made by an unnamed tool"),
                 "static.unknowns": ("info", "no dependencies declared for Float64_out, Float32_out, Int8_out, "
                                             "Int16_out, and 15 more: importers must assume feedthrough from every "
                                             "input"),
                 "static.functions": ("pass", "39 functions; canGetAndSetFMUstate, canSerializeFMUstate"),
                 "static.names": ("pass", "40 names, flat")}),
    ],
)  # fmt: skip
def test_file_of_another_version_gets_every_static_check(reference_fmu, version, expected):
    findings, failed = found(reference_fmu("feedthrough", version), dynamic=False)

    assert not failed, findings
    assert {check: findings[check] for check in expected} == expected
    for check in ("static.schema", "static.fmpy", "static.variables", "static.aliases", "static.instances"):
        assert findings[check][0] == "pass", findings[check]
    assert findings["static.platforms"] == ("pass", PLATFORMS[version])
    assert findings["static.dependencies"][1].startswith("needs libc.so.6")


@pytest.mark.parametrize(
    ("old", "new", "check", "says"),
    [
        ('<Output valueReference="1"/>', "", "static.unknowns", "Outputs lacks 1 of 2: height"),
        ('name="height" ', 'name="height" unit="furlong" ', "static.units",
         "unit 'furlong' is used by height but not defined"),
        ('name="height"', 'name="counter"', "static.names", "counter: more than one variable of this name"),
        ('name="last" valueReference="2" causality="parameter" variability="fixed"',
         'name="last" valueReference="2" causality="parameter" variability="discrete"', "static.variables",
         "causality parameter with variability discrete is not allowed"),
    ],
)  # fmt: skip
def test_offence_of_a_description_of_fmi_3_is_found_by_its_check(reference_fmu, tmp_path, old, new, check, says):
    path = tmp_path / "spoilt.fmu"
    with zipfile.ZipFile(reference_fmu("stair", "3.0")) as source, zipfile.ZipFile(path, "w") as target:
        for member in source.infolist():
            content = source.read(member)
            if member.filename == "modelDescription.xml":
                assert old in content.decode()
                content = content.decode().replace(old, new, 1).encode()
            target.writestr(member, content)
    findings, failed = found(path, dynamic=False)

    assert failed
    assert says in findings[check][1]
    assert errors(findings) == [check]


def test_fmu_that_cannot_be_instantiated_is_one_error(reference, tmp_path):
    findings, failed = found(reference.build("stair", "3.0", tmp_path, token="another"))

    assert failed
    assert findings["dynamic.instantiate"] == ("error", "cannot be instantiated: wrong instantiation token")
    assert errors(findings) == ["dynamic.instantiate"]


def test_fmu_that_the_master_does_not_support_fails(reference, tmp_path):
    clock = '<Clock name="tick" valueReference="901" causality="input" intervalVariability="triggered"/>'
    findings, failed = found(reference.build("stair", "3.0", tmp_path, more=clock))

    assert failed
    assert errors(findings) == ["static.kind"]
    assert "has clocks (tick), which the master cannot drive" in findings["static.kind"][1]
    assert findings["dynamic.run"][0] == "skipped"
