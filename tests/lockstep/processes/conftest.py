"""Compiled FMUs with one defect each, systems of two of them, and their runs in one process that must survive all."""

import json
import subprocess
import sys

import pytest

from fmus.bad.bad_fmus import bad_fmu
from lockstep import Component, Connection, System, write_ssd

STEP = 10_000_000  # [ns] the FMUs accept no other
LEVEL, RATE = {"level": 1.0}, {"rate": 1.0}
SAME_TICK, NEXT_TICK = 0, 1

# Many runs in one process: it is the claim that no FMU can take it down. What each of them left is looked for at once.
RUNS = """
import contextlib, gc, io, json, os, sys, tempfile
from pathlib import Path
from lockstep.__main__ import main

def processes(mark):
    found = []
    for folder in Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError):
            state = (folder / "stat").read_text().rpartition(")")[2].split()[0]
            if state != "Z" and mark.encode() in (folder / "environ").read_bytes() and folder.name != str(os.getpid()):
                found.append((folder / "cmdline").read_text())
    return found

ended = {}
for name, (folder, arguments) in json.loads(sys.argv[1]).items():
    place = Path(folder, "temporary")
    place.mkdir(parents=True)
    tempfile.tempdir = str(place)
    os.environ["DIARY"], os.environ["MEETING"] = str(Path(folder, "diary")), folder
    error = io.StringIO()
    with contextlib.redirect_stderr(error), contextlib.redirect_stdout(io.StringIO()):
        code = main(arguments)
    lines = [line for line in error.getvalue().splitlines() if line.startswith("lockstep: ")]
    gc.collect()  # a map of shared memory holds a descriptor until nothing refers to it
    ended[name] = {"code": code, "lines": lines, "processes": processes(str(place)), "left": os.listdir(place),
                  "descriptors": len(os.listdir("/proc/self/fd"))}
print("ended:" + json.dumps(ended))
"""


@pytest.fixture(scope="session")
def runs():
    """Return a function that runs command lines by name, each with its folder, in one process."""

    def run(cases):
        given = {name: (str(folder), [str(a) for a in arguments]) for name, (folder, arguments) in cases.items()}
        done = subprocess.run(
            [sys.executable, "-W", "error", "-c", RUNS, json.dumps(given)], capture_output=True, text=True, check=False
        )
        assert done.returncode == 0, done.stderr
        return json.loads(done.stdout.rpartition("ended:")[2])

    return run


@pytest.fixture(scope="session")
def good(tmp_path_factory):
    """Return an FMU without a defect, which notes when it is terminated and freed."""
    return bad_fmu(tmp_path_factory.mktemp("good"), "KEEPS_A_DIARY")


@pytest.fixture(scope="session")
def pair():
    """Return a function that writes a system of FMUs `a`, and `b` that reads of it with a delay."""

    def write(folder, a, b, delay=SAME_TICK, **options):
        parts = {"a": a, "b": b}
        system = System(
            name="pair",
            tick=STEP,
            stop_time=20 * STEP,
            components=tuple(
                Component(name=name, source=fmu, period=STEP, kind="sampled", parameters=given, **options)
                for (name, fmu), given in zip(parts.items(), (LEVEL | RATE, RATE), strict=True)
            ),
            connections=(
                Connection(from_component="a", output="scaled", to_component="b", input="level", delay=delay),
            ),
        )
        folder.mkdir(parents=True, exist_ok=True)
        write_ssd(system, folder / "pair.ssd")
        return folder / "pair.ssd"

    return write
