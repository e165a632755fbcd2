"""Containers of the three components for fmu-manipulation-toolbox, in its JSON form.

A container has one step for all that it holds. `plain` holds the three at one step; `nested` holds the controller at
5 ms and a container `spacecraft` with sensors and plant at 1 ms. What is linked is shown by the toolbox as a local
`component.port`, so outputs carry the prefix `out.`.
"""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any

from fmu_manipulation_toolbox.assembly import Assembly
from loop import ClosedLoop

FAST = ("sensors", "plant")
FAST_STEP, SLOW_STEP = 1e-3, 5e-3  # [s]
EXPLICIT = {"auto_link": False, "auto_input": False, "auto_output": False}
SPACECRAFT = "spacecraft.fmu"


def build(description: dict[str, Any], loop: ClosedLoop, folder: Path) -> Path:
    """Make a container of the FMUs of a loop, and return it."""
    for name, path in loop.fmus.items():
        shutil.copy(path, folder / f"{name}.fmu")
    (folder / "container.json").write_text(json.dumps(description), encoding="utf-8")
    Assembly("container.json", fmu_directory=folder).make_fmu()
    return folder / description["name"]


def plain(loop: ClosedLoop, sequential: bool, step: float) -> dict[str, Any]:
    """Return the container of all three at one step: in the order of the loop, or each with values a step old."""
    return EXPLICIT | {
        "name": "plain.fmu",
        "step_size": step,
        "sequential": sequential,
        "fmu": [f"{name}.fmu" for name in loop.fmus],
        "link": [[f"{source}.fmu", output, f"{to}.fmu", target] for source, output, to, target in loop.connections],
        "output": [[f"{name}.fmu", output, f"out.{name}.{output}"] for name, output in _shown(loop, loop.fmus)],
        "start": _start(loop, loop.fmus),
    }


def spacecraft(loop: ClosedLoop) -> dict[str, Any]:
    """Return the container of sensors and plant: wheel torques in, measurements and true motion out."""
    inner = [wire for wire in loop.connections if wire[0] in FAST and wire[2] in FAST]
    return EXPLICIT | {
        "name": SPACECRAFT,
        "step_size": FAST_STEP,
        "sequential": True,
        "fmu": [f"{name}.fmu" for name in FAST],
        "link": [[f"{source}.fmu", output, f"{to}.fmu", target] for source, output, to, target in inner],
        "input": [[f"in.{to}.{target}", f"{to}.fmu", target] for _, _, to, target in _from(loop, "controller")],
        "output": [[f"{name}.fmu", output, f"out.{name}.{output}"] for name, output in _shown(loop, FAST)],
        "start": _start(loop, FAST),
    }


def nested(loop: ClosedLoop) -> dict[str, Any]:
    """Return the container of the controller and of `spacecraft`, which steps first."""
    commands = _from(loop, "controller")
    measurements = [wire for wire in loop.connections if wire[2] == "controller"]
    shown = [[SPACECRAFT, f"out.{name}.{output}", f"out.{name}.{output}"] for name, output in _shown(loop, FAST)]
    own = [["controller.fmu", output, f"out.controller.{output}"] for _, output in _shown(loop, ("controller",))]
    return EXPLICIT | {
        "name": "nested.fmu",
        "step_size": SLOW_STEP,
        "sequential": True,
        "container": [spacecraft(loop)],
        "fmu": ["controller.fmu"],
        "link": [
            *([SPACECRAFT, f"out.{source}.{output}", "controller.fmu", to] for source, output, _, to in measurements),
            *(["controller.fmu", output, SPACECRAFT, f"in.{to}.{target}"] for _, output, to, target in commands),
        ],
        # what is linked between the two is shown under the names of the links
        "output": [[fmu, output, f"all.{name.removeprefix('out.')}"] for fmu, output, name in [*shown, *own]],
        "start": _start(loop, ("controller",)),
    }


def _from(loop: ClosedLoop, name: str) -> list[tuple[str, str, str, str]]:
    return [wire for wire in loop.connections if wire[0] == name]


def _shown(loop: ClosedLoop, names: Any) -> list[tuple[str, str]]:
    """Return component and output of what is saved, and of what is connected to others."""
    pairs = [(name, output) for name in names for output in loop.outputs[name]]
    pairs += [(source, output) for source, output, *_ in loop.connections if source in names]
    return list(dict.fromkeys(pairs))


def _start(loop: ClosedLoop, names: Any) -> list[list[str]]:
    return [[f"{n}.fmu", port, _text(value)] for n in names for port, value in loop.values[n].items()]


def _text(value: Any) -> str:
    return str(int(value)) if isinstance(value, bool) else repr(value)
