"""Fly fine pointing with a controller in Python in the loop, in place of the controller FMU.

    python examples/stepped_controller.py [SYSTEM.ssd] [--seed N] [--seconds S]

`FinePointing` is an environment in the style of gymnasium, which is not needed: `reset` and `step` take and return
what those of a gymnasium.Env do. One step of it is 5 ms: five steps of plant and sensors. Build the FMUs first:
`flexsat build`.
"""

import argparse
import io
import zipfile
from pathlib import Path

import numpy as np

import lockstep

SYSTEM = Path("fmus/centralised/native/fine_pointing.ssd")
TICKS = 5  # of a millisecond, between two commands
ARCSEC = np.pi / 180.0 / 3600.0  # [rad]


class FinePointing:
    """The spacecraft with its sensors; an action is the torque of each wheel [N.m]."""

    def __init__(self, path=SYSTEM, seconds=60.0):
        self.system = lockstep.load_system(path)
        self.seconds, self.run, self.start = seconds, None, None

    def reset(self, *, seed=1):
        """Begin an episode; with the seed of the one before from a snapshot of its start."""
        if self.run is None or seed != self.seed:
            self.close()
            seeds = {"plant.seed": seed, "sensors.seed": seed}
            self.run = lockstep.open(self.system.without("controller"), stop_time=self.seconds, overrides=seeds)
            self.start, self.seed = self.run.snapshot(), seed
        self.run.restore(self.start)
        return self.observe(), {}

    def step(self, action):
        """Command the wheels for 5 ms; return observation, reward, terminated, truncated and more."""
        self.run.set("plant.wheel.torque", action)
        self.run.step(TICKS)
        error = 4.0 * np.linalg.norm(self.run["plant.attitude.mrp"]) / ARCSEC
        return self.observe(), -error, error > 60.0, self.run.time >= self.seconds, {"error_arcsec": error}

    def observe(self):
        """Return what the controller FMU would read: attitude (MRP), whether it is new, rates of the bus [rad/s]."""
        names = ("sensors.star_tracker.mrp", "sensors.star_tracker.valid", "sensors.gyro.rate")
        attitude, valid, rates = (self.run[name] for name in names)
        return {"attitude": attitude, "valid": valid, "rate": rates[:3]}

    def close(self):
        """End the run."""
        if self.run is not None:
            self.run.close()


class ProportionalDerivative:
    """Torque from attitude and rates, shared by the wheels; slower than the first mode of the structure."""

    def __init__(self, system, frequency=0.05, damping_ratio=0.7):
        with zipfile.ZipFile(system.component("controller").source) as fmu:
            model = np.load(io.BytesIO(fmu.read("resources/model.npz")))
        inertia, axes = model["corrected.inertia"], model["corrected.wheel_axis"]  # [kg.m2], one row a wheel
        self.stiffness = frequency**2 * inertia  # [N.m/rad]
        self.viscosity = 2.0 * damping_ratio * frequency * inertia  # [N.m.s/rad]
        self.wheels = -np.linalg.pinv(axes.T)  # the structure feels the reaction of a wheel's torque
        self.angle = np.zeros(3)  # [rad] about each axis

    def __call__(self, observation):
        if observation["valid"]:  # the star tracker samples every 100 ms
            self.angle = 4.0 * observation["attitude"]
        return self.wheels @ -(self.stiffness @ self.angle + self.viscosity @ observation["rate"])


def fly(path=SYSTEM, seed=1, seconds=60.0):
    """Fly one episode and return the pointing errors [arcsec], one for each step."""
    environment = FinePointing(path, seconds)
    controller = ProportionalDerivative(environment.system)
    observation, _ = environment.reset(seed=seed)
    errors, over = [], False
    while not over:
        observation, _, terminated, truncated, info = environment.step(controller(observation))
        errors.append(info["error_arcsec"])
        over = terminated or truncated
    environment.close()
    return np.array(errors)


def main():
    """Print the pointing error."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("system", nargs="?", type=Path, default=SYSTEM)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--seconds", type=float, default=60.0)
    given = parser.parse_args()
    errors = fly(given.system, given.seed, given.seconds)
    late = errors[len(errors) // 2 :]
    print(f"seed {given.seed}, {given.seconds:g} s: pointing error {np.sqrt(np.mean(late**2)):.3f} arcsec RMS in the "
          f"second half, {errors.max():.3f} arcsec at most")  # fmt: skip


if __name__ == "__main__":
    main()
