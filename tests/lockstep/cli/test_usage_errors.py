"""A wrong command line gets one line: what is wrong, what is accepted, and where to read more."""

import click
import pytest

from lockstep.__main__ import PROGRAM
from lockstep.cli.command import command
from lockstep.cli.options import assignments, option_group
from lockstep.cli.parameter_types import COUNT, NUMBER, OneOf, Several
from lockstep.cli.probe_latency import _amplitudes
from lockstep.cli.program import CommandGroup
from lockstep.cli.timing_options import with_delays, with_step_sizes
from lockstep.cli.usage_errors import RENAMED, similar
from lockstep.errors import InputError

RUN = "; see `python -m lockstep run --help`"
PROBE = "; see `python -m lockstep probe-latency --help`"


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        ([], "COMMAND: missing; see `python -m lockstep --help`"),
        (["runn"], "'runn': no such command; did you mean run?; see `python -m lockstep --help`"),
        (
            ["fly"],
            "'fly': no such command; choose from run, show, write-ssp, bundle, check, probe-latency; "
            "see `python -m lockstep --help`",
        ),
        (["--tracback"], "--tracback: no such option; did you mean --traceback?; see `python -m lockstep --help`"),
        (["run", "a.ssd", "--stop-tme", "3"], f"--stop-tme: no such option; did you mean --stop-time?{RUN}"),
        (["run", "a.ssd", "--rec", "3"], f"--rec: no such option; did you mean --record or --record-period?{RUN}"),
        (["run", "a.ssd", "--zzz"], f"--zzz: no such option{RUN}"),
        (["run", "a.ssd", "--stop", "3"], f"--stop is now --stop-time{RUN}"),
        (["run", "a.ssd", "--duration=3"], f"--duration is now --stop-time{RUN}"),
        (["run", "a.ssd", "--period", "a=3"], f"--period is now --step-size{RUN}"),
        (["run", "a.ssd", "--hand-over", "3"], f"--hand-over is now --switchover{RUN}"),
        (["run", "--fresh", "a"], f"--fresh is now --reinitialise{RUN}"),
        (["run", "--from", "a.ckpt"], f"--from is now --restart-from{RUN}"),
        (["probe-latency", "a.fmu", "--step", "1"], f"--step is now --step-size{PROBE}"),
        (["run", "a.ssd", "b.ssd"], f"'b.ssd': one argument too many{RUN}"),
        (["run", "a.ssd", "--out"], f"--out: needs a value{RUN}"),
        (["run", "--out", "--overwrite"], f"--out: needs a value, but --overwrite follows{RUN}"),
        (["run", "--out", "--stop-time=3"], f"--out: needs a value, but --stop-time=3 follows{RUN}"),
        (["probe-latency"], f"FMU: missing{PROBE}"),
        (["write-ssp", "a.ssd"], "--out: missing; see `python -m lockstep write-ssp --help`"),
        (["probe-latency", "a.fmu", "--steps", "1.5"], f"--steps: '1.5' is not a whole number{PROBE}"),
        (["probe-latency", "a.fmu", "--time-limit", "x"], f"--time-limit: 'x' is not a number{PROBE}"),
        (
            ["probe-latency", "a.fmu", "--kind", "sample"],
            f"--kind: 'sample' is none of sampled, continuous; did you mean sampled?{PROBE}",
        ),
        (["run", "a.ssd", "--out", ""], f"--out: is empty; give the name of a file or folder, `.` for this one{RUN}"),
        (["run", "a.ssd", "--core", "-1"], f"--core -1: must be 0 or more{RUN}"),
        (["run", "a.ssd", "--overwrite=yes"], "--overwrite: takes no value; see `python -m lockstep --help`"),
    ],
)
def test_a_wrong_command_line_is_refused_in_one_line(capsys, arguments, line):
    assert PROGRAM.run(arguments) == 2
    captured = capsys.readouterr()
    assert (captured.out, captured.err) == ("", f"lockstep: {line}\n")


@pytest.mark.parametrize(
    ("read", "texts", "message"),
    [
        (assignments, ["a.x=1", "a.y=2", "a.x=2"], "--set a.x=2: is 1 already; give one value for a.x"),
        (lambda t: with_delays(None, t), ["a:b=1", "a:b=2"], "--delay a:b=2: is 1 already; give one value for a:b"),
        (
            lambda t: with_step_sizes(None, t),
            ["=0.1"],
            "--step-size =0.1: write COMPONENT=S, for example plant=0.1, or 0.1 for all",
        ),
        (lambda t: with_step_sizes(None, t), ["a=1", "a=2"], "--step-size a=2: is 1 already; give one value for a"),
        (_amplitudes, ["u=1", "2", "u=3"], "--amplitude u=3: is 1 already; give one value for u"),
    ],
)
def test_two_values_for_one_thing_are_refused(read, texts, message):
    with pytest.raises(InputError) as caught:
        read(texts)
    assert str(caught.value) == message
    assert assignments(["a.x=1", "a.x=1"]) == {"a.x": "1"}


def test_renamed_options_have_their_new_names_somewhere():
    from flexbench.cli.parser import PROGRAM as FLEXSAT

    known = set()
    for program in (PROGRAM, FLEXSAT):
        for name in program.list_commands(None):
            known |= {option for parameter in program.get_command(None, name).params for option in parameter.opts}

    assert set(RENAMED.values()) <= known


def test_similar_names_begin_alike_or_are_spelled_alike():
    assert similar("--stop", ["--step-size", "--stop-time"]) == ["--stop-time"]
    assert similar("buld", ["build", "budget"]) == ["build"]
    assert similar("xyz", ["build"]) == []


@pytest.fixture
def program(monkeypatch):
    """Return a program of one command that returns what it was given, and the list of it."""
    seen = []

    class Values:
        __dataclass_fields__ = {"number": None, "words": None}

        def __init__(self, number, words):
            self.number, self.words = number, words

    group = option_group(
        "values",
        Values,
        click.option("--number", type=NUMBER),
        click.option("--words", type=Several(), multiple=True),
    )

    @command("go", "example:\n  {program} go   --number  1")
    @group
    @click.option("--pair", type=NUMBER, nargs=2)
    @click.option("--count", type=COUNT)
    @click.option("--kind", type=OneOf(("a", "b")))
    @click.argument("names", nargs=-1)
    def go(values, pair, count, kind, names):
        """Do it."""
        seen.append((values.number, values.words, pair, count, kind, names))
        return 7

    made = CommandGroup("toy", {"go": ("toy.go", "do it")}, label="toy", description="Toy.", epilog="")
    monkeypatch.setattr(made, "get_command", lambda context, name: go if name == "go" else None)  # noqa: ARG005
    return made, seen


def test_values_of_all_kinds_are_read(program):
    made, seen = program
    words = "go x --number -1e-3 --words a b --pair -1 2 --words c -4 --count 3 --kind b"
    assert made.run(words.split()) == 7
    assert made.run(["go", "--number=-2", "--", "--kind"]) == 7

    assert seen == [
        (-1e-3, (("a", "b"), ("c", "-4")), (-1.0, 2.0), 3, "b", ("x",)),
        (-2.0, (), None, None, None, ("--kind",)),
    ]


@pytest.mark.parametrize(
    ("words", "line"),
    [
        ("--pair 1", "--pair: needs 2 values"),
        ("--pair 1 --count 2", "--pair: needs 2 values, but --count follows"),
        ("--words --count 2", "--words: needs a value, but --count follows"),
        ("--words", "--words: needs a value"),
        ("--count 0", "--count 0: must be 1 or more"),
        ("--pair 1 x", "--pair: 'x' is not a number"),
        ("--kind c", "--kind: 'c' is none of a, b"),
    ],
)
def test_wrong_values_are_refused_by_option_and_value(program, capsys, words, line):
    made, seen = program
    assert made.run(["go", *words.split()]) == 2
    assert (capsys.readouterr().err, seen) == (f"toy: {line}; see `toy go --help`\n", [])


def test_examples_are_printed_as_they_are_with_the_name_of_the_program(program, capsys):
    made, _ = program
    assert made.run(["go", "--help"]) == 0
    assert capsys.readouterr().out.endswith("\n\nexample:\n  toy go   --number  1\n")


@pytest.mark.parametrize(
    ("message", "line"),
    [
        ("ghost: no such component; there are a, b", "--sampled ghost: no such component; there are a, b"),
        ("x: no such component; there are a, b", "--delay x:b=1: x: no such component; there are a, b"),
        (": no such component; there are a, b", "--sampled '': no such component; there are a, b"),
        ("both: no such component; there are a, b", "both: no such component; there are a, b"),  # of which option?
        ("c: no such component; there are a, b", "c: no such component; there are a, b"),  # of a file
        ("d: no such component; there are a, b", "--set d.gain=1: d: no such component; there are a, b"),
        ("d.gain: no such parameter; d has g", "d.gain: no such parameter; d has g"),  # as it was given
        ("run 1: ghost: no such component", "--sampled ghost: run 1: ghost: no such component"),
        ("ghost: must not be there", "ghost: must not be there"),
    ],
)
def test_the_option_that_gave_a_wrong_name_is_named(capsys, message, line):
    @command("show", "", tables=True)
    @click.option("--sampled", multiple=True)
    @click.option("--delay", multiple=True)
    @click.option("--set", "settings", multiple=True)
    def show(**_):
        raise InputError(message)

    group = CommandGroup("lockstep", {}, label="lockstep", description="", epilog="")
    group.get_command = lambda *_: show
    words = ["--sampled", "ghost", "--sampled", "both", "--sampled", "", "--delay", "x:b=1", "--delay", "both:b=1"]
    words += ["--set", "d.gain=1"]
    assert group.run(["show", *words]) == 2
    assert capsys.readouterr().err == f"lockstep: {line}\n"
