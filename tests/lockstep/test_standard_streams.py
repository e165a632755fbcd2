"""Standard output and standard error: closed, in ASCII, full, and with control characters of others."""

import io
import subprocess
import sys

import numpy as np
import pytest

from fmus.bad.bad_fmus import bad_fmu
from lockstep import Component, System, read_signals, simulate
from lockstep.standard_streams import PlainStream, StreamError, printable, standard_streams, unfiltered

STEP = 10_000_000  # [ns]
PRINTED = "x" * 1024  # by the FMU, in its sixth step
# runs a command in the process of the FMU; its code is the exit code, since nothing can be printed
RUN = """
import sys
from lockstep.__main__ import main
sys.exit(main(sys.argv[1:]))
"""


@pytest.fixture(scope="module")
def talkative(tmp_path_factory):
    """Return an FMU that prints two megabytes to standard output."""
    return bad_fmu(tmp_path_factory.mktemp("talkative"), "FLOODS_THE_LOG")


def test_what_an_fmu_prints_does_not_get_into_results_of_a_program_without_standard_streams(talkative, tmp_path):
    """The first file that is opened while standard output is closed becomes standard output."""
    options = ["--set", "talkative.level=1", "--set", "talkative.rate=1", "--stop-time", "0.1", "--out"]
    path = talkative.rename(talkative.with_name("talkative.fmu"))
    run = [
        sys.executable,
        "-c",
        RUN,
        "run",
        str(path),
        *options,
        str(tmp_path / "closed"),
        "--share-process",
        "talkative",
    ]
    done = subprocess.run(["sh", "-c", '"$@" <&- >&- 2>&-', "sh", *run], check=False, timeout=60)
    component = Component(
        name="talkative",
        source=path,
        period=STEP,
        isolated=False,
        parameters={"level": 1.0, "rate": 1.0},
    )
    simulate(System(name="open", tick=STEP, components=(component,), stop_time=10 * STEP), tmp_path / "open")

    assert done.returncode == 0
    closed, opened = (read_signals(tmp_path / name) for name in ("closed", "open"))
    assert len(closed.time) == 11
    assert np.ptp(closed["talkative.filtered"]) > 0.0
    for name in opened.columns:
        np.testing.assert_array_equal(closed[name], opened[name])
    assert not [p for p in (tmp_path / "closed").iterdir() if PRINTED.encode() in p.read_bytes().replace(b"\n", b"")
                and p.name != "events.jsonl"]  # fmt: skip


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("mass [kg], Größe µ", "mass [kg], Größe µ"),
        ("\x1b[2Jgone\x07", "\\u001b[2Jgone\\u0007"),
        ("\x9b31m\x7f", "\\u009b31m\\u007f"),  # the same as ESC [, in one character of Latin-1
        ("a\u202etxt.exe", "a\\u202etxt.exe"),  # reverses what follows
        ("t\udce9st", "t\\udce9st"),  # a byte of a path that is no UTF-8
        ("two\nlines\tof text", "two\\u000alines\\u0009of text"),
    ],
)
def test_control_characters_are_escaped(text, shown):
    assert printable(text) == shown


def test_lines_and_tabs_are_kept_in_what_is_printed_and_all_else_is_escaped(monkeypatch):
    output, error = io.StringIO(), io.StringIO()
    monkeypatch.setattr(sys, "stdout", output)
    monkeypatch.setattr(sys, "stderr", error)
    with standard_streams():
        print("a\tb\x1b[1m")
        print("c\x1b]0;title\x07", file=sys.stderr)
        print("\x1b[1mbold", file=unfiltered(sys.stdout), end="")

    assert (sys.stdout, sys.stderr) == (output, error)
    assert output.getvalue() == "a\tb\\u001b[1m\n\x1b[1mbold"
    assert error.getvalue() == "c\\u001b]0;title\\u0007\n"


def test_letters_that_the_encoding_lacks_are_escaped():
    raw = io.BytesIO()
    stream = PlainStream(io.TextIOWrapper(raw, encoding="ascii", write_through=True), required=True)
    print("results/Größe", file=stream)

    assert raw.getvalue() == b"results/Gr\\xf6\\xdfe\n"


@pytest.mark.parametrize("required", [True, False])
def test_a_full_disk_is_an_error_of_standard_output_alone(required):
    with open("/dev/full", "w", encoding="utf-8") as full:  # noqa: PTH123
        stream = PlainStream(full, required=required)
        stream.write("lost")
        if required:
            with pytest.raises(StreamError, match="standard output: No space left on device"):
                stream.flush()
        else:
            stream.flush()  # progress: the run goes on without it
        stream.flush()  # what could not be written is not reported again
