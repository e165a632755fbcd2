"""The paper's runs through native FMUs: times and differences, as text, in its file, on the page, and as exit code."""

import math
from dataclasses import replace

import pytest

from flexbench.cli.parser import main
from flexbench.engine.jobs import run_job
from flexbench.html.document import Paragraph, Table
from flexbench.loop.equivalence import Difference
from flexbench.report import paper_pages
from flexbench.report.study_table import native_blocks
from flexbench.studies.margins.study import FILE as FILE_OF_MARGINS
from flexbench.studies.paper import design_margins, paper
from flexbench.studies.paper import native as module
from flexbench.studies.paper.native import FILE, TOLERANCE, NativeRun, NativeStudy, read_native, write_native
from flexbench.studies.paper.native_table import (
    PORT_HEADER,
    RUN_HEADER,
    TITLE,
    objections,
    port_rows,
    remarks,
    run_rows,
)
from flexbench.studies.paper.table import Failed, Results
from lockstep.plain_table import plain_lines
from lockstep.results.read_run_record import read_run_record

TORQUE, RATE = "controller.wheel.torque", "plant.rate"


def difference(port, relative, element=1):
    return Difference(port=port, scalars=3, relative=relative, signal=f"{port}[{element}]", tolerance=TOLERANCE)


def run(name, python_time, native_time, *differences, failure=""):
    return NativeRun(
        run=name, python_time=python_time, native_time=native_time, differences=differences, failure=failure
    )


@pytest.fixture
def study():
    """Return a study of two runs: 3.6 times as fast, and in one of them another torque."""
    slew = run("distributed-slew-seed1", 100.0, 30.0, difference(TORQUE, 2e-12, 4), difference(RATE, 0.0))
    fine = run("centralised-slew-seed1", 80.0, 20.0, difference(TORQUE, 3e-11, 2), difference(RATE, 0.0))
    return NativeStudy(variant="corrected", seed=1, duration=300.0, runs=(slew, fine))


def test_a_run_through_both_kinds_of_fmus_gives_both_times_and_small_differences(delivered, tmp_path):
    plan = paper.plan_jobs(delivered, tmp_path, ["corrected"], [1], 0.05)
    job = replace(plan[("corrected", "centralised", "fine_pointing"), 1], metrics=False)
    run_job(job)
    (found,) = module.compare_natively([job], 1)

    folder = tmp_path / "centralised-fine-pointing-native-seed1"
    flown = [component["source"] for component in read_run_record(folder)[0]["component"]]
    parts = ("sensors", "controller", "plant")
    assert flown == [str(delivered / "centralised" / "native" / f"{part}.fmu") for part in parts]
    assert found.run == "centralised-fine-pointing-seed1"
    assert found.met
    assert found.python_time == read_run_record(job.folder)[0]["wall_time"]
    assert found.native_time > 0.0
    ports = {one.port: one for one in found.differences}
    assert ports[TORQUE].scalars == 6
    assert 0.0 < ports[RATE].relative < 1e-11  # 198 modes round otherwise; 3e-11 was seen over 300 s
    assert ports[RATE].signal in [f"{RATE}[{k}]" for k in (1, 2, 3)]
    assert ports["controller.reference.mrp"].relative == 0.0


def shown(study):
    """Return times and differences as the command prints them."""
    return "\n".join([TITLE, *plain_lines([RUN_HEADER, *run_rows(study)]),
                      *plain_lines([PORT_HEADER, *port_rows(study)]), *remarks(study)])  # fmt: skip


def test_the_text_has_both_times_and_the_signal_where_the_difference_is_largest(study):
    assert shown(study).splitlines() == [
        "Native FMUs against those in Python",
        "run                     Python [s]  native [s]  largest difference  in",
        "distributed-slew-seed1       100.0        30.0             2.0e-12  controller.wheel.torque[4]",
        "centralised-slew-seed1        80.0        20.0             3.0e-11  controller.wheel.torque[2]",
        "sum                          180.0        50.0                      3.6 times as fast",
        "port                     largest difference  in                          run",
        "controller.wheel.torque             3.0e-11  controller.wheel.torque[2]  centralised-slew-seed1",
        "corrected, robust, seed 1, runs of 300 s through the FMUs in Python and through those in C. Times are those of"
        " the runs, some of which ran at the same time.",
        "Differences are relative to the largest value of the port through the FMUs in Python.",
        "Equal in all runs: plant.rate.",
        "Largest difference: 3.0e-11 in controller.wheel.torque[2], centralised-slew-seed1; at most 1e-08 is allowed.",
    ]
    assert objections(study) == []


@pytest.fixture
def objectionable(study):
    """Return a study with a run that differs too much, one that is no number somewhere, and one that failed."""
    far = replace(study.runs[0], differences=(difference(TORQUE, 2e-8, 4), difference(RATE, 1e-12)))
    lost = replace(study.runs[1], differences=(difference(RATE, math.inf, 2),))
    failed = run("distributed-fine-pointing-seed1", 90.0, 0.0, failure="plant: crashed with SIGSEGV")
    return replace(study, runs=(far, lost, failed))


OBJECTIONS = [
    "distributed-slew-seed1, native: differs by 2.0e-08 in controller.wheel.torque[4], more than 1e-08",
    "centralised-slew-seed1, native: differs by inf in plant.rate[2], more than 1e-08",
    "distributed-fine-pointing-seed1, native: plant: crashed with SIGSEGV",
]


def test_each_run_that_differs_or_failed_is_objected_to(objectionable):
    assert objections(objectionable) == OBJECTIONS
    assert "plant.rate[2], centralised-slew-seed1; more than the 1e-08 that is allowed." in shown(objectionable)


def test_its_file_has_everything_and_the_page_shows_it(objectionable, study, tmp_path):
    write_native(tmp_path, objectionable)
    assert read_native(tmp_path) == objectionable
    write_native(tmp_path, study)
    blocks = native_blocks(tmp_path)
    runs, ports = (block for block in blocks if isinstance(block, Table))
    assert runs.rows[0] == ["distributed-slew-seed1", "100.0", "30.0", "2.0e-12", "controller.wheel.torque[4]"]
    assert ports.rows == [[TORQUE, "3.0e-11", "controller.wheel.torque[2]", "centralised-slew-seed1"]]
    assert Paragraph("Equal in all runs: plant.rate.") in blocks
    (tmp_path / FILE).unlink()
    assert native_blocks(tmp_path) == []


@pytest.fixture
def command(monkeypatch, tmp_path, capsys):
    """Return a function that calls the command, with its studies replaced; and what the native one was asked for."""
    asked = []

    def call(study, *options, reason=""):
        def build(*_, options, without_native):
            asked.append(options.in_c)
            if reason:
                without_native(reason)

        def natively(*arguments):
            asked.append(arguments[2:])
            return study

        monkeypatch.setattr("flexbench.loop.build.build_all", build)
        monkeypatch.setattr(paper, "run_paper", lambda *_: Results(metrics={}, seeds=[1], duration=300.0))
        monkeypatch.setattr(module, "run_natively", natively)
        monkeypatch.setattr(paper_pages, "draw_paper", lambda *_: [])
        monkeypatch.setattr(paper_pages, "report_paper", lambda folder, *_: folder / "report.html")
        code = main(["paper", "--out", str(tmp_path), "--jobs", "2", *options])
        return code, *capsys.readouterr(), asked

    return call


def test_the_command_flies_them_and_ends_with_exit_code_1_where_they_differ(command, study, objectionable):
    variants = ["as_published", "corrected", "published_design"]
    code, out, error, asked = command(study)
    assert (code, asked) == (0, [("2.0",), (variants, 1, 300.0, 2, [])])
    assert error == ""
    assert shown(study) in out
    assert "table.json, native.json and every run" in out

    code, out, error, _ = command(objectionable)
    assert (code, error) == (1, "".join(f"flexsat: {line}\n" for line in OBJECTIONS))
    assert shown(objectionable) in out


def test_python_leaves_them_out_with_the_result_of_an_earlier_study(command, study, tmp_path):
    write_native(tmp_path, study)
    code, out, _, asked = command(study, "--python")
    assert (code, asked) == (0, [()])
    assert "ative" not in out
    assert not (tmp_path / FILE).exists()


def test_where_they_cannot_be_built_a_note_says_so_and_the_study_goes_on(command, study):
    code, out, _, asked = command(study, reason="cc cannot compile plant_centralised: no")
    assert (code, asked) == (0, [("2.0",)])
    assert (
        "no runs through native FMUs, as these cannot be built here: cc cannot compile plant_centralised: no\n" in out
    )
    assert "report.html" in out


def test_the_rest_of_a_study_is_flown_where_a_run_failed(command, study, monkeypatch, tmp_path, capsys):
    key = ("corrected", "distributed", "slew")
    folder = tmp_path / "distributed-slew-seed1"
    failed = Failed(key=key, seed=1, folder=folder, cause="plant: refused at 1 s.")
    lame = Results(metrics={}, seeds=[1], duration=300.0, failed=(failed,))
    command(study)
    capsys.readouterr()
    monkeypatch.setattr(paper, "run_paper", lambda *_: lame)
    asked = []
    monkeypatch.setattr(module, "run_natively", lambda *arguments: asked.append(arguments[-1]) or study)
    monkeypatch.setattr(paper_pages, "draw_paper", lambda *arguments: asked.append(arguments[-1]) or [])
    monkeypatch.setattr(paper_pages, "report_paper", lambda *arguments: asked.append(arguments[-1]))

    assert main(["paper", "--out", str(tmp_path), "--corrected"]) == 1
    assert asked == [[folder], [folder], (failed,)]
    line = f"1 of 1 runs failed, table and page have the others: {folder.name}: plant: refused at 1 s ({folder})"
    assert capsys.readouterr().err == f"flexsat: {line}\n"


def test_margins_are_determined_where_they_are_asked_for(command, study, monkeypatch, tmp_path):
    asked = []
    monkeypatch.setattr(
        design_margins, "find_margins", lambda *arguments: asked.append(arguments[1:4]) or ["margins: no"]
    )
    old = design_margins.loop_folder(tmp_path, "distributed", "corrected")
    old.mkdir(parents=True)
    (old / FILE_OF_MARGINS).write_text("{}")
    code, _, error, _ = command(study, "--corrected")
    assert (code, asked, old.exists()) == (0, [], False)  # of an earlier study

    code, out, error, _ = command(study, "--corrected", "--margins")
    assert (code, error) == (1, "flexsat: margins: no\n")
    assert asked == [(tmp_path, ["corrected", "published_design"], 1)]
    assert "disk margin" in out
