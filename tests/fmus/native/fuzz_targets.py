"""Build the fuzz targets of folder fuzz/ with the sources of a component, by clang with its sanitizers.

Each is a program of libFuzzer: `sequences` makes calls, `states` changes bytes of serialised states.
"""

from __future__ import annotations

import random
import re
import shutil
import subprocess
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from flexsat.description.built_in import configuration
from flexsat.design.chain import build_design, plant_matrices
from flexsat.fmu.native.sources import (
    IDENTITY,
    Identity,
    c_files,
    component_sources,
    generated_sources,
    identity_source,
)
from flexsat.ports import controller, environment, mission, plant, sensors, thrusters
from flexsat.ports.table import PortTable
from flexsat.spacecraft.variation import with_modes
from fmus.mission_numbers import MISSION_DATA
from fmus.native.native_toy import counter_component
from fmus.turning_array import spacecraft

HARNESS = Path(__file__).with_name("fuzz")
TARGETS = ("sequences", "states")
TURNING = "turning_plant"
MISSIONS = {"environment": environment, "thrusters": thrusters, "mission": mission}
STEPS = {"toy": 1e-2, "plant": 1e-3, TURNING: 1e-3, "sensors": 1e-3, "controller": 5e-3,
         "environment": 0.1, "thrusters": 5e-3, "mission": 5e-3}  # fmt: skip  # s
FEW_MODES = 3  # a controller of few modes starts in a millisecond
NAMES = ("corrected", "as_published", "published")  # of the matrices
SPEED = np.array([40.0, -60.0, 55.0, 30.0, -80.0])  # rad/s, of the wheels of the turning spacecraft
GUID = "{11111111-2222-3333-4444-555555555555}"
SANITIZERS = "address,undefined,float-cast-overflow"
OPTIONS = ("-std=c99", "-g", "-O1", "-Wall", "-Wextra", "-Werror", "-ffp-contract=off", "-fno-sanitize-recover=all")


def fuzzer_is_missing() -> str:
    """Return why the targets cannot be built here, or nothing."""
    if shutil.which("clang") is None:
        return "no libFuzzer: `clang` is not on the path"
    command = ["clang", "-print-file-name=libclang_rt.fuzzer-x86_64.a"]
    found = subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()
    return (
        "" if Path(found).is_file() else "clang comes without libFuzzer: install libclang-rt-14-dev, or its version's"
    )


def sources_of(component: str) -> dict[str, bytes]:
    """Return the sources of a native FMU by name: of the toy, of a component of the centralised spacecraft with few
    modes, of the plant of a spacecraft whose arrays turn, or of a component of missions.
    """
    if component == "toy":
        toy = counter_component()
        return _sources(toy.main, toy.table, {}, toy.equal_steps, toy.step_parameter)
    main = c_files()[f"{component.removeprefix('turning_')}.c"]
    if component in MISSIONS:
        table = PortTable(MISSIONS[component].ports(MISSION_DATA))
        return _sources(main, table, {}, component != "environment")
    if component == TURNING:
        with tempfile.TemporaryDirectory() as folder:
            turning = plant_matrices(spacecraft(Path(folder)), SPEED, 1e-3)
        return _sources(main, PortTable(plant.ports(turning)), dict.fromkeys(NAMES[:2], turning), equal_steps=False)
    design = build_design(with_modes(configuration("centralised", "published"), FEW_MODES))
    matrices = getattr(design, component)
    table = PortTable({"plant": plant, "sensors": sensors, "controller": controller}[component].ports(matrices))
    variants = dict.fromkeys(NAMES[: 3 if component == "controller" else 2], matrices)
    return _sources(main, table, variants, component != "plant", "step_size" if component == "sensors" else None)


def _sources(
    main: Path, table: PortTable, variants: Mapping[str, Any], equal_steps: bool, set_by: str | None = None
) -> dict[str, bytes]:
    identity = identity_source(Identity(guid=GUID, equal_steps=equal_steps, step_parameter=set_by))
    return component_sources(main) | generated_sources(main.stem, table, variants) | {IDENTITY: identity}


def build_targets(component: str, sources: Mapping[str, bytes], folder: Path) -> dict[str, Path]:
    """Compile the sources in a folder, with checks of memory and undefined behaviour; return the programs by name."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, content in sources.items():
        (folder / name).write_bytes(content)
    units = sorted(name for name in sources if name.endswith(".c") and name != "data.c")
    _clang(folder, "-c", f"-fsanitize=fuzzer-no-link,{SANITIZERS}", *units)
    if "data.c" in sources:
        _clang(folder, "-c", "data.c")  # numbers alone
    harness = sorted(HARNESS.glob("*.c"))
    _clang(folder, "-c", f"-I{HARNESS}", "-I.", f"-DSTEP={STEPS[component]}", f"-fsanitize={SANITIZERS}", *harness)
    common = [path.with_suffix(".o").name for path in harness if path.stem not in TARGETS]
    objects = [unit.replace(".c", ".o") for unit in units] + ["data.o"] * ("data.c" in sources)
    for target in TARGETS:
        options = (f"-fsanitize=fuzzer,{SANITIZERS}", "-o", target, f"{target}.o", *common, *objects, "-lm")
        _clang(folder, *options)
    return {target: folder / target for target in TARGETS}


def _clang(folder: Path, *arguments: str | Path) -> None:
    done = subprocess.run(["clang", *OPTIONS, *arguments], cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def run_target(program: Path, runs: int, seed: int = 1, size: int = 300) -> dict[str, int]:
    """Run a target on inputs that the seed determines, and return the numbers of calls by what came of them.

    Raises
    ------
    AssertionError
        With what the target printed, if a check of the target or a sanitizer fails.
    """
    begin = program.with_name(f"{program.name}_{seed}_inputs")
    begin.mkdir(exist_ok=True)
    numbers = random.Random(seed)
    for k in range(64):
        (begin / str(k)).write_bytes(numbers.randbytes(size))
    command = [program, f"-seed={seed}", f"-runs={runs}", f"-max_len={size}", "-len_control=0", "-timeout=60",
               f"-artifact_prefix={program.parent}/", "-verbosity=0", begin]  # fmt: skip
    done = subprocess.run(command, cwd=program.parent, capture_output=True, text=True, errors="replace", check=False)
    assert done.returncode == 0, done.stderr[-8000:]
    counted = re.search(r"calls: (\d+) OK, (\d+) warnings, (\d+) discarded, (\d+) refused; (\d+) steps", done.stderr)
    assert counted is not None, done.stderr[-8000:]
    names = ("ok", "warnings", "discarded", "refused", "steps")
    return dict(zip(names, map(int, counted.groups()), strict=True))
