"""Compare the rigid limit with spinning wheels to Basilisk: `make peers`.

The plant's matrices without the coupling of the modes, all wheels spinning near their nominal speeds and driven by
constant torques, an initial rate about every axis: what remains is Euler's equation with wheel momentum, and for
JitterSimple the force and torque of imbalances, MAGNIFIED times so large that they are seen. Basilisk takes RK4 steps.
The layouts of the paper, and a pyramid of four wheels, of three kinds, on two places.
"""

import json
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

from flexsat.description.built_in import CONFIGURATIONS
from flexsat.description.spacecraft_file import parse_spacecraft
from flexsat.design.chain import Design, build_design, build_designs
from flexsat.runtime import plant as stepper
from flexsat.runtime import rotations
from flexsat.runtime.plant_parameters import PlantMatrices, lowest_modes, parameters_of_run

STOP, STEP, FINER = 60.0, 1e-3, 2.5e-4  # s
RATE = (2e-4, -3e-4, 1e-4)  # rad/s
TORQUE = 0.02  # N.m, of either sign
UNEQUAL = 5.0  # rad/s, by which wheels differ from their nominal speeds: together they have momentum
MAGNIFIED = 100.0
ACCEPTED = 1e-8  # rad, rad/s, m/s, and relative for wheel speeds
PYRAMID = """
name = "pyramid"
wheels = [
  { at = "bus", axes = [[1, 0, 1], [-1, 0, 1]] },
  { at = "tower", kind = "small", axes = [[0, -1, -1]] },
  { at = "tower", kind = "least", axes = [[0, 1, -1]] },
]
gyros = [{ at = "bus", axes = ["+x", "+y", "+z"] }]
accelerometers = [{ at = "bus", axes = ["+z"] }]
[sites]
tower = { on_bus = [0.3, -0.2, 1.5] }
[bus]
mass = 800
inertia = [500, 450, 600]
[modes]
plant = 8
design = 7
[wheel]
inertia = 4.62
[wheel_kinds.small]
inertia = 2.0
imbalance_force = 2e-5
[wheel_kinds.least]
inertia = 0.7
imbalance_torque = 1e-5
"""
HEADER = ("case", "step [ms]", "attitude [rad]", "rate [rad/s]", "velocity [m/s]", "wheel speed [1]")


def rigid(matrices: PlantMatrices) -> PlantMatrices:
    """Return a plant whose one mode nothing moves and that moves nothing."""
    one = lowest_modes(matrices, 1)
    changes = {name: getattr(one, name).copy() for name in
               ("mass_matrix", "torque_influence", "wrench_influence", "lateral_influence")}  # fmt: skip
    for array in changes.values():
        array[6:] = 0.0
    mass = changes["mass_matrix"]
    mass[:6, 6:], mass[6, 6] = 0.0, 1.0
    return replace(one, **changes, wheel_slope=np.zeros_like(one.wheel_slope))


def case_of(design: Design, jitter: bool, step: float) -> dict[str, object]:
    """Return what both tools are to simulate, as JSON can hold it."""
    craft = design.structure
    count = craft.wheel_count
    offsets = UNEQUAL * np.sin(np.arange(count))
    signs = np.where(np.arange(count) % 3 == 0, 1.0, -1.0)
    return {
        "mass": craft.mass,
        "inertia": craft.inertia.tolist(),
        "axes": craft.wheels.axis.tolist(),
        "positions": craft.wheels.position.tolist(),
        "laterals": craft.lateral_a.tolist(),
        "wheel_inertia": craft.wheel_set.inertia.tolist(),
        "speeds": (design.response.nominal + offsets).tolist(),
        "torques": (TORQUE * signs).tolist(),
        "rate": list(RATE),
        "force": (MAGNIFIED * float(jitter) * craft.wheel_set.imbalance_force).tolist(),
        "torque_of_imbalance": (MAGNIFIED * float(jitter) * craft.wheel_set.imbalance_torque).tolist(),
        "step": step,
        "stop": STOP,
    }


def simulate(design: Design, case: dict[str, object], step: float) -> dict[str, object]:
    """Return the state at the end, and the time that a step of the plant took."""
    matrices = rigid(design.plant)
    n, none = matrices.wheels, np.zeros(1)
    offset = np.array(case["speeds"]) - matrices.nominal_speed
    parameters = parameters_of_run(
        matrices, seed=0, random_wheel_phases=False, attitude_deviation=0.0, mrp=np.zeros(3), rate=np.array(RATE),
        velocity=np.zeros(3), modal_displacement=none, modal_velocity=none, wheel_speed_offset=offset,
        wheel_angle=np.zeros(n), torque_limit=1e3, frequency_dispersion=none, damping_dispersion=none,
        inertia_dispersion=np.zeros(3),
    )  # fmt: skip
    prepared = stepper.prepare(matrices, parameters, step)
    state = stepper.init(prepared)
    inputs = np.zeros(prepared.input_count)
    inputs[:n] = case["torques"]
    wrench = inputs[n : n + 6 * prepared.motion.matrices.mounts].reshape(6, -1)
    axis, first = np.array(case["axes"]), np.array(case["laterals"])
    second, mount = np.cross(axis, first), matrices.mount_of_wheel
    place = np.eye(matrices.mounts)[:, mount]
    outputs, lasted = state.outputs, 0.0
    force, torque = np.array(case["force"]), np.array(case["torque_of_imbalance"])
    for _ in range(round(STOP / step)):
        if force.any() or torque.any():
            speed = outputs.wheel_speed
            middle = outputs.wheel_angle + 0.5 * step * speed  # held from there it costs the square of the step
            along = (np.cos(middle) * first.T + np.sin(middle) * second.T) * speed**2
            wrench[:3], wrench[3:] = (force * along) @ place.T, (torque * along) @ place.T
        start = time.perf_counter()
        stepper.step(prepared, state, inputs)
        lasted += time.perf_counter() - start
    body_from_inertial = rotations.matrix_from_mrp(outputs.mrp.tolist())
    return {
        "mrp": outputs.mrp.tolist(),
        "rate": outputs.rate.tolist(),
        "velocity": (body_from_inertial.T @ outputs.velocity).tolist(),
        "speed": outputs.wheel_speed.tolist(),
        "microseconds": 1e6 * lasted / round(STOP / step),
    }


def differences(found: dict[str, object], peer: dict[str, object]) -> tuple[float, ...]:
    """Return the largest differences: attitude [rad], rate [rad/s], velocity [m/s], wheel speed, relative."""
    off = {name: np.abs(np.array(found[name]) - np.array(peer[name])) for name in ("mrp", "rate", "velocity", "speed")}
    relative = float((off["speed"] / np.abs(np.array(peer["speed"]))).max())
    return 4.0 * float(off["mrp"].max()), float(off["rate"].max()), float(off["velocity"].max()), relative


def basilisk(python: str, case: dict[str, object]) -> dict[str, object]:
    """Return what Basilisk finds."""
    script = Path(__file__).with_name("basilisk_wheels.py")
    done = subprocess.run([python, str(script)], input=json.dumps(case), capture_output=True, text=True, check=False)
    if done.returncode:
        sys.exit(f"{python} {script}: exit code {done.returncode}\n{done.stderr}")
    return dict(json.loads(done.stdout.splitlines()[-1]))


def main(python: str) -> int:
    """Print the table; return 1 if a difference is too large."""
    print(" | ".join(HEADER))
    worst, speeds = 0.0, []
    pyramid = parse_spacecraft(PYRAMID, "pyramid.toml").configurations["robust"]
    for name in (*CONFIGURATIONS, pyramid.name):
        design = build_design(pyramid) if name == pyramid.name else build_designs(name).corrected
        for kind in ("Balanced", "JitterSimple"):
            case = case_of(design, kind == "JitterSimple", STEP)
            peer = basilisk(python, case)
            for step in (STEP, FINER):
                found = simulate(design, case, step)
                off = differences(found, peer)
                worst = max(worst, max(off)) if step == FINER else worst
                print(
                    " | ".join((f"{name}, {kind}", f"{1e3 * step:g}", *(f"{value:.1e}" for value in off))), flush=True
                )
                if step == STEP:
                    speeds.append((name, kind, found["microseconds"], peer["microseconds"]))
    print("case | flexsat [us a step] | Basilisk [us a step]")
    for name, kind, own, other in speeds:
        print(f"{name}, {kind} | {own:.1f} | {other:.1f}")
    print(f"largest difference with steps of {1e3 * FINER:g} ms: {worst:.1e}, accepted {ACCEPTED:g}")
    return 0 if worst <= ACCEPTED else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
