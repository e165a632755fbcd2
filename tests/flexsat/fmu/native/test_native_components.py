"""The six native FMUs of the study: equal to those in Python, alone and in the closed loop, without Python."""

import json
import subprocess
import sys
import zipfile
from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pytest

from flexbench.loop.native_fmus import with_native_fmus
from fmus.toys.builds import TOYS, python
from lockstep import load_system, read_signals, simulate

LAYOUTS, COMPONENTS = ("centralised", "distributed"), ("plant", "sensors", "controller")
LIBRARIES = {"linux-vdso.so.1", "libc.so.6", "libm.so.6", "ld-linux-x86-64.so.2"}
WARNINGS = ("-std=c99", "-O2", "-Wall", "-Wextra", "-Wconversion", "-Werror", "-ffp-contract=off", "-fsyntax-only")
SAME = 1e-10  # of the largest value of an array of signals: the bound of the issue; 7e-13 was seen over 8 s


@pytest.fixture
def six(delivered):
    return [delivered / layout / "native" / f"{component}.fmu" for layout in LAYOUTS for component in COMPONENTS]


def description(path):
    with zipfile.ZipFile(path) as archive:
        return ElementTree.fromstring(archive.read("modelDescription.xml"))


def test_each_layout_has_them_beside_the_others(six):
    for path in six:
        python_fmu, native = description(path.parents[1] / path.name), description(path)
        for part in ("ModelVariables", "UnitDefinitions", "ModelStructure", "DefaultExperiment"):
            texts = [[(e.tag, e.attrib) for e in root.find(part).iter()] for root in (python_fmu, native)]
            assert texts[0] == texts[1], (path, part)
        assert native.get("modelName") == python_fmu.get("modelName")
        with zipfile.ZipFile(path) as archive, zipfile.ZipFile(path.parents[1] / path.name) as other:
            page = archive.read("documentation/index.html").decode()
            assert f"-o {native.get('modelName')}.so *.c -lm" in page
            assert "libpython" not in page
            assert "pythonfmu" not in page
            for name in archive.namelist():
                if name.startswith(("extra/", "terminalsAndIcons/", "model.png")):
                    assert archive.read(name) == other.read(name), name


def test_they_need_libc_and_libm_alone_and_compile_without_warnings(six, tmp_path):
    for path in six:
        folder = tmp_path / path.parents[1].name / path.stem
        with zipfile.ZipFile(path) as archive:
            archive.extractall(folder)
        (library,) = (folder / "binaries" / "linux64").iterdir()
        listed = subprocess.run(["ldd", library], capture_output=True, text=True, check=True).stdout
        assert {line.split()[0].rsplit("/", 1)[-1] for line in listed.splitlines()} <= LIBRARIES
        if path.parents[1].name == "distributed":
            sources = [file.name for file in (folder / "sources").glob("*.c") if file.name != "data.c"]
            command = ["gcc", *WARNINGS, *sources]
            done = subprocess.run(command, cwd=folder / "sources", capture_output=True, text=True, check=False)
            assert done.returncode == 0, done.stderr


def test_their_reference_results_are_those_of_the_python_fmus(six):
    python("from replay import check_experiments; [check_experiments(path, 1e-9) for path in sys.argv[1:]]", *six[:3])


def difference(one, other):
    """Return the largest difference of two runs, relative to the largest value of each array of signals."""
    first, second = read_signals(one).columns, read_signals(other).columns
    arrays = {}
    for name in first:
        arrays.setdefault(name.partition("[")[0], []).append(name)
    worst = 0.0
    for names in arrays.values():
        a, b = (np.stack([columns[name] for name in names]) for columns in (first, second))
        worst = max(worst, np.abs(a - b).max() / (np.abs(a).max() or 1.0))
    return worst


@pytest.mark.parametrize("layout", LAYOUTS)
def test_the_closed_loop_is_that_of_the_python_fmus(delivered, tmp_path, layout):
    """Noise, jitter and random wheel phases are on; the default seed."""
    ways = {
        "python": delivered / layout / "fine_pointing.ssd",
        "native": delivered / layout / "native/fine_pointing.ssd",
    }
    for name, path in ways.items():
        simulate(load_system(path), tmp_path / name, stop_time=2.0)
    assert read_signals(tmp_path / "native").columns["controller.wheel.torque[1]"].any()
    assert difference(tmp_path / "python", tmp_path / "native") < SAME

    if layout == "centralised":  # a native plant with sensors and a controller in Python, and the other way round
        system = load_system(ways["python"])
        native = with_native_fmus(system)
        for parts in ({"plant"}, {"sensors", "controller"}):
            mixed = [n if c.name in parts else c for c, n in zip(system.components, native.components, strict=True)]
            out = tmp_path / "-".join(sorted(parts))
            simulate(replace(system, components=tuple(mixed)), out, stop_time=0.5)
            a, b = read_signals(tmp_path / "python").columns, read_signals(out).columns
            rate = "plant.rate[1]"
            assert np.abs(b[rate] - a[rate][: len(b[rate])]).max() < SAME * np.abs(a[rate]).max()


SAVE = """
from driven import *
import json
from pathlib import Path
with Driven(sys.argv[1]) as one, Driven(sys.argv[1], "two") as two:
    one.initialize()
    one.drive(0, 33)
    state = one.fmu.getFMUState()
    content = bytes(one.fmu.serializeFMUState(state))
    rest = one.drive(33, 60)
    one.fmu.setFMUState(state)
    assert one.drive(33, 60) == rest
    one.fmu.freeFMUState(state)
    two.initialize()
    assert two.drive(0, 60)[33:] == rest
    one.fmu.reset(); one.initialize()
    assert one.drive(0, 60)[33:] == rest
    one.fmu.reset()
    state = one.fmu.deSerializeFMUstate(content)
    one.fmu.setFMUState(state)
    assert one.drive(33, 60) == rest
    assert not one.messages
Path(sys.argv[2]).write_bytes(content)
Path(sys.argv[3]).write_text(json.dumps(rest))
"""
RESUME = """
from driven import *
import json
from pathlib import Path
with Driven(sys.argv[1]) as one:
    state = one.fmu.deSerializeFMUstate(Path(sys.argv[2]).read_bytes())
    one.fmu.setFMUState(state)
    assert one.drive(33, 60) == json.loads(Path(sys.argv[3]).read_text())
"""


@pytest.mark.parametrize("component", COMPONENTS)
def test_a_saved_state_goes_on_bitwise_here_and_in_another_process(delivered, component, tmp_path):
    fmu = delivered / "centralised" / "native" / f"{component}.fmu"
    python(SAVE, fmu, tmp_path / "state", tmp_path / "rest")
    python(RESUME, fmu, tmp_path / "state", tmp_path / "rest")


def test_sequences_of_calls_are_answered_as_the_standard_says(six):
    """In a process of its own, so that a crash is a failure; tests/bench/fuzz_fmus.py makes 20,000."""
    script = TOYS.parent / "call_sequences.py"
    done = subprocess.run(
        [sys.executable, script, *six, "--sequences", "42"], capture_output=True, text=True, check=False, timeout=300
    )

    assert done.returncode == 0, f"{done.stdout}\n{done.stderr}"
    results = [json.loads(line) for line in done.stdout.splitlines()]
    assert len(results) == 6
    for result in results:
        assert sum(result["refused"].values()) > 2 * 42
