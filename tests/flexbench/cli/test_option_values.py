"""Every option of a command of `flexsat` reaches the study that it is for, with its value.

What the study makes of the value is tested with the study; `test_option_effects.py` lists where. Here the study is not
run: it would take minutes. The call that the command makes is recorded in its place.
"""

from importlib import import_module
from types import SimpleNamespace

import click
import pytest

from flexbench.cli.margins import MeasurementOptions
from flexbench.cli.parser import PROGRAM
from flexsat.variants import AS_PUBLISHED
from lockstep.cli.options import assignments

FAR = "far.ssd"
CHECKED = ("lockstep.plan.schedule:build_schedule", "lockstep.plan.overrides:refuse_unknown")


class Reached(Exception):
    """The command has called the study."""


# command line, the function that ends it, functions before it that would read files, and by option: its values and
# what is then in the call
CALLS = {
    "build": (
        ("build",),
        "flexbench.loop.build:build_all",
        (),
        {
            "--configuration": (("centralised",), "('centralised',), "),
            "--out": (("there",), "'there'"),
            "--flat": ((), "flat=True"),
            "--needs-execution-tool": ((), "execution_tool=True"),
            "--no-native": ((), "in_c=()"),
            "--fmi3": ((), "in_c=('2.0', '3.0')"),
            "--platforms": (("win64,linux64",), "platforms=('linux64', 'win64')"),
        },
    ),
    "paper": (
        ("paper",),
        "flexbench.studies.paper.paper:run_paper",
        ("flexbench.loop.build:build_all",),
        {
            "--as-published": ((), "['as_published']"),
            "--corrected": ((), "['corrected', 'published_design']"),
            "--seeds": (("3",), "range(1, 4)"),
            "--stop-time": (("200",), "200.0"),
            "--out": (("there",), "'there'"),
            "--fmus": (("others",), "'others'"),
            "--jobs": (("7",), "7"),
        },
    ),
    "paper, built": (
        ("paper",),
        "flexbench.loop.build:build_all",
        (),
        {"--python": ((), "in_c=()")},
    ),
    "branch": (
        ("branch", "t=1.ckpt", "--vary", "a.x", "1"),
        "flexbench.engine.branches:run_branches",
        (),
        {
            "--vary": (("b.y", "5", "6"), "'b.y': '6'"),
            "--set": (("c.z=4",), "'c.z': '4'"),
            "--reinitialise": (("c",), "'reinitialised': ('c',)"),
            "--stop-time": (("9",), "'stop_time': 9.0"),
            "--record": (("a.*",), "'record': ['a.*']"),
            "--out": (("there",), "'there'"),
            "--jobs": (("7",), "'processes': 7"),
        },
    ),
    "report": (
        ("report", "run"),
        "flexbench.report:write_report",
        (),
        {
            "--out": (("there.html",), "'there.html'"),
            "--time-range": (("1", "2"), "'window': (1.0, 2.0)"),
            "--pdf": ((), "'pdf': True"),
        },
    ),
    "export": (
        ("export", "run", "--format", "csv"),
        "flexbench.runs.export:export_run",
        (),
        {
            "--format": (("mat",), "'mat'"),
            "--out": (("there.csv",), "'there.csv'"),
            "--signals": (("plant.*",), "('plant.*',)"),
        },
    ),
    "health": (
        ("health", FAR),
        "flexbench.studies.health.study:run_health",
        (),
        {
            "--seeds": (("3",), "range(1, 4)"),
            "--stop-time": (("9",), "9.0"),
            "--set": (("controller.design=published",), "{'controller.design': 'published'}"),
            "--input": (("torque.csv",), "torque.csv"),
            "--out": (("there",), "'there'"),
            "--python": ((), "True"),
            "--jobs": (("7",), "7"),
        },
    ),
    "robustness": (
        ("robustness",),
        "flexbench.studies.robustness.model_errors:run_robustness",
        ("flexbench.loop.chosen_spacecraft:build_all",),
        {
            "--configuration": (("centralised",), "['centralised']"),
            "--scenario": (("slew",), "'slew'"),
            "--controller-design": (("published",), "'published'"),
            "--levels": (("3", "4"), "(0.03, 0.04)"),
            "--vary": (("damping",), "levels={'damping': (0.5,)}, modes=()"),
            "--damping": (("30",), "'damping': (0.3,)"),
            "--inertia": (("5",), "'inertia': (0.05,)"),
            "--participation": (("7",), "'participation': (0.07,)"),
            "--modes": (("28", "60"), "modes=(28, 60)"),
            "--seeds": (("3",), "range(1, 4)"),
            "--stop-time": (("90",), "90.0"),
            "--out": (("there",), "'there'"),
            "--fmus": (("others",), "'others'"),
            "--python": ((), "True"),
            "--jobs": (("7",), "7"),
        },
    ),
    "compare-layouts": (
        ("compare-layouts",),
        "flexbench.studies.layouts.study:run_layouts",
        ("flexbench.loop.chosen_spacecraft:build_missing",),
        {
            "--scenario": (("slew",), "duration={'slew': 200.0}"),
            "--dispersion": (("inertia=5",), "Dispersion(frequency=0.05, damping=0.5, inertia=0.05)"),
            "--seeds": (("3",), "range(1, 4)"),
            "--stop-time": (("90",), "{'fine_pointing': 90.0, 'slew': 90.0}"),
            "--settling-band": (("2",), "band=9.69"),
            "--set": (("c.z=4",), "{'c.z': '4'}"),
            "--out": (("there",), "'there'"),
            "--fmus": (("others",), "'others'"),
            "--python": ((), "True"),
            "--jobs": (("7",), ", 7, functools"),
        },
    ),
    "waterfall": (
        ("waterfall", FAR),
        "flexbench.studies.waterfall.sweep:sweep",
        ("flexbench.studies.waterfall.sweep:design_of",),
        {
            "--points": (("5",), "5"),
            "--stop-time": (("9",), "9.0"),
            "--speed-range": (("30", "60"), "(3.14159"),
            "--seed": (("4",), "4"),
            "--out": (("there",), "'there'"),
            "--python": ((), "True"),
            "--jobs": (("7",), "7"),
        },
    ),
    "shadow": (
        ("shadow", "run"),
        "flexbench.studies.shadow.study:study",
        ("flexbench.runs.run_folder:read_run",),
        {"--from": (("3",), "3.0"), "--window": (("4",), "4.0")},
    ),
    "spectra": (
        ("spectra", "run"),
        "flexbench.studies.spectra.channels:run_spectra",
        ("flexbench.runs.run_folder:read_run",),
        {"--from": (("3",), "3.0"), "--resolution": (("0.2",), "0.2"), "--confidence": (("0.9",), "0.9")},
    ),
    "equivalence": (
        ("equivalence",),
        "flexbench.loop.equivalence:compare",
        ("flexbench.loop.chosen_spacecraft:build_all",),
        {
            "--configuration": (("distributed",), "'distributed'"),
            "--scenario": (("fine_pointing",), "'fine_pointing'"),
            "--seed": (("4",), "4"),
            "--stop-time": (("9",), "9.0"),
            "--record": (("plant.*",), "['plant.*']"),
            "--out": (("there",), "there"),
            "--fmus": (("others",), "'others'"),
            "--native": ((), "'native': True"),
        },
    ),
    "budget": (
        ("budget", "run"),
        "flexbench.studies.budget.evaluate:steady_error",
        ("flexbench.runs.run_folder:read_run",),
        {"--from": (("3",), "3.0")},
    ),
    "budget --split": (
        ("budget", "--split", FAR),
        "flexbench.studies.budget.split:split_budget",
        ("lockstep.ssp.load:load_system",),
        {
            "--split": (("other.ssd",), "'other.ssd'"),
            "--seed": (("4",), "4"),
            "--stop-time": (("9",), "9.0"),
            "--out": (("there",), "'there'"),
            "--python": ((), "True"),
            "--jobs": (("7",), "7"),
            "--window": (("5",), "window=5.0"),
            "--separation": (("30",), "separation=30.0"),
            "--observation": (("40",), "observation=40.0"),
            "--level": (("0.9",), "(0.9,)"),
            "--from": (("3",), "3.0"),
        },
    ),
    "margins": (
        ("margins", FAR),
        "flexbench.studies.margins.study:run_study",
        ("lockstep.ssp.load:load_system", "flexbench.studies.margins.system_loop:read_loop",
         "flexbench.loop.missed_samples:refuse_missed_samples", *CHECKED),
        {
            "--analytic-only": ((), "True, False"),
            "--find-delay": ((), "False, True"),
            "--modes": (("25", "28"), "modes=(25, 28)"),
            "--gains": (("-3", "3"), "gains=(-3.0, 3.0)"),
            "--seed": (("4",), "'plant.seed': 4"),
            "--set": (("c.z=4",), "'c.z': '4'"),
            "--noise-free": ((), "quiet=True"),
            "--band": (("1", "2"), "band=(1.0, 2.0)"),
            "--lines": (("7",), "lines=7"),
            "--length": (("5",), "length=5.0"),
            "--periods": (("3",), "periods=3"),
            "--settle": (("1",), "settle=1"),
            "--zoom": (("8",), "zoom=8.0"),
            "--amplitude": (("2",), "amplitude=2.0"),
            "--out": (("there",), "'there'"),
        },
    ),
    "margins, its loop": (
        ("margins", FAR),
        "flexbench.studies.margins.system_loop:read_loop",
        ("lockstep.ssp.load:load_system", "flexbench.loop.missed_samples:refuse_missed_samples", *CHECKED),
        {
            "--controller": (("law",), "'law'"),
            "--plant": (("truss",), "'truss'"),
            "--directions": (("channels",), "True"),
        },
    ),
}  # fmt: skip
CASES = [(what, option) for what, (*_, options) in CALLS.items() for option in options]


def text(value):
    """Return a value as text: folders without the place where the test runs."""
    return repr(value).replace("PosixPath(", "(")


def called(monkeypatch, function, before, words):
    """Return the call that a command line ends with, as text."""
    with monkeypatch.context() as patch:
        for name in before:
            module, _, attribute = name.partition(":")
            made = SimpleNamespace(
                name="far", config=SimpleNamespace(name="centralised"), components=(), connections=()
            )
            patch.setattr(import_module(module), attribute, lambda *_, found=made, **__: found)

        def record(*arguments, **named):
            raise Reached(text(arguments) + text(named))

        module, _, attribute = function.partition(":")
        patch.setattr(import_module(module), attribute, record)
        context = PROGRAM.make_context("flexsat", list(words))
        with context, pytest.raises(Reached) as reached:
            PROGRAM.invoke(context)
    return str(reached.value)


@pytest.mark.parametrize(("what", "option"), CASES)
def test_an_option_reaches_the_study_with_its_value(monkeypatch, tmp_path, what, option):
    monkeypatch.chdir(tmp_path)
    words, function, before, options = CALLS[what]
    values, expected = options[option]
    without = called(monkeypatch, function, before, words)
    given = called(monkeypatch, function, before, (*words, option, *values))

    assert expected in given
    assert given != without


def test_measurement_options_beside_analytic_only_are_refused(capsys):
    for option, values in {
        "--lines": ["5"],
        "--noise-free": [],
        "--band": ["1", "2"],
        "--seed": ["3"],
        "--python": [],
    }.items():
        assert PROGRAM.run(["margins", FAR, "--analytic-only", option, *values]) == 2
        assert f"{option}: has no effect on the design, which --analytic-only analyses" in capsys.readouterr().err
    assert set(MeasurementOptions.__dataclass_fields__) <= {p.name for p in PROGRAM.get_command(None, "margins").params}


@pytest.mark.parametrize("option", ["--seed", "--stop-time", "--jobs", "--python"])
def test_options_of_the_split_alone_are_refused(capsys, option):
    assert PROGRAM.run(["budget", "run", option, *(["3"] if option != "--python" else [])]) == 2
    assert capsys.readouterr().err == f"flexsat: {option}: has an effect only with --split SYSTEM; leave it out\n"


def test_as_published_sets_the_parameters_of_the_release():
    from flexbench.cli.run import _settings

    systems = [SimpleNamespace(name=f"centralised-{name}") for name in ("slew", "fine-pointing")]
    slew, pointing = (_settings(system, AS_PUBLISHED) for system in systems)
    assert slew["controller.as_published"] is True
    assert set(slew) != set(pointing) or slew != pointing


def test_assignments_are_those_of_the_command_line():
    assert assignments(["a.b=1", "c=2=3"]) == {"a.b": "1", "c": "2=3"}


def covered():
    """Return command and option of all cases."""
    return {(what.partition(" ")[0].rstrip(","), option) for what, option in CASES}


def test_the_options_named_here_exist():
    for command, option in covered():
        names = {
            name for p in PROGRAM.get_command(None, command).params if isinstance(p, click.Option) for name in p.opts
        }
        assert option in names, (command, option)
