"""Ports and parameters of the mission manager."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from ..parameters import ARCSECOND, Wheel
from ..quantities import FULL_TURN
from ..runtime.missions import allocation, thrusters
from ..runtime.missions.failure_detection import PreparedDetection
from ..runtime.missions.manager import PreparedManager
from ..runtime.missions.mission_data import MissionData
from ..runtime.missions.mode_logic import ACTIONS, MODES, START_LIMIT, PreparedModes
from ..runtime.missions.off_loading import LEAST_LEFT, PreparedOffLoading
from ..runtime.missions.thrusters import ThrusterParameters
from .declared import parameter_port
from .table import Port
from .thrusters import COUNT, thruster_parameters

COMMANDS = 48  # of a timeline
LATEST = 1e9  # s
MODE_TEXT = ", ".join(f"{k} {mode}" for k, mode in enumerate(MODES))


def ports(model: MissionData) -> tuple[Port, ...]:
    """Return the ports of a manager for the wheels of a spacecraft."""
    n = len(model.nominal_speed)
    seen = ("demanded.wheel.torque", "encoder.speed", "estimate.mrp", "reference.mrp", "reference.rate",
            "reference.torque", "star_tracker.valid")  # fmt: skip
    measured = tuple(name for name in seen if name != "demanded.wheel.torque")
    return (
        Port(name="demanded.wheel.torque", causality="input", unit="N.m", size=n, variability="discrete",
             description="motor torque that the controller demands of each wheel, about its axis"),
        Port(name="encoder.speed", causality="input", unit="rad/s", size=n, display_unit="rpm",
             description="measured wheel speed", start=tuple(model.nominal_speed.tolist())),
        Port(name="estimate.mrp", causality="input", unit="1", size=3, variability="discrete",
             description="estimated attitude, body from inertial"),
        Port(name="reference.mrp", causality="input", unit="1", size=3, variability="discrete",
             description="reference attitude, body from inertial"),
        Port(name="reference.rate", causality="input", unit="rad/s", size=3, frame="body", variability="discrete",
             display_unit="deg/s", description="reference rate: not zero in a slew"),
        Port(name="reference.torque", causality="input", unit="N.m", size=n, variability="discrete",
             description="feed-forward torque of the controller: not zero in a slew"),
        Port(name="star_tracker.valid", causality="input", kind="boolean",
             description="true if the star tracker gives a new sample"),
        Port(name="wheel.torque", causality="output", unit="N.m", size=n, variability="discrete", depends_on=seen,
             description="commanded motor torque, about the wheel's axis"),
        Port(name="applied.wheel.torque", causality="output", unit="N.m", size=n, variability="discrete",
             depends_on=seen, description="torques of wheels that all work, which give the body what the real"
             " ones give, less the answer to the thrusters: for the controller's model"),
        Port(name="shown.encoder.speed", causality="output", unit="rad/s", size=n, variability="discrete",
             depends_on=seen, display_unit="rpm", description="encoders of wheels with the torques"
             " applied.wheel.torque, as they will be in the next step: for the controller, a step later"),
        Port(name="command.rotation", causality="output", unit="rad", size=3, variability="discrete",
             depends_on=measured, display_unit="deg", description="rotation vector of the last slew commanded"),
        Port(name="command.start_time", causality="output", unit="s", variability="discrete", depends_on=measured,
             description="when that slew begins"),
        Port(name="thrust.command", causality="output", unit="N", size=COUNT, variability="discrete",
             depends_on=measured, display_unit="mN",
             description="thrust of each thruster, wanted on average over a period"),
        Port(name="momentum", causality="output", unit="N.m.s", size=3, frame="body", variability="discrete",
             depends_on=("encoder.speed",),
             description="momentum of the wheels that work, less that of their nominal speeds: to be off-loaded"),
        Port(name="pointing.error", causality="output", unit="rad", variability="discrete",
             depends_on=("estimate.mrp", "reference.mrp"), display_unit="arcsec",
             description="angle between estimated and reference attitude"),
        Port(name="wheel.residual", causality="output", unit="rad/s", size=n, variability="discrete",
             depends_on=("encoder.speed",), display_unit="rpm",
             description="measured wheel speed less the one expected from the commanded torque"),
        Port(name="mode", causality="output", kind="integer", depends_on=measured, description=f"mode: {MODE_TEXT}"),
        Port(name="timeline.done", causality="output", kind="integer", depends_on=measured,
             description="commands of the timeline that have been begun"),
        Port(name="wheel.status", causality="output", kind="integer", size=n, depends_on=("encoder.speed",),
             description="0 works, 1 off: does not follow its torque, 2 seized: does not turn either"),
        Port(name="applied.valid", causality="output", kind="boolean",
             description="true: applied.wheel.torque is given"),
        Port(name="star_tracker.outage", causality="output", kind="boolean", depends_on=("star_tracker.valid",),
             description="true if the star tracker has given nothing for star_tracker.outage_time"),
        Port(name="timeline.time", causality="parameter", unit="s", size=COMMANDS, minimum=0.0, maximum=LATEST,
             description="time of each command, rising"),
        Port(name="timeline.action", causality="parameter", kind="integer", size=COMMANDS, minimum=0,
             maximum=len(ACTIONS) - 1,
             description="what is commanded: " + ", ".join(f"{k} {action}" for k, action in enumerate(ACTIONS))
             + "; the first 0 ends the timeline"),
        Port(name="timeline.rotation", causality="parameter", unit="rad", size=3 * COMMANDS, minimum=-FULL_TURN,
             maximum=FULL_TURN, display_unit="deg", description="rotation vector of each slew, one after another"),
        Port(name="slew.lead", causality="parameter", unit="s", start=5.0, minimum=0.0, maximum=1e6,
             description="time from the command of a slew to its start time"),
        Port(name="settle.band", causality="parameter", unit="rad", start=2.0 * ARCSECOND, minimum=0.0, maximum=0.1,
             display_unit="arcsec",
             description="estimated pointing error below which a slew has settled; three times it ends the mode fine"),
        Port(name="settle.dwell", causality="parameter", unit="s", start=5.0, minimum=0.0, maximum=1e6,
             description="time within the band until the mode is fine"),
        Port(name="star_tracker.outage_time", causality="parameter", unit="s", start=1.0, minimum=0.0, maximum=1e6,
             description="time without a sample of the star tracker from which on the mode is acquisition"),
        Port(name="safe.outage_time", causality="parameter", unit="s", start=600.0, minimum=0.0, maximum=1e6,
             description="further time without one that ends in the mode safe"),
        Port(name="off_loading.duration", causality="parameter", unit="s", start=100.0, minimum=0.1, maximum=1e6,
             description="time in which the wheels are brought back"),
        Port(name="off_loading.tolerance", causality="parameter", unit="N.m.s", start=0.02, minimum=0.0, maximum=1e6,
             description="momentum about each axis below which an off-loading ends; twice the duration ends it too"),
        Port(name="off_loading.automatic", causality="parameter", unit="1", start=0.0, minimum=0.0, maximum=1e3,
             description="share of wheel.speed_band that begins an off-loading without a command; 0: none"),
        Port(name="off_loading.feed_forward", causality="parameter", unit="1", start=1.0, minimum=0.0, maximum=1.0,
             description="share of the thrusters' torque that the wheels answer at once"),
        Port(name="off_loading.memory", causality="parameter", unit="s", start=2000.0, minimum=1.0, maximum=1e9,
             description="time constant with which shown.encoder.speed returns to the encoders"),
        Port(name="failure.enabled", causality="parameter", kind="boolean", start=True,
             description="whether failed wheels are detected, and their torque given to the others"),
        Port(name="failure.threshold", causality="parameter", unit="rad/s", start=3e-3, minimum=0.0, maximum=1e3,
             display_unit="rpm", description="residual of a wheel that has failed: ten deviations of an encoder"),
        Port(name="failure.persistence", causality="parameter", unit="s", start=0.025, minimum=0.0, maximum=1e6,
             description="time beyond the threshold until it has"),
        Port(name="failure.time_constant", causality="parameter", unit="s", start=1.0, minimum=1e-3, maximum=1e6,
             description="of the observer of the wheel speed: a lost torque times it over the inertia is the residual"),
        Port(name="failure.seized_speed", causality="parameter", unit="rad/s", start=1.0, minimum=0.0, maximum=1e3,
             display_unit="rpm", description="speed below which a failed wheel is seized"),
        Port(name="failure.braking_time", causality="parameter", unit="s", start=0.2, minimum=0.0, maximum=1e3,
             description="time over which the torque of a failed wheel is found from its encoder"),
        Port(name="wheel.axis", causality="parameter", unit="1", size=3 * n, minimum=-1.0, maximum=1.0, frame="body",
             start=tuple(model.wheel_axis.ravel().tolist()), description="axis of each wheel, one after another"),
        parameter_port(Wheel, "inertia", name="wheel.inertia", size=n, minimum=1e-9, maximum=1e6,
                       start=tuple(model.wheel_inertia.tolist()), description="inertia of each wheel about its axis"),
        parameter_port(Wheel, "torque_limit", name="wheel.torque_limit", size=n,
                       start=tuple(model.torque_limit.tolist()), description="torque limit of each wheel"),
        Port(name="wheel.nominal_speed", causality="parameter", unit="rad/s", size=n, minimum=-1e4, maximum=1e4,
             start=tuple(model.nominal_speed.tolist()), display_unit="rpm",
             description="speed that off-loading brings each wheel back to"),
        parameter_port(Wheel, "speed_band", name="wheel.speed_band", start=model.speed_band, minimum=1e-6,
                       display_unit="rpm", description="allowed wheel speed either side of nominal"),
        *thruster_parameters(),
    )  # fmt: skip


def parameters(value: Callable[[str], Any], step: float) -> PreparedManager:
    """Return a manager prepared for a step [s]; `value` gives the value of a port.

    Raises
    ------
    ValueError
        For times that do not rise, a slew that turns nowhere, or thrusters that give no pure torque.
    """
    known = thrusters.prepare(
        ThrusterParameters(
            position=_rows(value("thruster.position")),
            direction=_rows(value("thruster.direction")),
            most_thrust=value("thrust.maximum"),
            minimum_impulse=value("thrust.minimum_impulse"),
            period=value("thrust.period"),
            lag=value("thrust.lag"),
            noise=0.0,
            seed=0,
            step=step,
        )
    )
    shares = allocation.thruster_shares(_rows(value("thruster.position")), _rows(value("thruster.direction")))
    size = np.abs(shares)
    axis = _rows(value("wheel.axis"))
    inverse = allocation.inverse_of_axes(axis, np.ones(len(axis), np.bool_))
    if inverse is None:
        raise ValueError("wheel.axis must be axes that lie in no plane, for a torque about any axis")
    return PreparedManager(
        axis=axis,
        inverse=inverse,
        wheel_inertia=np.array(value("wheel.inertia")),
        torque_limit=np.array(value("wheel.torque_limit")),
        nominal_speed=np.array(value("wheel.nominal_speed")),
        speed_band=value("wheel.speed_band"),
        modes=_modes(value, step),
        detection=PreparedDetection(
            enabled=value("failure.enabled"),
            wheel_inertia=np.array(value("wheel.inertia")),
            step=step,
            follow=step / (value("failure.time_constant") + step),
            threshold=value("failure.threshold"),
            persistence=max(1, _steps(value("failure.persistence"), step)),
            seized_speed=value("failure.seized_speed"),
            braking_time=max(step, value("failure.braking_time")),
        ),
        off_loading=PreparedOffLoading(
            shares=shares,
            most_share=size.max(axis=0),
            least_share=np.where(size > 0.0, size, np.inf).min(axis=0),
            most_thrust=value("thrust.maximum"),
            minimum_impulse=value("thrust.minimum_impulse"),
            period=value("thrust.period"),
            duration=value("off_loading.duration"),
            last=LEAST_LEFT * value("off_loading.duration"),
            tolerance=value("off_loading.tolerance"),
        ),
        thrusters=known,
        feed_forward=value("off_loading.feed_forward"),
        step=step,
        forget=1.0 - step / max(value("off_loading.memory"), step),
    )


def _modes(value: Callable[[str], Any], step: float) -> PreparedModes:
    time, action = np.array(value("timeline.time"), np.float64), np.array(value("timeline.action"), np.int64)
    rotation = _rows(value("timeline.rotation"))
    last = 0.0
    for k, (moment, what) in enumerate(zip(time.tolist(), action.tolist(), strict=True)):
        if what == 0:
            break
        if moment < last:
            raise ValueError(f"timeline.time[{k + 1}] must be >= the one before, {last!r} s, got {moment!r}")
        if ACTIONS[what] == "slew" and not np.any(rotation[k]):
            raise ValueError(f"timeline.rotation[{3 * k + 1}] to [{3 * k + 3}] must turn somewhere, got a slew by 0")
        last = moment
    return PreparedModes(
        time=time,
        action=action,
        rotation=rotation,
        lead=value("slew.lead"),
        band=value("settle.band"),
        dwell=_steps(value("settle.dwell"), step),
        outage=_steps(value("star_tracker.outage_time"), step),
        safe_outage=_steps(value("safe.outage_time"), step),
        start_limit=_steps(value("slew.lead") + START_LIMIT, step),
        automatic=value("off_loading.automatic"),
    )


def _steps(time: float, step: float) -> int:
    return int(np.floor(time / step + 0.5))


def _rows(values: Any) -> Any:
    return np.reshape(np.array(values, np.float64), (-1, 3))
