"""Options that several commands share: timing, processes, strictness, and what is probed."""

import json
import tomllib

import pytest

from flexbench.cli.parser import PROGRAM as FLEXSAT
from lockstep import Component, Connection, System, load_system, write_ssd
from lockstep.__main__ import PROGRAM as LOCKSTEP

PROGRAMS = {"flexsat": FLEXSAT, "lockstep": LOCKSTEP}
MS = 1_000_000  # [ns]


@pytest.fixture(scope="module")
def pair(reference_fmu, tmp_path_factory):
    """Return the system file of an integrator that feeds another one."""
    source = reference_fmu("integrator", "2.0")
    parts = [Component(name=name, source=source, period=10 * MS, kind="continuous", isolated=False) for name in "ab"]
    system = System(
        name="pair",
        tick=5 * MS,
        stop_time=20 * MS,
        components=(parts[0], parts[1]),
        connections=(
            Connection(from_component="a", output="x", to_component="b", input="u", delay=2, convert_units=False),
        ),
    )
    path = tmp_path_factory.mktemp("pair") / "pair.ssd"
    write_ssd(system, path)
    return path


TIMING = {
    "--delay": "6",
    "--step-size": "a=0.02",
    "--continuous": "b",  # as it is
    "--sampled": "a",
    "--tick": "0.001",  # the file has one: refused
}


@pytest.mark.parametrize("option", TIMING)
@pytest.mark.parametrize(("label", "name"), [("lockstep", "show"), ("flexsat", "timeline")])
def test_timing_options_change_what_is_shown(pair, capsys, label, name, option):
    def shown(*options):
        code = PROGRAMS[label].run([name, str(pair), *options])
        return code, capsys.readouterr()

    (plain_code, plain), (code, given) = shown(), shown(option, TIMING[option])
    assert plain_code == 0
    if option == "--tick":
        assert (code, given.out) == (2, "")
        assert "--tick 0.001: the file has a tick of 0.005 s" in given.err
    elif option == "--continuous":
        assert (code, given.out) == (0, plain.out)
        assert shown("--sampled", "b")[1].out != given.out
    else:
        assert code == 0
        assert given.out != plain.out


def test_what_is_shown_is_json_too(pair, capsys):
    def tables(label, *words):
        assert PROGRAMS[label].run([*words, "--json", "-"]) == 0
        return [(one["title"], one["rows"]) for one in json.loads(capsys.readouterr().out)["tables"]]

    name = "integrator.fmu"
    shown = dict(tables("lockstep", "show", str(pair)))
    assert shown["components in the order of a tick"] == [
        ["a", 0.01, 0, "continuous", name],
        ["b", 0.01, 0, "continuous", name],
    ]
    assert shown["connections"] == [["a", "b", 1, 2]]
    assert shown["inputs without a value"] == []  # a.u has a start value
    drawn = dict(tables("flexsat", "timeline", str(pair), "--ticks", "3"))
    assert drawn["steps"] == [[tick, one, 0.005 * tick, 0.005 * tick + 0.01, 0.005 * tick + 0.01]
                              for tick in (0, 2) for one in "ab"]  # fmt: skip
    assert drawn["values read"] == [[0, "b", "a", 1, 2, 0, True], [2, "b", "a", 1, 2, 0, True]]
    assert drawn["connections"] == [["a", "b", 2, "x -> u"]]


def test_a_written_package_has_the_delay_and_the_step(pair, tmp_path, capsys):
    words = ["write-ssp", str(pair), "--delay", "a:b=4", "--step-size", "b=0.02", "--out", str(tmp_path / "pair.ssp")]
    assert LOCKSTEP.run(words) == 0, capsys.readouterr()
    written = load_system(tmp_path / "pair.ssp")

    assert [(one.from_component, one.delay) for one in written.connections] == [("a", 4)]
    assert {one.name: one.period for one in written.components} == {"a": 10 * MS, "b": 20 * MS}


@pytest.mark.parametrize(("option", "isolated"), [("--isolate", True), ("--share-process", False)])
def test_the_process_of_a_component_is_recorded(pair, tmp_path, capsys, option, isolated):
    words = ["run", str(pair), "--set", "a.u=1", option, "a", "--out", str(tmp_path / "out")]
    assert LOCKSTEP.run(words) == 0, capsys.readouterr()
    record = tomllib.loads((tmp_path / "out" / "run.toml").read_text(encoding="utf-8"))

    assert [part["isolated"] for part in record["component"]] == [isolated, False]


def test_a_strict_run_refuses_what_is_else_a_warning(reference_fmu, tmp_path, capsys):
    words = ["run", str(reference_fmu("integrator", "2.0")), "--stop-time", "0.01", "--out", str(tmp_path / "out")]
    assert LOCKSTEP.run([*words, "--strict"]) == 2
    assert "neither the file nor the FMU gives a step size" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []
    assert LOCKSTEP.run(words) == 0


def test_a_static_check_runs_nothing(reference_fmu, capsys):
    assert LOCKSTEP.run(["check", "--static", str(reference_fmu("integrator", "2.0"))]) == 0
    shown = capsys.readouterr().out
    assert "static.archive" in shown
    assert "dynamic." not in shown


def test_options_change_what_is_probed(reference_fmu, capsys):
    fmu = str(reference_fmu("integrator", "2.0"))
    assert LOCKSTEP.run(["probe-latency", fmu, "--step-size", "0.25", "--steps", "5"]) == 0
    assert "integrator, step 0.25 s (as given), 5 steps watched" in capsys.readouterr().out


def test_results_of_two_runs_go_to_folders_of_their_own(tmp_path):
    from flexbench.runs.evaluation_folder import evaluation_folders

    runs = [tmp_path / "a", tmp_path / "b"]
    assert evaluation_folders(runs, tmp_path / "out") == [tmp_path / "out" / "a", tmp_path / "out" / "b"]
    assert evaluation_folders(runs, None) == runs
