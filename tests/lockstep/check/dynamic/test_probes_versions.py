"""The probes judge FMUs of every version, those that end their simulation, and steps that are no test."""

import time
import zipfile
from dataclasses import replace

import psutil
import pytest

from lockstep.check.dynamic import probes_life, probes_load, probes_refusal, probes_setup, probes_state
from lockstep.check.dynamic.experiment import experiment_of
from lockstep.check.dynamic.probe_process import ProbeResult, ProbeTask
from lockstep.check.dynamic.probe_runner import ProbeRunner
from lockstep.check.dynamic_checks import CHECKS, CheckSequence, dynamic_checks
from lockstep.operating_system import can_serve_copies
from lockstep.processes.last_call import SIZE, LastCall

VERSIONS = ["1.0", "2.0", "3.0"]


@pytest.fixture
def task_of(tmp_path):
    """Return a function that makes the task of probes of an FMU in this process, with the reference run made."""
    tasks = []

    def make(archive, **options):
        with zipfile.ZipFile(archive) as opened:
            opened.extractall(tmp_path / "unpacked")
        experiment = experiment_of(archive, tmp_path / "unpacked")
        options = {"archive": str(archive), "steps": 20, "seconds": 60.0, "initialised": False, **options}
        memory = LastCall(bytearray(SIZE))
        folder = tmp_path / "unpacked"
        tasks.append(ProbeTask(experiment=experiment, folder=folder, work=tmp_path, options=options, last_call=memory))
        return tasks[-1]

    yield make
    for task in tasks:
        for instance in task.instances:
            instance.close()


@pytest.mark.parametrize("version", VERSIONS)
def test_a_good_fmu_of_any_version_passes_every_probe(task_of, reference_fmu, version):
    task = task_of(reference_fmu("integrator", version))
    assert probes_life.instantiate(task).status == "pass"
    assert probes_life.initialise(task).message == "1 outputs, all finite"
    assert probes_life.step(task).numbers == {"steps": 20, "step [s]": 0.001}
    assert probes_life.other_phase(task).status == "pass"
    for probe in (probes_life.reset, probes_life.second_instance, probes_life.second_load, probes_life.awkward_times):
        assert probe(task).status == "pass"
    assert probes_setup.start_values(task).status == ("pass" if version == "2.0" else "skipped")
    assert probes_refusal.invalid_reference(task).message == "each is refused or logged"
    assert probes_load.cost(task).status == "info"
    assert probes_load.memory(task).message.startswith("20 steps")
    assert task.experiment.saves_state == (version != "1.0")
    if task.experiment.saves_state:
        assert probes_state.roll_back(task).numbers["state [B]"] > 0
        assert probes_state.restore(task).status == "pass"
    found = probes_refusal.logging(task)
    assert f"{task.experiment.prefix}Error" in found.details[0]
    # version 2.0 of these models has no declared categories, and version 1.0 none at all
    assert found.status == ("pass" if version == "1.0" else "warning")


@pytest.mark.parametrize("version", ["2.0", "3.0"])
@pytest.mark.parametrize(("starts", "done"), [((), 10), ((("Integer", 3, 7), ("Integer", 4, 6)), 5)])
def test_probes_keep_within_the_steps_before_a_regular_end(task_of, reference_fmu, version, starts, done):
    """The stair ends instead of its eleventh step, or after its sixth if its parameters `mode` and `at` say so."""
    task = task_of(reference_fmu("stair", version))
    task = replace(task, experiment=replace(task.experiment, starts=starts))
    found = probes_life.step(task)
    assert (found.status, found.numbers["steps"], found.numbers["ended after"]) == ("pass", done, done)
    assert "asked for the end of the simulation" in found.message
    task = replace(task, experiment=replace(task.experiment, most_steps=done))
    for probe in (probes_life.reset, probes_life.second_load, probes_state.roll_back):
        assert probe(task).status == "pass"
    assert probes_load.memory(task).message.startswith("20 steps")  # in as many runs as it takes
    assert probes_load.cost(task).status == "info"


def test_a_step_of_nan_is_no_test(reference_fmu):
    """Reference FMUs integrate towards the end of the step: with not-a-number they never return."""
    found = dynamic_checks(reference_fmu("dahlquist", "2.0"), lambda _: None, only=["dynamic.refuses_step"])
    assert {(f.check, f.status) for f in found} == {(c, "pass") for c in (*CHECKS[:3], "dynamic.refuses_step")}
    assert found[-1].message == "makes steps of 0.05, 0.1 and 0.2 s; zero and negative ones are refused"


@pytest.mark.parametrize(
    ("first", "second", "same"),
    [
        ("crashed with SIGSEGV in fmi2FreeInstance, after 0.3 s", "in a new process: crashed with SIGSEGV in "
         "fmi2FreeInstance, after 1.2 s", True),
        ("no answer within 60 s in fmi2DoStep at t = 0.01 s", "times accumulated: no answer within 80 s in "
         "fmi2DoStep at t = 0.5 s", True),
        ("crashed with SIGSEGV in fmi2Reset, after 0.3 s", "crashed with SIGSEGV in fmi2GetReal, after 0.3 s", False),
        ("fmi2Terminate returned fmi2Error at t = 1 s: no", "fmi2Terminate returned fmi2Error at t = 2 s: no", True),
        ("after fmi2Reset: x is 1 instead of 2 after step 3", "a copy: x is 1 instead of 2 after step 3", False),
    ],
)  # fmt: skip
def test_one_cause_is_one_error(tmp_path, first, second, same):
    runner = ProbeRunner(archive=tmp_path, work=tmp_path, time_limit=1.0)
    checks = CheckSequence(runner, lambda _: None, 1, (), ())
    for check, message in (("dynamic.reset", first), ("dynamic.second_load", second)):
        checks.add(check, ProbeResult(status="error", message=message))

    statuses = [finding.status for finding in checks.findings]
    assert statuses == (["error", "skipped"] if same else ["error", "error"])
    assert not same or checks.findings[1].message == f"not checked: as dynamic.reset: {second}"


def test_probes_go_on_in_new_processes_where_an_fmu_has_killed_what_they_are_copies_of(reference_fmu, tmp_path):
    before = psutil.Process().children()
    with ProbeRunner(archive=reference_fmu("dahlquist", "2.0"), work=tmp_path, time_limit=60.0) as runner:
        experiment = experiment_of(runner.archive, runner.unpack())
        assert runner.run(probes_life.initialise, experiment).status == "pass"
        originals = [child for child in psutil.Process().children() if child not in before]
        assert len(originals) == can_serve_copies()
        for original in originals:
            original.kill()
            while original.status() != psutil.STATUS_ZOMBIE:
                time.sleep(0.01)
        assert runner.run(probes_life.initialise, experiment).status == "pass"
        assert [child for child in psutil.Process().children() if child not in before] == []
