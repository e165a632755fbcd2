"""The FMUs in a host without Python: `c/host.c`, compiled here and run with few environment variables."""

import subprocess
import sys
import sysconfig
from pathlib import Path

import fmpy
import numpy as np
import pytest
from availability import c_host_lacks as missing
from availability import libpython
from hosting import COMPONENTS, CONFIGURATIONS, HERE, TICK, Row, agreement, joined, ordered
from hosting import ENVIRONMENT as PYTHON_ENVIRONMENT

from flexsat.fmu.python.shim import c_compiler, shim_library
from lockstep import load_system

HEADERS = Path(fmpy.__file__).parent / "c-code"
PERIODS = {"plant": 1, "sensors": 1, "controller": 5}  # ticks
NUMPY = Path(np.__file__).parents[1]


pytestmark = pytest.mark.skipif(bool(missing()), reason=missing() or "available")

# Both sides of a bitwise comparison compute with the same BLAS kernel: its variables are the only ones handed on.
BLAS = {name: value for name, value in PYTHON_ENVIRONMENT.items() if name.startswith(("OPENBLAS_", "OMP_", "MKL_"))}
ENVIRONMENT = BLAS | {"PYTHONHOME": sys.base_prefix, "PYTHONPATH": str(NUMPY)}
PRELOADED = ENVIRONMENT | {"LD_PRELOAD": libpython()}


def compiled(bench):
    """Compile the host once, every warning an error."""
    host = bench.work / "host"
    if not host.exists():
        flags = ["-std=c11", "-O1", "-Wall", "-Wextra", "-Werror", "-I", HEADERS]
        done = subprocess.run(
            [*c_compiler(), *flags, HERE / "c" / "host.c", "-o", host, "-ldl"],
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode == 0, done.stderr
    return host


def unpacked(bench, fmu):
    """Return the lines that name a component, without its period: library, resources and GUID."""
    folder = bench.path(fmu.stem)
    fmpy.extract(str(fmu), str(folder))
    description = bench.description(fmu)
    library = folder / "binaries" / "linux64" / f"{description.coSimulation.modelIdentifier}.so"
    return f"fmu {fmu.stem} {library} {(folder / 'resources').as_uri()} {description.guid}"


def call(bench, lines, environment=PRELOADED, arguments=()):
    """Run the host on a setup."""
    setup = bench.path("setup.txt")
    setup.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return subprocess.run(
        [compiled(bench), setup, *arguments],
        capture_output=True,
        text=True,
        check=False,
        timeout=120,
        env=environment,
        cwd="/",
    )


def trajectory(done, names):
    """Read what the host printed."""
    assert done.returncode == 0, f"exit code {done.returncode}\n{done.stderr}"
    assert done.stderr == ""
    values = np.array([[float(word) for word in line.split()] for line in done.stdout.splitlines()])
    return ordered(names, values)


def single(bench, component, configuration="distributed", ticks=100):
    """Return the setup of one FMU whose real inputs move, and the same for FMPy."""
    fmu = bench.fmu(component, configuration)
    period = PERIODS[component]
    moving = bench.moving(component, configuration)
    lines = [f"run {ticks // period} {period * TICK}", f"{unpacked(bench, fmu)} 1"]
    lines += [f"drive {reference} {start!r}" for reference, start in moving]
    lines += [f"watch {reference}" for reference in bench.outputs(component, configuration).values()]
    return lines, {"inputs": moving, "step": period * TICK, "steps": ticks // period, "times": "integer"}


def loop(bench, ticks, configuration="distributed"):
    """Return the setup of the three FMUs of fine pointing, wired, and the names of what the host prints."""
    system = load_system(bench.folder / configuration / "fine_pointing.ssd")
    parts = {component.name: component for component in system.components}
    fmus = {name: bench.fmu(name, configuration) for name in COMPONENTS}
    variables = {name: {v.name: v for v in bench.description(fmu).modelVariables} for name, fmu in fmus.items()}
    lines, names = [f"run {ticks} {TICK}"], []
    for name in COMPONENTS:
        known = variables[name]
        lines.append(f"{unpacked(bench, fmus[name])} {PERIODS[name]}")
        for parameter, value in parts[name].parameters.items():
            lines.append(f"{known[parameter].type.lower()} {known[parameter].valueReference} {float(value)!r}")
        for wire in system.connections:
            if wire.to_component == name:
                source = variables[wire.from_component][wire.output]
                word = "flag" if source.type == "Boolean" else "wire"
                end = f"{COMPONENTS.index(wire.from_component)} {source.valueReference}"
                lines.append(f"{word} {known[wire.input].valueReference} {end}")
        for output, reference in bench.outputs(name, configuration).items():
            lines.append(f"watch {reference}")
            names.append(f"{name}.{output}")
    return lines, names


def compare(bench, component, configuration):
    """Run one FMU in C and in FMPy."""
    lines, setup = single(bench, component, configuration)
    found = trajectory(call(bench, lines), list(bench.outputs(component, configuration)))
    return Row(
        kind=component,
        host="C program, no Python",
        ran=f"whole life cycle twice, {setup['steps']} steps of {setup['step'] / 1e6:g} ms, inputs moving",
        agreement=agreement(bench.low_level(component, configuration, **setup), found),
        remark="against FMPy's low-level calls; reset, saved and serialised state repeat bitwise",
    )


def rows(bench):
    """Compare, and say so in the table."""
    for component in PERIODS:
        yield joined({configuration: compare(bench, component, configuration) for configuration in CONFIGURATIONS})
    ticks = 200
    lines, names = loop(bench, ticks)
    found = trajectory(call(bench, lines), names)
    yield Row(
        kind="three FMUs in a closed loop",
        host="C program, no Python",
        ran=f"fine pointing in one process, {ticks} ticks at own rates, {len(names)} outputs",
        agreement=agreement(bench.reference(ticks), found),
        remark="against lockstep",
    )


@pytest.mark.parametrize("component", PERIODS)
@pytest.mark.parametrize("configuration", CONFIGURATIONS)
def test_one_fmu_in_c_agrees_bitwise_with_fmpy(bench, configuration, component):
    assert compare(bench, component, configuration).agreement == "bitwise"


def test_three_fmus_in_one_c_process_agree_bitwise_with_our_master(bench):
    lines, names = loop(bench, 200)
    found = trajectory(call(bench, lines), names)

    # that other delays give other values: test_native_fmus.py
    assert agreement(bench.reference(200), found) == "bitwise"


def test_libpython_may_be_loaded_by_the_host_instead_of_preloaded(bench):
    lines, _ = single(bench, "plant", ticks=20)
    preloaded = call(bench, lines)
    loaded = call(bench, lines, ENVIRONMENT, [libpython()])

    assert trajectory(loaded, list(bench.outputs("plant"))).values.any()
    assert loaded.stdout == preloaded.stdout


def test_the_fmu_finds_libpython_where_the_system_does(bench):
    lines, _ = single(bench, "plant", ticks=20)
    found = call(bench, lines, ENVIRONMENT | {"LD_LIBRARY_PATH": str(Path(libpython()).parent)})

    assert found.returncode == 0, found.stderr
    assert found.stdout == call(bench, lines).stdout


def test_without_libpython_the_fmu_says_what_is_missing(bench):
    """The same library, compiled for a libpython that does not exist."""
    lines, _ = single(bench, "plant", ticks=20)
    Path(lines[1].split()[2]).write_bytes(shim_library("libpython0.0.so"))
    done = call(bench, lines, ENVIRONMENT)

    assert done.returncode == 1
    assert "runs in Python, and there is none in this process nor libpython0.0.so on this machine" in done.stderr
    assert "cannot instantiate: plant" in done.stderr


def test_without_numpy_the_fmu_says_what_is_missing(bench):
    """The same Python, its site-packages out of sight."""
    home = bench.path("home")
    version = f"python{sys.version_info.major}.{sys.version_info.minor}"
    standard = Path(sysconfig.get_path("stdlib"))
    place = home / "lib" / version
    place.mkdir(parents=True)
    for entry in standard.iterdir():
        if entry.name not in ("site-packages", "dist-packages"):
            (place / entry.name).symlink_to(entry)
    without = BLAS | {"LD_PRELOAD": libpython(), "PYTHONHOME": str(home), "PYTHONNOUSERSITE": "1"}
    done = call(bench, single(bench, "plant", ticks=20)[0], without)

    assert done.returncode == 1
    assert "No module named 'numpy'" in done.stderr
    assert "cannot instantiate: plant" in done.stderr
