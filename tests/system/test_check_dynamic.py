"""The dynamic checks find each defect that was seeded into an FMU, and nothing else; our own FMUs pass."""

import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from fmus.bad.bad_fmus import XML, bad_fmu, forgetful_sensors
from lockstep.check.dynamic_checks import CHECKS, dynamic_checks
from lockstep.check.report.finding import Finding

Check = Callable[..., dict[str, Finding]]
MEMORY_STEPS = 3000  # a leak of half a kilobyte a step is seen in so few
pytestmark = pytest.mark.skipif(shutil.which("gcc") is None, reason="the bad FMUs are compiled with gcc")


def checked(path: Path, **options: object) -> dict[str, Finding]:
    """Return the findings by check; each was reported once, when it came."""
    reported: list[Finding] = []
    findings = dynamic_checks(path, reported.append, **{"steps": MEMORY_STEPS, **options})
    assert reported == findings
    return {finding.check: finding for finding in findings}


def of_note(findings: dict[str, Finding]) -> dict[str, str]:
    """Return the checks that a receiver would look at, with their status."""
    return {name: found.status for name, found in findings.items() if found.status in ("warning", "error")}


def test_the_good_one_passes(tmp_path):
    findings = checked(bad_fmu(tmp_path))

    assert tuple(findings) == CHECKS
    assert {name: found.status for name, found in findings.items() if found.status != "pass"} == {
        "dynamic.latency": "info",
        "dynamic.cost": "info",
    }
    assert findings["dynamic.latency"].numbers == {"scaled [steps]": 0.0, "filtered [steps]": 1.0}
    assert findings["dynamic.step"].numbers == {"steps": 200, "step [s]": 0.01}


@pytest.mark.parametrize(
    ("defect", "check", "status", "words"),
    [
        ("HIDDEN_GENERATOR", "state", "error", "set back, the run continues differently: scaled is"),
        ("READS_WORKING_DIRECTORY", "working_directory", "error", "in the folder that it is unpacked to: scaled is"),
    ],
)
def test_one_defect_is_found_where_it_is_and_nothing_else(tmp_path, defect, check, status, words):
    findings = checked(bad_fmu(tmp_path, defect))

    assert of_note(findings) == {f"dynamic.{check}": status}
    assert words in findings[f"dynamic.{check}"].message


@pytest.mark.parametrize(
    ("defect", "check", "status", "words"),
    [
        ("LEAVES_A_FILE", "working_directory", "error", "leaves files in the working directory: trace.log"),
        ("NOT_A_NUMBER", "step", "error", "output scaled is nan after the step at t = 0.07 s"),
        ("ACCEPTS_ANY_STEP", "refuses_step", "error", "silently accepts a step of 0.015 s and of 0.005 s"),
        ("DIRECT_FEEDTHROUGH", "latency", "error", "seen without a step: filtered <- rate;"),
        (
            "UNDECODED_LOCATION",
            "resource_location",
            "error",
            "unpacked to a path with spaces: cannot be instantiated",
        ),
        ("NEEDS_AUTHORITY", "resource_location", "warning", "without an authority, file:/path: cannot be instantiated"),
        ("LEAKS", "memory", "error", "bytes a step"),
        ("SHARED_BETWEEN_INSTANCES", "second_instance", "error", "stepped in turn with a second: filtered is"),
        ("HIDDEN_ARRAY", "state", "error", "set back, the run continues differently: scaled is"),
        ("FORGETS_WHEN_SERIALISED", "state", "error", "restored in another process, the run differs: scaled is"),
        ("NEEDS_WORKING_DIRECTORY", "working_directory", "error", "only if the working directory is the folder"),
        ("FEEDTHROUGH_WITHIN_STEP", "latency", "warning", "within the step"),
        ("RESET_KEEPS_GENERATOR", "reset", "error", "after 100 steps and fmi2Reset: scaled is"),
        ("TRUNCATES_TIME", "awkward_times", "warning", "times accumulated, as hosts do: scaled is"),
        ("BAD_REFERENCE_CRASHES", "invalid_reference", "error", "crashed with SIGSEGV in fmi2GetReal at t = 0.01 s"),
        ("SILENT_ERRORS", "logging", "warning", "nothing is logged"),
        ("UNDECLARED_CATEGORY", "logging", "warning", "logs in the category 'panic'; declared are logStatusError"),
        ("LOGS_ANOTHER_NAME", "logging", "warning", "names the instance 'somebody'"),
    ],
)
def test_one_check_finds_its_defect(tmp_path, defect, check, status, words):
    findings = checked(bad_fmu(tmp_path, defect), only=[f"dynamic.{check}"])

    assert of_note(findings) == {f"dynamic.{check}": status}
    assert words in findings[f"dynamic.{check}"].message


ANY_STEP = XML.replace('VariableCommunicationStepSize="false"', 'VariableCommunicationStepSize="true"')


@pytest.mark.parametrize(
    ("xml", "defects", "status"),
    [
        (ANY_STEP, ("ACCEPTS_ANY_STEP", "INTEGRATES"), "info"),  # the answer vanishes with the step
        (ANY_STEP, ("ACCEPTS_ANY_STEP", "FEEDTHROUGH_WITHIN_STEP"), "warning"),
        (XML, ("INTEGRATES",), "warning"),  # from outside it cannot be distinguished from feedthrough
    ],
)
def test_a_short_step_distinguishes_integration_from_feedthrough(tmp_path, xml, defects, status):
    found = checked(bad_fmu(tmp_path, *defects, xml=xml), only=["dynamic.latency"])["dynamic.latency"]

    assert found.status == status
    assert ("filtered <- rate: 0 steps, feedthrough" in found.details) == (status == "warning")
    assert "scaled <- level: 0 steps, feedthrough" in found.details
    assert ("undeclared feedthrough within the step" in found.message) == (status == "warning")


def test_a_declared_feedthrough_that_is_none_is_reported(tmp_path):
    xml = ANY_STEP.replace('index="5" dependencies=""', 'index="5" dependencies="1 2"', 1)
    path = bad_fmu(tmp_path, "ACCEPTS_ANY_STEP", "INTEGRATES", xml=xml)

    found = checked(path, only=["dynamic.latency"])["dynamic.latency"]

    assert found.status == "info"
    assert "filtered <- level: declared, but no answer within 104 steps" in found.details
    assert "filtered <- rate: declared, but not seen as feedthrough" in found.details


@pytest.mark.parametrize("flag", ["canGetAndSetFMUstate", "canSerializeFMUstate"])
def test_what_is_not_declared_is_not_asked_for(tmp_path, flag):
    xml = XML.replace(f'{flag}="true"', "")

    found = checked(bad_fmu(tmp_path, "FORGETS_WHEN_SERIALISED", xml=xml), only=["dynamic.state"])["dynamic.state"]

    assert found.status == ("skipped" if flag == "canGetAndSetFMUstate" else "pass")


def test_one_instance_in_a_process_is_respected(tmp_path):
    xml = XML.replace("<CoSimulation", '<CoSimulation canBeInstantiatedOnlyOncePerProcess="true"')
    path = bad_fmu(tmp_path, "SHARED_BETWEEN_INSTANCES", xml=xml)

    findings = checked(path, only=["dynamic.second_instance", "dynamic.side_by_side", "dynamic.latency"])

    assert of_note(findings) == {}
    assert findings["dynamic.second_instance"].status == findings["dynamic.side_by_side"].status == "skipped"


def test_inputs_that_it_refuses_to_move_stay_where_they_are(tmp_path):
    findings = checked(bad_fmu(tmp_path, "REFUSES_MOVING_INPUTS"), only=["dynamic.reset", "dynamic.latency"])

    assert of_note(findings) == {}
    assert "inputs keep their start values, as it refuses others" in findings["dynamic.step"].message
    assert "fmi2SetReal returned fmi2Error at t = 0.01 s" in findings["dynamic.step"].details[0]
    assert "level: a small change is refused" in findings["dynamic.latency"].details[0]


@pytest.mark.parametrize("defect", ["SEEDED_BY_CLOCK", "SEEDED_BY_PROCESS", "SEEDED_BY_LAYOUT"])
def test_without_repetition_nothing_is_compared(tmp_path, defect):
    findings = checked(bad_fmu(tmp_path, defect))

    assert of_note(findings) == {"dynamic.repeat": "error"}
    assert "in a new process: scaled is" in findings["dynamic.repeat"].message
    assert findings["dynamic.state"].status == findings["dynamic.reset"].status == "skipped"
    assert "dynamic.repeat" in findings["dynamic.state"].message


@pytest.mark.parametrize(
    ("defect", "check", "words"),
    [
        ("CRASHES", "step", "crashed with SIGSEGV in fmi2DoStep at t = 0.05 s"),
        ("EXITS", "step", "ended the process with exit code 3 in fmi2DoStep at t = 0.05 s"),
        ("LEAVES_A_PROCESS", "step", "a process that it started continued after the end of its own"),
        ("EATS_MEMORY", "step", "crashed with SIGSEGV in fmi2DoStep at t = 0.05 s"),
        ("HANGS", "step", "no answer within 6 s in fmi2DoStep at t = 0.05 s"),
        ("CRASHES_AT_UNLOAD", "instantiate", "crashed with SIGABRT in unloading the library"),
    ],
)
def test_what_takes_its_process_down_ends_no_report(tmp_path, monkeypatch, defect, check, words):
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    monkeypatch.setattr("tempfile.tempdir", None)

    # short, so that the test ends; long, so that a loaded machine loads a library in it
    limit = 6.0 if defect == "HANGS" else 60.0
    findings = checked(bad_fmu(tmp_path / "built", defect), time_limit=limit)

    assert tuple(findings) == CHECKS
    assert of_note(findings) == {f"dynamic.{check}": "error"}
    assert words in findings[f"dynamic.{check}"].message
    later = CHECKS[CHECKS.index(f"dynamic.{check}") + 1 :]
    assert {findings[name].status for name in later} == {"skipped"}
    assert [path.name for path in tmp_path.iterdir()] == ["built"], "temporary folders are gone"
    assert not processes_below(tmp_path), "no process is left"


def processes_below(folder: Path) -> list[str]:
    """Return the command lines of processes that name a folder."""
    lines = []
    for path in Path("/proc").glob("[0-9]*/cmdline"):
        try:
            lines.append(path.read_bytes().replace(b"\0", b" ").decode())
        except OSError:  # it has ended
            continue
    return [line for line in lines if str(folder) in line]


def test_spoilt_files_of_a_check_end_no_report(tmp_path):
    findings = checked(bad_fmu(tmp_path, "SPOILS_ITS_FOLDERS"), only=["dynamic.repeat", "dynamic.logging"])

    assert of_note(findings) == {"dynamic.repeat": "error"}
    assert "the check could not be carried out" in findings["dynamic.repeat"].message
    assert findings["dynamic.logging"].status == "pass"


def test_what_is_no_fmu_is_one_finding(tmp_path):
    (tmp_path / "empty.fmu").write_bytes(b"nothing")

    findings = checked(tmp_path / "empty.fmu")

    assert of_note(findings) == {"dynamic.instantiate": "error"}
    assert "not a readable zip file" in findings["dynamic.instantiate"].message


def test_another_fmu_beside_it_is_named(tmp_path):
    first, second = bad_fmu(tmp_path / "first"), bad_fmu(tmp_path / "second", "HIDDEN_ARRAY")

    findings = checked(first, others=[second], only=["dynamic.side_by_side"])

    assert findings["dynamic.side_by_side"].message == "the same bits together with bad.fmu, whichever is loaded first"


@pytest.mark.parametrize(
    ("name", "answers"),
    [
        # a torque about the normal of the plate moves no accelerometer at once: declared with the others
        (
            "centralised/plant",
            {
                "accelerometer_site.acceleration <- jitter.force_z: 0 steps, feedthrough",
                "accelerometer_site.acceleration <- jitter.torque_z: declared, but not seen as feedthrough",
                "attitude.mrp <- wheel.torque: 0 steps",
            },
        ),
        ("distributed/sensors", {"gyro.rate <- gyro_site.rate: 0 steps, feedthrough"}),
        # an attitude counts only while its flag is up; six wheels, as the inputs of each take time
        ("centralised/controller", {"estimate.mrp <- star_tracker.mrp: 0 steps, feedthrough",
                                    "estimate.mrp <- gyro.rate: 0 steps, feedthrough"}),
    ],
)  # fmt: skip
def test_flexsat_fmus_pass(fmus, name, answers):
    findings = checked(fmus / f"{name}.fmu")

    assert of_note(findings) == {}, findings
    assert not [found.check for found in findings.values() if found.status == "skipped"]
    latency = findings["dynamic.latency"]
    assert latency.status == "info"
    assert answers <= set(latency.details)
    # a motor torque is internal: the total angular momentum answers to it with the rounding of its large parts
    momentum = [line for line in latency.details if line.startswith("angular_momentum")]
    assert not [line for line in momentum if "feedthrough" in line]
    answered = [line for line in momentum if line.startswith("angular_momentum <- wheel.torque: 0")]
    assert len(answered) == (name == "centralised/plant")


def test_a_generator_left_out_of_our_state_is_found(fmus, tmp_path):
    forgetful_sensors(tmp_path / "forgetful.fmu", fmus / "centralised" / "sensors.fmu")

    good = checked(fmus / "centralised" / "sensors.fmu", only=["dynamic.state"])["dynamic.state"]
    bad = checked(tmp_path / "forgetful.fmu", only=["dynamic.state"])["dynamic.state"]

    assert good.status == "pass", good
    assert bad.status == "error"
    assert "set back, the run continues differently" in bad.message
