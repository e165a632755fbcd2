"""A bundle in FMPy, in libcosim, and in a C program without Python, which saves, serialises and resets it: bitwise."""

import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import fmpy
import numpy as np
import pytest

from fmus.bundle_host import CLOSED, MS, bundled, recorded
from fmus.c_fmu import HEADERS
from lockstep import Component
from lockstep.fmi.model_description import read_description
from lockstep.ssp.write_package import package
from lockstep.system.system import System

TICKS = 40
HOST = Path(__file__).parents[2] / "hosts" / "c" / "host.c"
_LIBCOSIM = """
import os, sys
from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimObserver import CosimObserver
execution = CosimExecution.from_ssp_file(ssp_path=sys.argv[1], step_size=1_000_000)
observer = CosimObserver.create_last_value()
execution.add_observer(observer)
slave = execution.slave_index_from_instance_name("four")
for _ in range(int(sys.argv[2])):
    assert execution.step()
    print("row", *map(float.hex, observer.last_real_values(slave_index=slave, variable_references=eval(sys.argv[3]))))
sys.stdout.flush()
os._exit(0)
"""


@pytest.fixture(scope="module")
def path(cells, tmp_path_factory):
    """Return the bundle."""
    return bundled(cells, tmp_path_factory.mktemp("hosts") / "four.fmu", CLOSED)


@pytest.fixture(scope="module")
def expected(cells):
    """Return Reals of the master by name, from the first tick on."""
    found = recorded(cells, TICKS / 1000)
    return {name: values for name, values in found.items() if ".y[" in name}


def references(path, names):
    """Return the value references of variables."""
    description = read_description(Component(name="four", source=path, period=MS))
    return description, [description.variables[name].reference for name in names]


def test_fmpy_gives_the_same_bits(path, expected):
    # an interval that FMPy adds up to the same times; the last one of it is the start of the last step
    found = fmpy.simulate_fmu(str(path), stop_time=TICKS / 1000, step_size=0.001, output_interval=0.001,
                              output=list(expected))  # fmt: skip
    assert len(found) == TICKS + 1
    for name, values in expected.items():
        assert found[name].tobytes() == values.tobytes(), name


def test_a_c_program_gives_the_same_bits_also_from_states_and_after_a_reset(path, expected, tmp_path):
    description, numbers = references(path, expected)
    unpacked = Path(fmpy.extract(str(path), str(tmp_path / "unpacked")))
    command = ["gcc", "-std=c11", "-O1", f"-I{HEADERS}", HOST, "-o", tmp_path / "host", "-ldl"]
    subprocess.run(command, check=True)
    library = unpacked / "binaries" / "linux64" / f"{description.identifier}.so"
    lines = [f"run {TICKS} {MS}",
             f"fmu four {library} {(unpacked / 'resources').as_uri()} {description.guid} 1",
             *(f"watch {number}" for number in numbers)]  # fmt: skip
    (tmp_path / "setup.txt").write_text("\n".join(lines), encoding="utf-8")
    done = subprocess.run([tmp_path / "host", tmp_path / "setup.txt"], capture_output=True, text=True, check=False)

    assert (done.returncode, done.stderr) == (0, "")
    found = np.array([line.split() for line in done.stdout.splitlines()], float)
    wanted = np.column_stack([values[1:] for values in expected.values()])
    assert found.tobytes() == np.ascontiguousarray(wanted).tobytes()


@pytest.mark.skipif(find_spec("libcosimpy") is None, reason="no libcosimpy")
def test_libcosim_gives_the_same_bits(path, expected, tmp_path):
    part = Component(name="four", source=path, period=MS)
    (tmp_path / "four.ssp").write_bytes(package(System(name="outer", tick=MS, components=(part,)), ()))
    _, numbers = references(path, expected)
    arguments = [str(tmp_path / "four.ssp"), str(TICKS), repr(numbers)]
    done = subprocess.run([sys.executable, "-c", _LIBCOSIM, *arguments], capture_output=True, text=True, check=False)

    assert done.returncode == 0, done.stderr
    rows = (line.split()[1:] for line in done.stdout.splitlines() if line.startswith("row "))  # it logs there too
    found = np.array([[float.fromhex(word) for word in row] for row in rows])
    wanted = np.column_stack([values[1:] for values in expected.values()])
    assert found.tobytes() == np.ascontiguousarray(wanted).tobytes()
