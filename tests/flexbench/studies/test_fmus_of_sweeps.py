"""Studies of many runs: native FMUs where they are built, the same numbers as with those in Python, and said so."""

import json
from dataclasses import replace
from functools import partial
from importlib import import_module
from types import SimpleNamespace

import numpy as np
import pytest

from flexbench.cli.parser import PROGRAM
from flexbench.engine.jobs import run_job
from flexbench.loop.fmu_choice import kind_of
from flexbench.studies.budget import split
from flexbench.studies.budget.evaluate import IndexWindows
from flexbench.studies.health import study as health
from flexbench.studies.layouts import study as layouts
from flexbench.studies.layouts.plan import ComparisonPlan as Layouts
from flexbench.studies.margins import study as margins
from flexbench.studies.robustness import model_errors as robustness
from flexsat.parameters import ALL_MODES
from flexsat.variants import CORRECTED

waterfall = import_module("flexbench.studies.waterfall.sweep")  # its package has the function under the name
ROUNDING = 1e-9  # relative: the two kinds add in different orders; in seconds the loop makes 1e-12 of that
KINDS = {"FMUs: native": {}, "FMUs: Python; --python": {"python": True}}


class Planned(Exception):
    """The study has planned its runs."""


def in_this_process(jobs, *_, **__):
    """Run jobs as `run_jobs`, without a process for each."""
    return [run_job(job) for job in jobs]


def studies(fmus, folder):
    """Return the start of each study, as a function of the options under test."""
    system = fmus / "centralised" / "fine_pointing.ssd"
    plan = robustness.VariationPlan(levels={}, modes=(40,))
    names = ("centralised", "distributed")
    known = SimpleNamespace(response=SimpleNamespace(nominal=np.full(6, 55.0)), variant=CORRECTED)  # of the design
    return {
        robustness: partial(robustness.run_robustness, fmus, folder, names, "slew", plan, (1,), 4.0, ALL_MODES),
        health: partial(health.run_health, system, folder, (1, 2), 50.0, {}, None),
        waterfall: partial(waterfall.sweep, system, known, folder, 2, 1.0, 1, (50.0, 60.0)),
        layouts: partial(layouts.run_layouts, fmus, folder, Layouts(seeds=(1, 2), duration={"fine_pointing": 1.0})),
        split: partial(split.split_budget, system, folder, 1, 300.0, IndexWindows()),
    }  # fmt: skip


def test_every_run_of_a_study_has_the_chosen_fmus(delivered, tmp_path, monkeypatch):
    def planned(jobs, *_, **__):
        raise Planned(jobs)

    for module, start in studies(delivered, tmp_path).items():
        monkeypatch.setattr(module, "run_jobs", planned)
        for text, options in KINDS.items():
            lines = []
            with pytest.raises(Planned) as ended:
                start(report=lines.append, **options)
            (jobs,) = ended.value.args
            assert lines[0] == text
            assert len(jobs) >= 2
            assert {job.native for job in jobs} == {text == "FMUs: native"}


def test_robustness_is_the_same_with_both_kinds(delivered, tmp_path, monkeypatch):
    monkeypatch.setattr(robustness, "run_jobs", in_this_process)
    plan, found = robustness.VariationPlan(levels={}, modes=()), []
    for kind, options in KINDS.items():
        folder = tmp_path / kind
        robustness.run_robustness(delivered, folder, ("distributed",), "fine_pointing", plan, (2,), 4.0, ALL_MODES,
                                  **options)  # fmt: skip
        (outcome,) = json.loads((folder / robustness.RESULT).read_text())
        assert outcome.pop("fmus") == kind.split()[1].rstrip(";")
        found.append({name: value for name, value in outcome.items() if isinstance(value, float)})
    native, python = found
    assert len(native) > 4
    assert native == pytest.approx(python, rel=ROUNDING)
    assert native != python  # they are not the same FMUs


def test_margins_are_the_same_with_both_kinds(delivered, tmp_path, monkeypatch, capsys):
    """The command measures the FMUs that it names; the response is measured along one axis, without the analysis."""

    def planned(loop, *_, **__):
        raise Planned(loop)

    monkeypatch.setattr(margins, "run_study", planned)
    settings = margins.MeasurementSettings(length=0.5, settle=1, periods=2, lines=4)
    found = []
    for text, option in zip(KINDS, ([], ["--python"]), strict=True):
        words = ["margins", str(delivered / "centralised" / "fine_pointing.ssd"), *option, "--out", str(tmp_path)]
        with PROGRAM.make_context("flexsat", words) as context, pytest.raises(Planned) as ended:
            PROGRAM.invoke(context)
        assert text in capsys.readouterr().out.splitlines()
        (loop,) = ended.value.args
        assert f"FMUs: {kind_of([loop.system])}" == text.partition(";")[0]
        along_x = replace(loop, names=loop.names[:1], directions=loop.directions[:, :1], makes=loop.makes[:1])
        measured, _ = margins.measure(along_x, settings, tmp_path / text)
        found.append(measured.of("x")[0])
    np.testing.assert_allclose(*found, rtol=ROUNDING)
    assert not np.array_equal(*found)
