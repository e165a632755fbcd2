"""The native FMUs and a bundle of them for Windows and for Linux on ARM, in the host in C, against those for Linux."""

import shutil
import subprocess
import zipfile
from dataclasses import replace

import fmpy
import numpy as np
import pytest
from availability import c_host_lacks
from hosting import COMPONENTS, TICK, NativeBench
from other_platforms import build_host, build_libraries, emulator, lacks
from test_c_host import call, loop, trajectory

from fmus.native.library_facts import elf_facts, windows_facts
from lockstep import load_system
from lockstep.bundle.contents import contents
from lockstep.bundle.ports import Choice
from lockstep.bundle.write import bundle_bytes
from lockstep.fmi.model_description import read_description

PLATFORMS = {"win64": ".dll", "aarch64-linux": ".so"}
TICKS = 300  # three samples of the star tracker; emulators take ten times as long as this processor
EVERYTHING = Choice(inputs=("none",), outputs=("all",))

pytestmark = pytest.mark.skipif(bool(c_host_lacks()), reason=c_host_lacks() or "available")


@pytest.fixture(scope="module")
def native(delivered, tmp_path_factory):
    return NativeBench(delivered, tmp_path_factory.mktemp("platforms"))


@pytest.fixture(scope="module")
def setup(native):
    """Return the closed loop of the centralised layout as the host takes it, and its run on Linux."""
    lines, names = loop(native, TICKS, "centralised")
    return lines, names, trajectory(call(native, lines, environment={}), names)


@pytest.fixture(scope="session", params=PLATFORMS)
def foreign(request, once, delivered):
    """Return a platform, and the folder of the host and the libraries for it."""
    platform = request.param
    if lacks(platform):
        pytest.skip(lacks(platform))

    def build(folder):
        folder.mkdir()
        build_host(platform, folder / "host")
        for component in COMPONENTS:
            build_libraries(delivered / "centralised" / "native" / f"{component}.fmu", (platform,), folder)

    return platform, once(f"libraries-{platform}", build)


def elsewhere(lines, platform, folder, root):
    """Return the setup with the libraries of another platform."""
    for line in lines:
        words = line.split()
        if words[0] == "fmu":
            words[2] = f"{root}{folder / words[1] / platform / (words[1] + PLATFORMS[platform])}"
        yield " ".join(words)


@pytest.mark.parametrize("component", COMPONENTS)
def test_the_libraries_export_fmi_alone_and_need_the_c_library_alone(foreign, component):
    platform, folder = foreign
    content = (folder / component / platform / f"{component}{PLATFORMS[platform]}").read_bytes()
    facts = windows_facts(content) if platform == "win64" else elf_facts(content)

    assert len(facts.exports) == 34  # of FMI 2.0 for co-simulation
    assert all(name.startswith("fmi2") for name in facts.exports)
    if platform == "win64":
        assert facts.machine == 0x8664
        assert all(name.startswith("api-ms-win-crt-") for name in facts.needed)  # the Universal C Runtime
    else:
        assert facts.machine == "EM_AARCH64"
        assert facts.needed <= {"libc.so.6", "libm.so.6"}
        assert max(facts.versions) <= (2, 17)


def test_the_closed_loop_is_that_of_linux(native, setup, foreign):
    lines, names, expected = setup
    platform, folder = foreign
    given = native.path("setup.txt")
    with emulator(platform, native.path("emulator")) as here:
        given.write_text("\n".join(elsewhere(lines, platform, folder, here.root)) + "\n", encoding="utf-8")
        command = [*here.command, f"{here.root}{folder / 'host'}", f"{here.root}{given}"]
        done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=300,
                              env=here.environment or None)  # fmt: skip
    found = trajectory(done, names)  # after reset, from a saved and from a serialised state too, bitwise

    assert found.names == expected.names
    assert differences(expected, found) == {}


def differences(expected, found):
    """Return by port how far apart two runs are, over the largest value of it, where that is more than 1e-12."""
    ports = sorted({name.partition("[")[0] for name in expected.names})
    apart = {port: np.abs(expected[port] - found[port]).max() for port in ports}
    largest = {port: max(np.abs(expected[port]).max(), np.abs(found[port]).max()) for port in ports}
    assert sum(value > 0.0 for value in largest.values()) > 20, "nothing moves, so that nothing is compared"
    return {port: apart[port] / largest[port] for port in ports if apart[port] > 1e-12 * largest[port]}


def unpacked_bundle(system, platforms, folder):
    """Return the folder of a bundle of the closed loop, unpacked."""
    (folder / "loop.fmu").write_bytes(bundle_bytes(contents(system, {}, EVERYTHING, None), platforms))
    fmpy.extract(str(folder / "loop.fmu"), str(folder / "loop"))
    return folder / "loop"


@pytest.fixture(scope="module")
def system(delivered):
    """Return the closed loop of the native FMUs for Linux."""
    return load_system(delivered / "centralised" / "native" / "closed" / "fine_pointing.ssd")


@pytest.fixture(scope="module")
def on_linux(native, system, tmp_path_factory):
    """Return the names of a bundle's outputs, and its run on Linux."""
    lines, names = bundle_setup(unpacked_bundle(system, (), tmp_path_factory.mktemp("bundle")), "linux64", ".so")
    return names, trajectory(call(native, lines, environment={}), names)


@pytest.fixture(scope="module")
def bundle(foreign, system, tmp_path_factory):
    """Return the folder of the bundle for another platform."""
    platform, libraries = foreign
    folder = tmp_path_factory.mktemp(f"bundle-{platform}")
    parts = []
    for part in system.components:
        fmu = folder / part.source.name
        shutil.copy(part.source, fmu)
        library = f"{part.source.stem}{PLATFORMS[platform]}"
        with zipfile.ZipFile(fmu, "a") as archive:
            name = f"binaries/{platform}/{read_description(part).identifier}{PLATFORMS[platform]}"
            archive.write(libraries / part.source.stem / platform / library, name)
        parts.append(replace(part, source=fmu))
    return unpacked_bundle(replace(system, components=tuple(parts)), (platform,), folder)


def bundle_setup(unpacked, folder, suffix, root=""):
    """Return the lines that run a bundle, and the names of what the host prints."""
    description = fmpy.read_model_description(str(unpacked))
    identifier = description.coSimulation.modelIdentifier
    outputs = [v for v in description.modelVariables if v.causality == "output" and v.type == "Real"]
    resources = (unpacked / "resources").as_uri().replace("file:///", f"file:///{root}/" if root else "file:///")
    library = f"{root}{unpacked / 'binaries' / folder / (identifier + suffix)}"
    lines = [f"run {TICKS} {TICK}", f"fmu loop {library} {resources} {description.guid} 1"]
    return [*lines, *(f"watch {v.valueReference}" for v in outputs)], [v.name for v in outputs]


def test_a_bundle_of_the_closed_loop_is_that_of_linux(native, foreign, bundle, on_linux):
    """A system as one FMU loads the libraries of its components by itself; from saved states too."""
    platform, folder = foreign
    names, expected = on_linux
    given = native.path("setup.txt")
    with emulator(platform, native.path("emulator")) as here:
        lines, others = bundle_setup(bundle, platform, PLATFORMS[platform], here.root)
        given.write_text("\n".join(lines) + "\n", encoding="utf-8")
        command = [*here.command, f"{here.root}{folder / 'host'}", f"{here.root}{given}"]
        done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=300,
                              env=here.environment or None)  # fmt: skip
    found = trajectory(done, names)

    assert others == names
    assert differences(expected, found) == {}
