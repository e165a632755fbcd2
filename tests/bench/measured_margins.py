"""Measure the robust design's margins through the FMUs: `python tests/bench/measured_margins.py FMUS [layout]`.

All 198 modes, without noise. First whole co-simulations with the gain, the phase or the delay at the plant's inputs
changed: from a small deflection of everything the motion must decay within what is required (6 dB up and down, 30 deg,
20 ms centralised and 10 ms distributed), and it grows beyond the margin that linear analysis finds. A phase common to
all frequencies is complex: two copies of the loop carry its parts. With `--response` also the loop's response to a test
signal about each body axis, and margins from that.
"""

import sys
import tempfile
from math import log10
from pathlib import Path

from flexbench.studies.margins.changed_loop import Change, fly
from flexbench.studies.margins.real_plant import Corner, stability
from flexbench.studies.margins.study import MeasurementSettings, measure
from flexbench.studies.margins.system_loop import read_loop
from flexbench.studies.spillover.corners import DELAY, GAINS, PHASE
from flexsat.description.built_in import CONFIGURATIONS
from flexsat.parameters import ALL_MODES
from lockstep import load_system

SETTINGS = MeasurementSettings(
    length=10.0, settle=1, periods=2, quiet=True, zoom=4.0
)  # modes cross gain one between lines
BEYOND = {  # near the margins that linear analysis finds
    "centralised": [Change(gain=6.0), Change(gain=7.0), Change(phase=60.0), Change(delay=0.1)],
    "distributed": [Change(gain=4.0), Change(phase=60.0), Change(delay=0.02), Change(delay=0.03)],
}


def decibel(factor: float | None) -> str:
    """Return a factor in dB, or that there is none."""
    return f"{20.0 * log10(factor):+.2f} dB" if factor else "none found"


def fly_changes(fmus: Path, name: str) -> None:
    """Print how the motion of each changed loop grows, beside linear analysis."""
    loop = read_loop(load_system(fmus / name / "fine_pointing.ssd"), {})
    required = [Change(), *(Change(gain=gain) for gain in GAINS), Change(phase=PHASE), Change(delay=DELAY[name])]
    with tempfile.TemporaryDirectory() as folder:
        for change in (*required, *BEYOND[name]):
            found = fly(loop, change, Path(folder))
            corner = Corner(modes=ALL_MODES, gain=change.gain, phase=-change.phase, delay=change.delay)
            linear = stability(loop.real, corner, loop=loop.designed)
            print(
                f"{name}, {change.title:14}: FMUs {'grow ' if found.rate > 0.0 else 'decay'} {found.rate:+.3f} 1/s at "
                f"{found.frequency:5.2f} Hz, linear {linear.growth:+.4f} 1/s at {linear.frequency:5.2f} Hz",
                flush=True,
            )


def show_response(fmus: Path, name: str) -> None:
    """Print the margins of one layout from its response to a test signal."""
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
        fly_changes(Path(sys.argv[1]), layout)
        if "--response" in sys.argv:
            show_response(Path(sys.argv[1]), layout)
