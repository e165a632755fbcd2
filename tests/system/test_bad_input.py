"""What the command `flexsat` says and leaves when the input is wrong, the disk is full, or Ctrl-C is pressed."""

import json
import os
import re
import resource
import shutil
import signal
import time
import tomllib
from pathlib import Path

import numpy as np
import pytest

from lockstep import read_signals

PROGRESS = re.compile(r"[\w-]+: [\d.]+ of [\d.]+ s, .* left|[\w-]+: (?:[\d.]+ s simulated|failed|ended) \(\d+ of \d+\)")


# `flexsat` with FMUs that are there: they are built in `test_paper.py`. All runs have native ones, which start sooner;
# that Ctrl-C ends a run of those in Python, a run alone shows
WITHOUT_BUILD = """
from dataclasses import replace
from flexbench.cli.parser import program
from flexbench.loop import build
from flexbench.studies.paper import paper
planned = paper.plan_jobs
paper.plan_jobs = lambda *options: {key: replace(job, native=True) for key, job in planned(*options).items()}
build.build_all = lambda *_, **__: None
program()
"""


def error_lines(done):
    """Return what stands on standard error besides progress; a traceback must never be there."""
    assert "Traceback" not in done.stderr
    return [line for line in done.stderr.splitlines() if not PROGRESS.fullmatch(line)]


@pytest.fixture(scope="session")
def system(fmus):
    """Return a system file of the smaller configuration."""
    return fmus / "centralised" / "fine_pointing.ssd"


# One process for many command lines: none of them gets as far as a simulation. What FMUs do to a process is not at
# stake here, and starting one takes two seconds.
ANSWERS = """
import contextlib, io, os
from flexbench.cli.parser import main
result = {}
for name, (folder, arguments) in given[0].items():
    Path(folder).mkdir(parents=True)
    os.chdir(folder)
    out, error = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(error):
        code = main(arguments)
    result[name] = {"code": code, "out": out.getvalue(), "error": error.getvalue(), "left": os.listdir()}
"""


def answers(python, folder, cases):
    """Return what the command answers to the arguments of each case, in an empty folder of its own."""
    given = {name: (str(folder / str(k)), [str(a) for a in cases[name]]) for k, name in enumerate(cases)}
    return python(ANSWERS, given)


def assert_refused(answer, parts, code=2):
    """Check that bad input got one line with these parts, and left nothing."""
    lines = answer["error"].splitlines()
    assert (answer["code"], len(lines), answer["left"], answer["out"]) == (code, 1, [], ""), answer
    assert lines[0].startswith("flexsat: ")
    assert [part for part in parts if part not in lines[0]] == [], lines[0]


# options of `flexsat run`, and what the one line must hold: the name, the wrong value, the remedy
REFUSED = {
    "unknown parameter": (("--set", "sensors.gyro.nois=1"), ("sensors.gyro.nois", "did you mean gyro.noise?")),
    "unknown component": (("--set", "plnt.seed=1"), ("plnt", "did you mean plant?")),
    "no value": (("--set", "plant.seed"), ("--set plant.seed", "COMPONENT.PARAMETER=VALUE")),
    "text for a real": (("--set", "sensors.gyro.noise=loud"), ("sensors.gyro.noise", "'loud'", "Real")),
    "number for a Boolean": (("--set", "plant.as_published=1.5"), ("plant.as_published", "'1.5'", "true or false")),
    "fraction for an integer": (("--set", "plant.seed=1.5"), ("plant.seed", "'1.5'", "Integer")),
    "not finite": (("--set", "sensors.gyro.noise=nan"), ("sensors.gyro.noise", "'nan'", "finite")),
    "too few elements": (("--set", "plant.initial.mrp=1,2"), ("plant.initial.mrp", "2 values", "initial.mrp[1..3]")),
    "negative noise": (("--set", "sensors.gyro.noise=-1e-7"), ("sensors.gyro.noise", "'-1e-7'", "[0.0, 0.0174")),
    "damping": (("--set", "plant.dispersion.damping[1]=-2"), ("dispersion.damping[1]", "'-2'", "[-1.0, 10.0]")),
    "fast rate": (("--set", "plant.initial.rate[2]=0.5"), ("plant.initial.rate[2]", "'0.5'", "[-0.2, 0.2]")),
    "negative seed": (("--seed", "-1"), ("--seed -1", "0 or more")),
    "delay out of range": (("--set", "controller.delay.actuation=0.03"), ("delay.actuation", "'0.03'", "0.02")),
    "output set": (("--set", "plant.rate[1]=1"), ("plant.rate[1]", "output", "parameters and inputs")),
    "record": (("--record", "plant.modal.displacment"), ("'plant.modal.displacment'", "did you mean plant.modal.di")),
    "record period": (("--record-period", "0.0015"), ("record period", "0.0015 s", "0.001 s or 0.002 s")),
    "period": (("--step-size", "sensors=0.0015"), ("sensors", "0.0015 s", "0.001 s or 0.002 s")),
    "period of nobody": (("--step-size", "sensor=0.002"), ("sensor:", "did you mean sensors?")),
    "period no number": (("--step-size", "sensors=fast"), ("--step-size sensors", "'fast'", "0.001")),
    "delay to nobody": (("--delay", "sensors:control=5"), ("control:", "did you mean controller?")),
    "delay without wire": (("--delay", "controller:sensors=5"), ("controller -> sensors", "no such connection")),
    "delay no number": (("--delay", "sensors:controller=5ms"), ("sensors:controller=5ms", "sensors:controller=5")),
    "missed samples": (
        ("--set", "sensors.fast_period=0.001", "--set", "sensors.star_tracker.period=0.101"),
        ("controller: would miss 4 of 5 star tracker samples", "sensors.star_tracker.valid", "multiple of 0.005 s"),
    ),
    "stop time": (("--stop-time", "0.1005"), ("stop time", "0.1005 s", "0.1 s or 0.101 s")),
    "stop time zero": (("--stop-time", "0"), ("stop time", "0 s", "> 0")),
    "stop time text": (("--stop-time", "soon"), ("stop", "'soon'", "0.001")),
    "seed text": (("--seed", "one"), ("--seed", "'one'")),
    "unknown option": (("--sed", "1"), ("--sed", "--help")),
}


@pytest.fixture(scope="module")
def refused(python, system, tmp_path_factory):
    """Return the answers to bad options of a run."""
    cases = {what: ("run", system, "--stop-time", "0.1", *options) for what, (options, _) in REFUSED.items()}
    return answers(python, tmp_path_factory.mktemp("refused"), cases)


@pytest.mark.parametrize("what", REFUSED)
def test_bad_options_are_refused_in_one_line_before_anything_is_written(refused, what):
    assert_refused(refused[what], REFUSED[what][1])


def test_the_program_does_the_same_as_its_main_function(flexsat, refused, system, tmp_path):
    done = flexsat("run", system, "--stop-time", "0.1", *REFUSED["unknown parameter"][0], cwd=tmp_path)

    answer = refused["unknown parameter"]
    assert (done.returncode, done.stdout, done.stderr) == (answer["code"], answer["out"], answer["error"])
    assert list(tmp_path.iterdir()) == []


# values that only the component itself can judge: it is asked while it is initialised
BY_COMPONENT = {
    "delay": ("controller.delay.measurement=0.0015", ("controller", "delay", "whole milliseconds", "0.0015")),
    "attitude": ("plant.initial.mrp=0.9,0.9,0.9", ("plant", "initial.mrp", "norm must be <= 1", "1.55885")),
    "inertia": ("plant.dispersion.inertia=0,-0.01,0", ("plant", "dispersion.inertia", "-0.01", "choose larger")),
    "frequency": ("plant.dispersion.frequency[3]=-1", ("plant", "frequency", "must be > -1", "-1.0")),
    "torque limit": ("plant.wheel.torque_limit=0", ("plant", "wheel.torque_limit", "must be > 0", "0.0")),
    "sampling": (
        "sensors.fast_period=0.0015",
        ("sensors", "star_tracker.period = 0.1 s", "whole multiple of fast_period = 0.0015 s"),
    ),
    "star tracker": (
        "sensors.star_tracker.period=0.101",
        ("sensors", "star_tracker.period = 0.101 s", "whole multiple of fast_period = 0.005 s"),
    ),
}


@pytest.fixture(scope="module")
def by_component(python, system, tmp_path_factory):
    """Return the answers to parameters that a component refuses. These FMUs do run in one process after another."""
    cases = {
        what: ("run", system, "--stop-time", "0.1", "--set", setting) for what, (setting, _) in BY_COMPONENT.items()
    }
    return answers(python, tmp_path_factory.mktemp("by-component"), cases)


@pytest.mark.parametrize("what", BY_COMPONENT)
def test_a_value_that_a_component_refuses_is_reported_in_its_words(by_component, what):
    answer = by_component[what]
    assert_refused(answer, BY_COMPONENT[what][1])


@pytest.mark.parametrize(
    ("component", "period", "own"), [("sensors", "0.002", "0.005"), ("controller", "0.01", "0.005")]
)
def test_a_period_that_a_component_refuses_ends_the_run_at_once(flexsat, system, tmp_path, component, period, own):
    done = flexsat(
        "run", system, "--stop-time", "0.1", "--step-size", f"{component}={period}", "--out", tmp_path / "out"
    )

    assert done.returncode == 1
    assert len(error_lines(done)) == 1
    assert [part for part in (f"flexsat: {component}: ", f"{period} s", f"{own} s") if part not in done.stderr] == []
    run = tomllib.loads((tmp_path / "out/run.toml").read_text())
    assert (run["status"], run["simulated_time"]) == ("failed", 0.0)
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == ["events.jsonl", "run.toml", "signals.parquet"]


COMMANDS = {
    "no seeds": (("paper", "--seeds", "0"), ("--seeds 0", "1 or more")),
    "no processes": (("paper", "--jobs", "0"), ("--jobs 0", "1 or more")),
    "too short": (("paper", "--stop-time", "100"), ("--stop-time 100", "150 s", "longer")),
    "duration text": (("paper", "--stop-time", "long"), ("--stop-time", "'long'")),
    "configuration": (("build", "--configuration", "central"), ("'central'", "centralised", "distributed")),
    "scenario": (("equivalence", "--scenario", "spin"), ("'spin'", "slew", "fine_pointing")),
    "no system": (("run", "fmus/centralised/slow.ssd"), ("fmus/centralised/slow.ssd", "flexsat build")),
    "no archive": (("run", "slew.ssp"), ("slew.ssp", "no such file")),
    "nothing to run": (("run",), ("system", "--help")),
    "no such command": (("fly",), ("'fly'", "build", "run", "paper")),
    "no command": ((), ("COMMAND", "--help")),
}


@pytest.fixture(scope="module")
def commands(python, tmp_path_factory):
    """Return the answers to bad commands."""
    cases = {what: arguments for what, (arguments, _) in COMMANDS.items()}
    return answers(python, tmp_path_factory.mktemp("commands"), cases)


@pytest.mark.parametrize("what", COMMANDS)
def test_bad_commands_are_refused_in_one_line_before_anything_is_written(commands, what):
    assert_refused(commands[what], COMMANDS[what][1])


WIRE = (
    '<ssd:Connection startElement="controller" startConnector="wheel.torque[2]" '
    'endElement="plant" endConnector="wheel.torque[2]"/>'
)
TORQUE = '<ssd:Connector name="wheel.torque[1]" kind="output">\n            <ssc:Real'
FILES = {
    "an unconnected input": ([(WIRE, "")], ("plant.wheel.torque[2]", "not connected", "connect it or give a value")),
    "a wrong unit": (
        [(f"{TORQUE}/>", f'{TORQUE} unit="N"/>')],
        ("controller.wheel.torque[1]", "'N'", "'N.m'"),
    ),
    "a unit that is not defined": ([(f"{TORQUE}/>", f'{TORQUE} unit="lbf"/>')], ("wheel.torque[1]", "lbf")),
    "ends of different units": (
        [
            (
                WIRE,
                WIRE.replace(
                    '"controller" startConnector="wheel.torque[2]"', '"sensors" startConnector="gyro.rate[2]"'
                ),
            )
        ],
        ("sensors.gyro.rate[2] -> plant.wheel.torque[2]", "rad/s", "N.m"),
    ),
    "an output that is not there": (
        [(WIRE, WIRE.replace('startConnector="wheel.torque[2]"', 'startConnector="wheel.tork[2]"'))],
        ("wheel.tork[2]", "wheel.torque"),
    ),
    "no XML": ([("<ssd:System ", "<ssd:System <")], ("fine_pointing.ssd", "line")),
    "a delay in words": ([('delay="1"', 'delay="one"')], ("'one'",)),
}


TRUNCATED = {"empty": 0.0, "half": 0.5, "all but the end": 0.99}


@pytest.fixture(scope="module")
def damaged(python, system, tmp_path_factory):
    """Return the answers to copies of a system, each with something wrong in its files."""
    folder, cases = tmp_path_factory.mktemp("damaged"), {}
    for what in ("missing", *TRUNCATED, *FILES):
        copy = folder / what
        shutil.copytree(system.parent, copy)
        plant, text = copy / "plant.fmu", (copy / system.name).read_text()
        if what == "missing":
            plant.unlink()
        elif what in TRUNCATED:
            plant.write_bytes(plant.read_bytes()[: round(TRUNCATED[what] * plant.stat().st_size)])
        else:
            for old, new in FILES[what][0]:
                assert old in text, old
                text = text.replace(old, new, 1)
            (copy / system.name).write_text(text)
        cases[what] = ("run", copy / system.name, "--stop-time", "0.1")
    return answers(python, tmp_path_factory.mktemp("answers"), cases)


@pytest.mark.parametrize("what", FILES)
def test_a_wrong_system_file_is_refused_by_name(damaged, what):
    assert_refused(damaged[what], FILES[what][1])


@pytest.mark.parametrize("what", ["missing", *TRUNCATED])
def test_a_missing_or_truncated_fmu_is_named(damaged, what):
    assert_refused(
        damaged[what], ("flexsat: plant: ", "no such file" if what == "missing" else "", f"{what}/plant.fmu")
    )


def test_a_results_folder_that_exists_is_kept(flexsat, system, tmp_path):
    options = ("run", system, "--native", "--stop-time", "0.1", "--out", tmp_path / "out")
    assert flexsat(*options).returncode == 0
    before = {path.name: path.read_bytes() for path in (tmp_path / "out").iterdir()}
    done = flexsat(*options)

    assert (done.returncode, len(error_lines(done))) == (2, 1)
    assert f"{tmp_path / 'out'}: holds a run already; choose another folder, or replace it (--overwrite)" in done.stderr
    assert {path.name: path.read_bytes() for path in (tmp_path / "out").iterdir()} == before
    assert flexsat(*options, "--overwrite", "--seed", "2").returncode == 0
    assert sorted(path.name for path in tmp_path.iterdir()) == ["out"]


def test_a_short_run_ends_with_the_numbers_of_its_second_half(flexsat, system, tmp_path):
    done = flexsat("run", system, "--stop-time", "0.1", "--out", tmp_path / "out")

    assert (done.returncode, error_lines(done)) == (0, [])
    assert "steady part, 0.05 to 0.1 s. Errors refer to the reference." in done.stdout


LIMIT = 10_000_000  # bytes of one file; the largest that an FMU unpacks to is 5 MB


def test_a_full_disk_ends_the_run_and_what_was_recorded_before_is_readable(flexsat, system, tmp_path):
    out = tmp_path / "out"
    done = flexsat(
        "run",
        system,
        "--native",
        "--out",
        out,
        "--record-period",
        "0.001",
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (LIMIT, LIMIT)),
    )

    assert (done.returncode, len(error_lines(done))) == (1, 1)
    assert f"cannot write to {out}: File too large, after " in done.stderr
    run = tomllib.loads((out / "run.toml").read_text())
    assert run["status"] == "failed"
    assert "File too large" in run["reason"]
    signals = read_signals(out)
    row = 8 * (1 + len(signals.columns))
    assert len(signals.time) > 0.7 * LIMIT / row  # whole seconds of rows, each with the batch's header
    np.testing.assert_array_equal(signals.time, np.arange(len(signals.time)) / 1000)
    assert np.all(np.isfinite(signals["plant.attitude.mrp"]))


def wait_for_data(process, streams, size=100_000):
    """Wait until each of some files has grown, or fail with what the process said."""
    deadline = time.monotonic() + 120.0
    while not all(stream.exists() and stream.stat().st_size > size for stream in streams):
        assert process.poll() is None, process.communicate()
        assert time.monotonic() < deadline, f"nothing was written to {streams}"
        time.sleep(0.05)


def assert_interrupted(folder):
    """Check that a run says so and can be read up to about its end."""
    run = tomllib.loads((folder / "run.toml").read_text())
    assert run["status"] == "interrupted"
    signals = read_signals(folder)
    assert signals.time[-1] == pytest.approx(run["simulated_time"], abs=run["record_period"] + 1e-9)
    assert json.loads((folder / "events.jsonl").read_text().splitlines()[-1])["status"] == "interrupted"


def test_ctrl_c_in_a_run_closes_its_folder(start_flexsat, system, tmp_path):
    process = start_flexsat("run", system, "--out", tmp_path / "out")
    wait_for_data(process, [tmp_path / "out" / "signals.arrows"])
    process.send_signal(signal.SIGINT)
    _, error = process.communicate(timeout=60)

    assert process.returncode == 130
    assert error.splitlines()[-1].startswith("flexsat: interrupted")
    assert "Traceback" not in error
    assert_interrupted(tmp_path / "out")


@pytest.mark.parametrize("whole_group", [True, False], ids=["at the terminal", "to the parent alone"])
def test_ctrl_c_in_the_study_stops_every_process_and_leaves_readable_runs(start_flexsat, fmus, tmp_path, whole_group):
    out = tmp_path / "results"
    words = ("paper", "--python", "--fmus", fmus, "--out", out, "--jobs", "2")
    process = start_flexsat(*words, cwd=tmp_path, script=WITHOUT_BUILD)
    running = [out / f"{name}-slew-as-published-seed1" for name in ("centralised", "distributed")]
    wait_for_data(process, [folder / "signals.arrows" for folder in running])
    if whole_group:  # as a terminal does
        os.killpg(process.pid, signal.SIGINT)
    else:
        process.send_signal(signal.SIGINT)
    _, error = process.communicate(timeout=60)

    assert process.returncode == 130
    assert "Traceback" not in error
    assert [line for line in error.splitlines() if line.startswith("flexsat: ")] == [
        "flexsat: interrupted; what was simulated is in the results folder"
    ]
    deadline = time.monotonic() + 10.0  # the helper of multiprocessing that ends last notices by itself
    while time.monotonic() < deadline and alive(process.pid):
        time.sleep(0.05)
    assert not alive(process.pid)
    for folder in running:
        assert_interrupted(folder)
    assert sorted(out.iterdir()) == running  # no other run was begun, and there is no table


def alive(group):
    """Return whether a process of the group is left, zombies aside."""
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = stat.read_text().rpartition(")")[2].split()
        except (FileNotFoundError, ProcessLookupError):  # it ended meanwhile
            continue
        if int(fields[2]) == group and fields[0] != "Z":
            return True
    return False
