"""The shim before pythonfmu's wrapper: every form of location, errors in the log, and the wrapper's values."""

import os
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

import flexsat.fmu.export
from flexsat.fmu.export import build_fmu
from flexsat.fmu.python.shim import SOURCES, WRAPPER, shim_library
from fmus.toys.builds import TOYS, build, python
from lockstep.check.static.elf import read_library

HOST = """
import ctypes, fmpy, gc, os, shutil, sys
from pathlib import Path
from fmpy import fmi2

class Host:
    def __init__(self, library, guid):
        self.logged = []
        self.guid = guid.encode()
        self.dll = ctypes.CDLL(str(library))
        self.dll.fmi2Instantiate.restype = ctypes.c_void_p
        callbacks = fmi2.fmi2CallbackFunctions()
        callbacks.logger = fmi2.fmi2CallbackLoggerTYPE(
            lambda _, __, status, category, text: self.logged.append((status, category.decode(), text.decode())))
        fmi2.addLoggerProxy(ctypes.byref(callbacks))
        self.callbacks = callbacks

    def instantiate(self, location):
        given = None if location is None else os.fsencode(location)
        self.component = self.dll.fmi2Instantiate(b"toy", 1, self.guid, given, ctypes.byref(self.callbacks), 0, 1)
        return bool(self.component)

    def __getattr__(self, name):
        function = getattr(self.dll, f"fmi2{name}")
        def call(*arguments):
            return function(ctypes.c_void_p(self.component), *arguments)
        return call

    def reals(self, references):
        count = len(references)
        values = (ctypes.c_double * count)()
        assert self.GetReal((ctypes.c_uint * count)(*references), ctypes.c_size_t(count), values) == 0
        return list(values)

    def write(self, references, values):
        count = len(references)
        known = (ctypes.c_uint * count)(*references), ctypes.c_size_t(count)
        return self.SetReal(*known, (ctypes.c_double * count)(*values))

    def start(self, location, *parameters):
        assert self.instantiate(location), self.logged
        self.SetupExperiment(0, ctypes.c_double(0), ctypes.c_double(0), 0, ctypes.c_double(0))
        for known, value in parameters:
            self.write([known], [value])
        self.EnterInitializationMode()
        self.early = self.reals([reference["level[1]"]])  # computed now from the parameters
        self.ExitInitializationMode()
        return self

    def step(self, k):
        return self.DoStep(ctypes.c_double(k * 0.01), ctypes.c_double(0.01), 1)

    def free(self):
        self.dll.fmi2FreeInstance(ctypes.c_void_p(self.component))

folder, guid = Path(sys.argv[1]), sys.argv[2]
library = folder / "binaries" / "linux64" / "toy.so"
description = fmpy.read_model_description(str(folder))
reference = {v.name: v.valueReference for v in description.modelVariables}
location = (folder / "resources").as_uri()
"""


@pytest.fixture(scope="module")
def toy(tmp_path_factory):
    path = tmp_path_factory.mktemp("toy") / "toy.fmu"
    guid, _ = build(path)
    return path, guid


def unpacked(toy, folder):
    with zipfile.ZipFile(toy[0]) as archive:
        archive.extractall(folder)
    return folder, toy[1]


def test_every_form_of_location_is_accepted(toy, tmp_path):
    python(
        HOST
        + """
path = str(folder / "resources")
next_to_binaries = (None, "file:///moved/elsewhere/resources")  # then the resources next to the binaries are used
host = Host(library, guid)
for form in next_to_binaries:
    assert host.instantiate(form), (form, host.logged)
    host.free()
path = str(folder / "elsewhere" / "resources")
(folder / "resources").rename(folder / "somewhere")
(folder / "elsewhere").mkdir()
(folder / "somewhere").rename(path)
for form in (Path(path).as_uri(), f"file://{path}", f"file://localhost{path}", f"file:{path}", path, f"file://{path}/",
             f"file://{path.replace(' ', '%20')}", f"file:///%2E{path}"):
    assert host.instantiate(form), (form, host.logged)
    host.free()
assert host.logged == []
for form in next_to_binaries:
    assert not host.instantiate(form)
""",
        *unpacked(toy, tmp_path / "Größe 100% und Maß"),
    )


@pytest.mark.parametrize(
    ("folder", "location", "message"),
    [
        ("plain", "file:///nowhere/resources", "no resources at fmuResourceLocation = file:///nowhere/resources"),
        ("my%20models", None, "the letters %20 in a path are a blank to pythonfmu's wrapper; unpack elsewhere"),
    ],
)
def test_missing_resources_are_logged_without_ending_the_host(toy, tmp_path, folder, location, message):
    python(
        HOST
        + f"""
if {folder!r} == "plain":
    (folder / "resources").rename(folder / "gone")
host = Host(library, guid)
assert not host.instantiate({location!r} or location)
((status, category, text),) = host.logged
assert (status, category) == (3, "logStatusError")
assert text.startswith({message!r}), text
""",
        *unpacked(toy, tmp_path / folder),
    )


TRACE = """
def trace(library):
    host = Host(library, guid).start(location, (reference["gain"], 1.5))
    torque = [reference[f"wheel.torque[{k}]"] for k in (1, 2, 3)]
    outputs = [reference[name] for name in ("level[1]", "level[2]", "level[3]", "angle", "energy", "wheel.torque[2]")]
    found = [host.early, host.reals(outputs)]
    for k in range(20):
        assert host.write(torque[k % 3:], [0.1 * k, -1.0, 2.0][: 3 - k % 3]) == 0
        assert host.step(k) == 0
        found.append(host.reals(outputs))
        flag = (ctypes.c_int * 1)()
        host.GetBoolean((ctypes.c_uint * 1)(reference["explode"]), ctypes.c_size_t(1), flag)
        found.append([float(flag[0])])
    host.Reset()
    host.SetupExperiment(0, ctypes.c_double(0), ctypes.c_double(0), 0, ctypes.c_double(0))
    host.EnterInitializationMode(); host.ExitInitializationMode()
    found.append(host.reals(outputs))
    assert host.write(torque, [1.0, 2.0, 3.0]) == 0 and host.step(0) == 0
    found.append(host.reals(outputs))
    return host, [[value.hex() for value in row] for row in found]
"""


def test_values_equal_those_of_the_wrapper_alone(toy, tmp_path):
    python(
        HOST
        + TRACE
        + f"""
host, with_shim = trace(library)
host.free()
host, wrapper_alone = trace(library.with_name({WRAPPER!r}))
host.free()
assert with_shim == wrapper_alone
assert len(set(map(str, with_shim))) > 20
""",
        *unpacked(toy, tmp_path / "toy"),
    )


def test_shim_copies_values_without_calling_python(toy, tmp_path):
    """The wrapper alone calls the shell for each set and get; outputs on demand are still computed by it."""
    python(
        HOST
        + TRACE
        + f"""
def calls(library):
    host = Host(library, guid).start(location)
    host.Reset()  # makes another shell
    host.SetupExperiment(0, ctypes.c_double(0), ctypes.c_double(0), 0, ctypes.c_double(0))
    host.EnterInitializationMode(); host.ExitInitializationMode()
    gc.collect()
    (shell,) = [o for o in gc.get_objects() if type(o).__name__ == "Counter" and hasattr(o, "values")]
    seen = []
    for name in ("get_real", "set_real", "get_boolean", "set_boolean"):
        shell.__dict__[name] = lambda *a, name=name, true=getattr(shell, name): seen.append(name) or true(*a)
    host.write([reference["wheel.torque[2]"]], [1.0])
    host.step(0)
    host.reals([reference["level[1]"], reference["angle"]])
    flag = (ctypes.c_int * 1)(0)
    host.SetBoolean((ctypes.c_uint * 1)(reference["explode"]), ctypes.c_size_t(1), flag)
    host.GetBoolean((ctypes.c_uint * 1)(reference["valid"]), ctypes.c_size_t(1), flag)
    assert flag[0] == 1
    copied = list(seen)
    host.reals([reference["level[1]"], reference["energy"]])
    host.write([reference["poison"]], [float("nan")])
    checked = seen[len(copied):]
    host.free()
    return copied, checked
assert calls(library) == ([], ["get_real", "set_real"])
assert calls(library.with_name({WRAPPER!r})) == (["set_real", "get_real", "set_boolean", "get_boolean"],
                                                 ["get_real", "set_real"])
""",
        *unpacked(toy, tmp_path / "toy"),
    )


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("wheel.torque[1]", float("inf"), "setReal: wheel.torque[1] must be finite, got inf"),
        ("gain", 2.0, "setReal: gain is a fixed parameter and cannot be set after initialisation, got 2.0"),
        ("angle", 2.0, "setReal: angle is an output and cannot be set"),
    ],
)
def test_invalid_writes_are_refused_through_the_shim(toy, tmp_path, name, value, message):
    python(
        HOST
        + f"""
host = Host(library, guid).start(location)
assert host.write([reference[{name!r}]], [float({str(value)!r})]) == 3
assert host.logged == [(3, "logStatusError", {message!r})], host.logged
assert host.step(0) == 3
(angle,) = host.reals([reference["angle"]])
assert angle != angle
host.free()
""",
        *unpacked(toy, tmp_path / "toy"),
    )


def test_shim_needs_only_an_old_glibc():
    library = read_library(shim_library())

    assert library.versions["GLIBC"] <= "2.7"  # of 2007; pythonfmu's own library needs a newer one
    assert library.needed == ("libc.so.6",)
    assert len(library.exported) == 34


def test_shim_contains_no_path_of_the_build_machine(tmp_path):
    content = shim_library()

    assert b"flexsat_shim_" not in content
    assert str(tmp_path.parent.parent).encode() not in content


def test_changed_shim_source_gives_another_guid(toy, tmp_path, monkeypatch):
    monkeypatch.setattr(flexsat, "__path__", [*flexsat.__path__, str(TOYS.parent)])
    monkeypatch.setattr(flexsat.fmu.export, "shim_sources", lambda: {name: name.encode() for name in SOURCES})
    try:
        built = build_fmu("flexsat.toys.counter:Counter", tmp_path / "a.fmu", {"model.npz": b"numbers"}, "toy")
    finally:
        for name in [name for name in sys.modules if name.startswith("flexsat.toys")]:
            del sys.modules[name]

    assert built.guid != toy[1]


@pytest.mark.parametrize(
    ("compiler", "message"),
    [
        ("no-such-compiler", "C compiler 'no-such-compiler': not found; install gcc, or name one in CC"),
        ("false", "false cannot compile shim.c: it gave no reason"),
    ],
)
def test_without_a_compiler_nothing_is_built(tmp_path, compiler, message):
    done = subprocess.run(
        [Path(sys.executable).with_name("flexsat"), "build", "--out", tmp_path / "fmus"],
        env=os.environ | {"CC": compiler},
        capture_output=True,
        text=True,
        check=False,
    )

    assert done.returncode == 2
    assert done.stderr == f"flexsat: {message}\n"
    assert not [path for path in tmp_path.rglob("*") if path.is_file()]
