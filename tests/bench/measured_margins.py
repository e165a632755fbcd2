"""Measure the robust design's margins through the FMUs: `python tests/bench/measured_margins.py FMUS [layout]`.

All 198 modes, a test signal at the plant's inputs about each body axis, without noise. What is required: 6 dB up and
down, 30 deg, and 20 ms centralised or 10 ms distributed.
"""

import sys
import tempfile
from math import log10
from pathlib import Path

from flexbench.studies.margins.study import Settings, measure
from flexbench.studies.margins.system_loop import read_loop
from flexsat.parameters import CONFIGURATIONS
from lockstep import load_system

SETTINGS = Settings(length=10.0, settle=1, periods=2, quiet=True, zoom=4.0)  # modes cross gain one between lines


def decibel(factor: float | None) -> str:
    """Return a factor in dB, or that there is none."""
    return f"{20.0 * log10(factor):+.2f} dB" if factor else "none found"


def show(fmus: Path, name: str) -> None:
    """Print the measured margins of one layout."""
    loop = read_loop(load_system(fmus / name / "fine_pointing.ssd"), {})
    with tempfile.TemporaryDirectory() as folder:
        _, margins = measure(loop, SETTINGS, Path(folder))
    for which, found in margins.items():
        if "problem" in found:
            print(f"{name}, {which}: {found['problem']}", flush=True)
            continue
        value = found["value"]
        phase = "none found" if value["phase"] is None else f"{value['phase']:.1f} deg"
        delay = "none found" if value["delay"] is None else f"{1e3 * value['delay']:.1f} ms"
        print(
            f"{name}, {which}: gain {decibel(value['gain_up'])} up, {decibel(value['gain_down'])} down, phase {phase}, "
            f"delay {delay}, disk {value['disk']:.3f}; left out at {value['unresolved']} Hz",
            flush=True,
        )


if __name__ == "__main__":
    for layout in [name for name in CONFIGURATIONS if name in sys.argv[2:]] or CONFIGURATIONS:
        show(Path(sys.argv[1]), layout)
