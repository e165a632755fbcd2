"""Fly the missions and failures whose numbers stand in docs/missions.md: the greatest pointing errors, and events.

    flexsat build --missions
    python tests/bench/mission_tables.py fmus results/missions [NAME...]

Native FMUs, each run alone, one row each 0.1 s; seed 1 where no other is named. Nothing passes or fails here.
"""

import argparse
import json
import subprocess
import sys
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from flexsat.parameters import ARCSECOND
from flexsat.runtime.rotations import error_angle
from lockstep import read_signals

RECORD = ("plant.attitude.mrp", "controller.reference.mrp", "plant.wheel.speed", "plant.rms_deformation")
MISSION = ("mission.mode", "mission.momentum", "mission.wheel.status", "mission.star_tracker.outage")  # and its events
OFF_LOAD = """
[[command]]
at = {at}
do = "off-load"
[set]
"plant.initial.wheel.speed_offset" = {offset}
"mission.off_loading.duration" = {duration}
"""
LARGE = [1.0, 0.5, 0.0, -1.0, -0.5, 0.2]  # rad/s: 9.2, 4.6 and 0.9 N.m.s
SMALL = [0.4, 0.2, 0.0, -0.4, -0.2, 0.1]
LONG = OFF_LOAD.format(at=10.0, offset=LARGE, duration=100.0)
SHORT = OFF_LOAD.format(at=20.0, offset=SMALL, duration=60.0)
KEPT = f'[set]\n"plant.initial.wheel.speed_offset" = {LARGE}\n'
SLEW = '[[command]]\nat = 6.0\ndo = "slew"\nrotation = [0.2, 0.0, 0.0]\nunit = "deg"\n'
MODES = ("plant.modes=25",)
BIASES = (*MODES, "sensors.gyro.bias_deviation=4.848e-6")
ESTIMATED = ("controller.filter.gyro_bias=true", "controller.filter.disturbance=true")


def fault(target: str, kind: str, begin: float, end: float | None = None) -> str:
    """Return a fault as text: `target` and `kind` as in its file."""
    last = "" if end is None else f"to = {end}\n"
    name = target.replace('"', "")
    return f'[[fault]]\nname = "{name} from {begin}"\n{target}\n{kind}\nfrom = {begin}\n{last}'


def seized(torque: float, begin: float) -> str:
    """Return the fault of wheel 1 that a friction stops."""
    return fault('parameter = "plant.wheel.friction_torque[1]"', f'kind = "stuck"\nvalue = {torque}', begin)


def off(wheel: int, begin: float) -> str:
    """Return the fault of a wheel without a motor."""
    return fault(f'connection = "plant.wheel.torque[{wheel}]"', 'kind = "scale"\nfactor = 0.0', begin)


def thruster(number: int, kind: str) -> str:
    """Return the fault of a thruster from 30 s on."""
    return fault(f'connection = "thrusters.thrust.command[{number}]"', kind, 30.0)


def blind(begin: float, end: float) -> str:
    """Return the outage of the star tracker."""
    ends = '["controller.star_tracker.mrp", "controller.star_tracker.valid", "mission.star_tracker.valid"]'
    return fault(f"connection = {ends}", 'kind = "dropout"', begin, end)


@dataclass(frozen=True, kw_only=True)
class Flight:
    """One run; `since` is the time [s] from which times are counted."""

    stop: float
    layout: str = "centralised"
    system: str = "missions/mission"
    mission: str = ""
    faults: str = ""
    settings: tuple[str, ...] = field(default=())
    seed: int = 1
    since: float = 0.0


FLIGHTS = {
    "kept": Flight(stop=140.0, mission=KEPT),
    "off-load": Flight(stop=140.0, mission=LONG),
    "off-load-forgotten": Flight(stop=140.0, mission=LONG, settings=("mission.off_loading.memory=1.0",)),
    "off-load-alone": Flight(stop=140.0, mission=LONG, settings=("mission.off_loading.feed_forward=0.0",)),
    "distributed-seized-bare": Flight(
        stop=80.0, layout="distributed", system="fine_pointing", faults=seized(20.0, 60.0), since=60.0
    ),
    "distributed-seized": Flight(stop=150.0, layout="distributed", faults=seized(20.0, 60.0), since=60.0),
    "seized-slowly-bare": Flight(stop=120.0, system="fine_pointing", faults=seized(3.0, 60.0), since=60.0),
    "seized-slowly": Flight(stop=140.0, faults=seized(3.0, 60.0), since=60.0),
    "seized-bare": Flight(stop=80.0, system="fine_pointing", faults=seized(20.0, 60.0), since=60.0),
    "seized": Flight(stop=200.0, faults=seized(20.0, 60.0), since=60.0),
    "off-in-a-slew": Flight(stop=140.0, mission=SLEW, faults=off(1, 20.0), since=20.0),
    "blind": Flight(stop=140.0, faults=blind(60.0, 120.0), since=60.0),
    "blind-biased": Flight(stop=125.0, faults=blind(100.0, 110.0), settings=BIASES, seed=3, since=100.0),
    "blind-estimated": Flight(
        stop=125.0, faults=blind(100.0, 110.0), settings=(*BIASES, *ESTIMATED), seed=3, since=100.0
    ),
    "off-load-seized": Flight(stop=240.0, mission=SHORT, faults=seized(3.0, 40.0), settings=MODES),
    "off-load-two-off": Flight(stop=240.0, mission=SHORT, faults=off(1, 30.0) + off(4, 60.0), settings=MODES),
    "off-load-dead": Flight(
        stop=240.0, mission=SHORT, faults=thruster(7, 'kind = "scale"\nfactor = 0.0'), settings=MODES
    ),
    "off-load-open": Flight(
        stop=240.0, mission=SHORT, faults=thruster(5, 'kind = "stuck"\nvalue = 0.1'), settings=MODES
    ),
}


def fly(name: str, flight: Flight, fmus: Path, out: Path) -> str:
    """Run a flight; return its numbers in words."""
    out.mkdir(parents=True, exist_ok=True)
    words = [str(fmus / flight.layout / f"{flight.system}.ssd"), "--native", "--stop-time", str(flight.stop)]
    words += ["--record-period", "0.1", "--seed", str(flight.seed), "--out", str(out / name), "--overwrite"]
    recorded = [
        *RECORD,
        *(
            ["mission.mode", "mission.momentum", "mission.wheel.status", "mission.star_tracker.outage"]
            if "mission" in flight.system
            else []
        ),
    ]
    words += [word for one in recorded for word in ("--record", one)]
    words += [word for one in flight.settings for word in ("--set", one)]
    for option, text in (("--mission", flight.mission), ("--faults", flight.faults)):
        if text:
            path = out / f"{name}{option}.toml"
            path.write_text(text, encoding="utf-8")
            words += [option, str(path)]
    command = [str(Path(sys.executable).parent / "flexsat"), "run", *words]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        return f"{name}: exit code {done.returncode}: {(done.stderr or done.stdout).strip()}"
    run = read_signals(out / name)
    error = error_angle(run["plant.attitude.mrp"], run["controller.reference.mrp"]) / ARCSECOND
    after = run.time >= flight.since
    time, error = run.time[after] - flight.since, error[after]
    marks = [f"{t:g} s {error[np.searchsorted(time, t)]:.3g}" for t in (14, 40, 50, 75) if t < time[-1]]
    text = [f"{name}: greatest {error.max():.3g} arcsec at {time[np.argmax(error)]:.4g} s; at {', '.join(marks)};"
            f" from 5 s on {error[time >= 5.0].max(initial=0.0):.3g}; end {error[-1]:.3g}"]  # fmt: skip
    below = np.flatnonzero(error >= 2.0)
    text.append(f"  below 2 arcsec from {time[min(below[-1] + 1, len(time) - 1)] if len(below) else 0.0:.4g} s")
    if "mission.momentum[1]" in run.columns:
        text.append(f"  momentum left {np.round(run['mission.momentum'][-1], 4).tolist()}")
    for line in (out / name / "events.jsonl").read_text(encoding="utf-8").splitlines():
        event = json.loads(line)
        if event["event"] in ("mode", "wheel-status", "star-tracker-outage"):
            text.append("  " + " ".join(f"{key}={value}" for key, value in event.items()))
    return "\n".join(text)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("fmus", type=Path)
    parser.add_argument("out", type=Path)
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"of {', '.join(FLIGHTS)}")
    asked = parser.parse_args()
    for name, flight in FLIGHTS.items():
        if not asked.names or name in asked.names:
            print(fly(name, flight, asked.fmus, asked.out), flush=True)


if __name__ == "__main__":
    main()
