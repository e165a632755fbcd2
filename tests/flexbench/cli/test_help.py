"""The help of every command of both programs, and the examples in it, in the README and in docs."""

import re
import shlex
from pathlib import Path

import click
import pytest

from flexbench.cli import parser
from lockstep import __main__ as lockstep_main

ROOT = Path(__file__).parents[3]
PROGRAMS = {"flexsat": parser.PROGRAM, "python -m lockstep": lockstep_main.PROGRAM}
COMMANDS = [(program, name) for program, group in PROGRAMS.items() for name in group.list_commands(None)]
EXAMPLE = re.compile(r"^(?:\$ )?(flexsat|python -m lockstep) (?=[a-z])")
INLINE = re.compile(r"`((?:flexsat|python -m lockstep) [a-z][^`]*? --[a-z][^`]*)`")  # with an option, in a sentence


def help_of(capsys, program, *names):
    """Return the help that a program prints."""
    assert PROGRAMS[program].run([*names, "--help"]) == 0
    captured = capsys.readouterr()
    assert captured.err == ""
    return captured.out


def examples(text):
    """Return program and arguments of each example in a text: a line that begins with a program's name."""
    joined = text.replace("\\\n", " ")
    found = []
    for line in [*joined.splitlines(), *INLINE.findall(joined)]:
        if match := EXAMPLE.match(line.strip()):
            words = shlex.split(line.strip()[match.end() :], comments=True)
            found.append((match[1], words))
    return found


def parse(program, words):
    """Parse a command line without running the command; raise click's UsageError if it does not parse."""
    group = PROGRAMS[program]
    context = group.make_context(program, list(words))
    name, command, rest = group.resolve_command(context, words)
    command.make_context(name, list(rest), parent=context)
    return name


def test_the_help_of_a_program_lists_every_command(capsys):
    for program, group in PROGRAMS.items():
        text = help_of(capsys, program)
        for name in group.list_commands(None):
            assert re.search(rf"^ +{name}\s+\S", text, re.MULTILINE), name


@pytest.mark.parametrize(("program", "name"), COMMANDS)
def test_the_help_of_a_command_has_a_sentence_an_example_and_every_option(capsys, program, name):
    text = help_of(capsys, program, name)
    command = PROGRAMS[program].get_command(None, name)
    context = click.Context(command, info_name=name)

    assert re.match(r"[A-Z][a-z]+ .*\.", command.help, re.DOTALL)
    for option in (one for one in command.params if isinstance(one, click.Option)):
        assert option.get_help_record(context)[1], option.name
        assert option.opts[-1] in text
    for argument in (one for one in command.params if isinstance(one, click.Argument)):
        assert argument.help, argument.name
    assert name in [parse(*example) for example in examples(text)]


def test_the_examples_of_the_programs_and_the_pages_parse(capsys):
    texts = [help_of(capsys, program) for program in PROGRAMS]
    pages = (ROOT / "README.md", ROOT / "fmus" / "README.md", *sorted((ROOT / "docs").glob("*.md")))
    texts += [path.read_text(encoding="utf-8") for path in pages]
    found = [example for text in texts for example in examples(text)]

    assert len(found) > 30
    for program, words in found:
        try:
            parse(program, words)
        except click.UsageError as error:
            raise AssertionError(f"{program} {' '.join(words)}: {error.format_message()}") from None


def test_options_of_one_name_are_one_thing_in_every_command():
    """The same destination, number of values and kind of value, so that a user need not look them up again."""
    seen = {}
    different = {
        "--set",  # an input of the whole system, or of one FMU
        "--input",  # a file with values, or inputs of a bundle
        "--step-size",  # of one component by name, or of the one FMU
        "--out",  # a folder or a file
        "--adapter",  # of several replaced components, or of one FMU
        "--amplitude",  # one for each input, or one for all
        "--scenario",  # one, or several
        "--stop-time",  # a text where it is exact
        "--seed",
        "--vary",  # values of one variable, or kinds of errors
        "--as-published",  # the variant that is simulated, or one of two
    }
    for program, name in COMMANDS:
        for option in PROGRAMS[program].get_command(None, name).params:
            if not isinstance(option, click.Option):
                continue
            spelled = max(option.opts, key=len)
            assert "_" not in spelled
            assert option.opts[-1] == spelled
            kind = (option.name, option.nargs, option.multiple, option.is_flag, type(option.type).__name__)
            if spelled not in different:
                assert seen.setdefault(spelled, kind) == kind, f"{name} {spelled}"


def test_every_command_that_simulates_has_the_same_default_seed_and_the_same_stop_time_option(capsys):
    for name in (
        "run",
        "paper",
        "health",
        "robustness",
        "compare-layouts",
        "budget",
        "waterfall",
        "equivalence",
        "branch",
        "margins",
    ):
        text = " ".join(help_of(capsys, "flexsat", name).split())
        if name != "margins":
            assert " --stop-time S " in text, name
        if name not in ("branch",):
            assert re.search(r"--seed N .*?seed of plant and sensors \(default: 1\)|simulate seeds 1 to N", text), name


TEXTS = (
    "open ",
    "read it: ",
    "make -C ",
    "lockstep.read_signals(",
    "change the file, then ",
)  # no command of a program
WITHOUT = ("build", "campaign", "export")  # what is next depends on what was asked for


@pytest.mark.parametrize(("program", "name"), COMMANDS)
def test_every_command_says_what_to_do_next(program, name):
    then = PROGRAMS[program].get_command(None, name).then
    if name in WITHOUT:
        assert then is None
        return
    if then.startswith(TEXTS):
        return
    parameters = {one.name: ("a.fmu",) for one in PROGRAMS[program].get_command(None, name).params}
    line = then.format_map({**parameters, "program": program, "path": "a.fmu"}).replace("('a.fmu',)", "a.fmu")
    [(_, words)] = examples(line)
    parse(program, words)
