"""Step the controller over recorded measurements again, for its innovations and estimates at every step."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flexsat.arrays import Array
from flexsat.closed_loop import port_values
from flexsat.ports import controller as interface
from flexsat.runtime import controller
from flexsat.runtime.rotations import error_rotation
from flexsat.slow_errors import TORQUES
from lockstep import InputError, Signals
from lockstep.results.read_run_record import read_run_record
from lockstep.shadow.ports import ORIGINAL, SHADOW

from ...runs.histories import controller_rows, of_known_modes, wheel_speed_deviation
from ...runs.run_folder import Run
from .slow_errors import SlowErrors, slow_errors, true_biases

MEASURED = (
    "sensors.gyro.rate",
    "sensors.accelerometer.acceleration",
    "sensors.encoder.speed",
    "sensors.encoder.angle",
    "sensors.star_tracker.mrp",
    "sensors.star_tracker.valid",
)
SAME = 1e-6  # of the largest torque: the design is computed again, and its rounding may differ from the FMU's
TRUE = ("plant.attitude.mrp", "plant.modal.displacement", "plant.rate", "plant.modal.velocity")


@dataclass(frozen=True, slots=True, kw_only=True)
class Replay:
    """One row a controller step, in SI."""

    time: Array  # (rows,) [s]
    phase: NDArray[np.intp]  # (rows,): steps since the last star tracker sample
    innovation: Array  # (rows, y)
    error: Array  # (rows, r): estimate less truth, of the states without the anti-aliasing filter
    fine: bool  # whether the fine guidance sensor was in use
    slow: SlowErrors | None = None  # where torque or biases are estimated, if wanted


def replay(run: Run, *, slow: bool = False, torque: str | None = None) -> Replay:
    """Run the controller's stepper over the recorded measurements.

    Parameters
    ----------
    slow : whether errors of estimated torque and biases are wanted
    torque : recorded signal of the external torque on the plant, by its name without element; None: it is constant

    Raises
    ------
    InputError
        If something needed was not recorded, delays are configured, or the replay does not command the torques
        that the FMU did: then its filter is another one.
    """
    signals, design = run.samples(), run.design
    missing = [name for name in (*MEASURED, *TRUE, "controller.wheel.torque") if name not in signals]
    if missing:
        raise InputError(f"{run.folder}: {missing[0]} was not recorded; `flexsat health` records what it needs")
    given = _parameters(run, "controller")
    matrices = design.controller
    values = port_values("controller", interface.ports(matrices), given)
    parameters = interface.parameters(matrices, values.__getitem__)
    if parameters.measurement_delay or parameters.actuation_delay:
        raise InputError(
            f"{run.folder}: the controller compensates delays; the estimator is only judged without: run it with none"
        )
    flown = run.flown
    rows = controller_rows(signals, flown)
    time = signals.time[rows]
    stepper = controller.prepare(matrices, parameters)
    rotation, start = values["command.rotation"], float(values["command.start_time"])
    state = controller.init(stepper, rotation, start)
    measured = [np.ascontiguousarray(signals[name][rows]) for name in MEASURED]
    innovation = np.zeros((len(time), len(matrices.c)))
    estimate = np.zeros((len(time), stepper.controlled))
    torques = np.zeros((len(time), stepper.wheels))
    estimated = np.zeros((len(time), TORQUES + stepper.gyros))
    phase = np.zeros(len(time), np.intp)
    for row, now in enumerate(time.tolist()):
        rate, acceleration, speed, angle, mrp, valid = (values[row] for values in measured)
        controller.command(stepper, state, now, rotation, start)
        measurements = controller.Measurements(rate, acceleration, speed, angle, mrp, bool(valid))
        outputs = controller.step(stepper, state, now, measurements)
        innovation[row], torques[row], estimated[row] = outputs.innovation, outputs.torque, outputs.slow_errors
        estimate[row] = outputs.estimate[: stepper.controlled]
        phase[row] = min(state.since_star_tracker, stepper.phases - 1)
    own = f"controller.{ORIGINAL}wheel.torque"  # after a switchover the torque that acted is the shadow's
    commanded = signals[own if own in signals else "controller.wheel.torque"][rows]
    if np.max(np.abs(torques - commanded)) > SAME * np.max(np.abs(commanded)):
        raise InputError(f"{run.folder}: the replay commands other torques than the FMU did; build and run it again")
    truth = [of_known_modes(signals, flown, name)[rows] for name in TRUE]
    error = estimate - np.hstack([*truth, wheel_speed_deviation(signals, flown)[rows]])
    error[:, :3] = mrp_error(estimate[:, :3], truth[0])
    choice = (parameters.estimates_torque, parameters.estimates_bias)
    sensing = _parameters(run, "sensors")
    return Replay(
        time=time,
        phase=phase,
        innovation=innovation,
        error=error,
        fine=parameters.fine_sensor,
        slow=slow_errors(
            estimated,
            _constant_torque(run, len(time)) if torque is None else signals[torque][rows],
            true_biases(design, sensing, len(time)),
            choice,
            bool(sensing.get("jitter.enabled", True)),
        )
        if slow and any(choice)
        else None,
    )


def mrp_error(estimate: Array, truth: Array) -> Array:
    """Return by what small MRPs estimates (rows, 3) differ from the truth; far from zero MRPs do not subtract."""
    return 0.25 * error_rotation(estimate, truth)


def _constant_torque(run: Run, rows: int) -> Array:
    given = _parameters(run, "plant")
    whole = given.get("external.torque", (0.0, 0.0, 0.0))
    return np.tile([float(given.get(f"external.torque[{k + 1}]", whole[k])) for k in range(3)], (rows, 1))


def recorded(signals: Signals) -> bool:
    """Return whether a run recorded what a replay needs."""
    return all(name in signals for name in MEASURED)


def _parameters(run: Run, component: str) -> dict[str, Any]:
    record, _ = read_run_record(run.folder)
    found: dict[str, Any] = next(c["parameters"] for c in record["component"] if c["name"] == component)
    return {name: value for name, value in found.items() if not name.startswith(SHADOW)}
