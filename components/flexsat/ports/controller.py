"""Ports and parameters of the flight controller."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from ..parameters import CONTROLLER_DESIGNS, DEFAULT_DESIGN, Slew, Wheel
from ..runtime.controller_parameters import (
    CAPTURE_ANGLE,
    DURING_SLEW,
    GUIDANCES,
    LONGEST_DELAY,
    ControllerMatrices,
    ControllerParameters,
)
from ..runtime.keep_out import CONES, keep_out
from ..variants import VARIANT_PORT, Variant, chosen_by
from .declared import parameter_port
from .table import Port


def ports(model: ControllerMatrices, cancels: bool = True) -> tuple[Port, ...]:
    """Return the ports of a controller of these sizes. Reference and estimate stand in the order of the state.

    Parameters
    ----------
    model : the design
    cancels : whether any of the designs that can be chosen has torques against the harmonic jitter
    """
    n, m = len(model.nominal_speed), model.modes
    g, k = model.gyros, model.accelerometers
    measured = (
        "gyro.rate", "accelerometer.acceleration", "encoder.speed", "star_tracker.mrp", "star_tracker.valid",
        "applied.wheel.torque", "applied.valid",
    )  # fmt: skip
    rigid = ("gyro.rate", "star_tracker.mrp", "star_tracker.valid", "applied.wheel.torque", "applied.valid")
    commanded = ("command.rotation", "command.start_time")
    captured = ("star_tracker.mrp", "star_tracker.valid")  # a run may begin at an attitude that is only measured
    cancelled = ("encoder.angle",) if cancels else ()  # without, only the estimate of the next step needs it
    deviation = "wheel speed less the nominal one, inertial, about its axis"
    return (
        Port(name="gyro.rate", causality="input", unit="rad/s", size=g, display_unit="deg/s",
             description="measured rate about each gyro's axis: bus x y z, then x y at each site"),
        Port(name="accelerometer.acceleration", causality="input", unit="m/s2", size=k,
             description="measured acceleration: bus x y z, then z at each site"),
        Port(name="encoder.speed", causality="input", unit="rad/s", size=n, display_unit="rpm",
             description="measured wheel speed", start=tuple(model.nominal_speed.tolist())),
        Port(name="encoder.angle", causality="input", unit="rad", size=n, description="measured wheel angle"),
        Port(name="star_tracker.mrp", causality="input", unit="1", size=3,
             description="measured attitude, body from inertial"),
        parameter_port(Slew, "rotation", name="command.rotation", causality="input", size=3, display_unit="deg",
                       variability="discrete",
                       description="rotation vector to turn by from where the slew begins, which is where the one"
                       " before ended; a change commands another slew, zero none"),
        parameter_port(Slew, "start_time", name="command.start_time", causality="input", variability="discrete",
                       start=model.slew_start, description="when the slew begins; at once if it has passed"),
        Port(name="applied.wheel.torque", causality="input", unit="N.m", size=n, variability="discrete",
             description="motor torque commanded in the step before by whoever was in control, about the wheel's axis"),
        Port(name="star_tracker.valid", causality="input", kind="boolean",
             description="true if star_tracker.mrp is a new sample"),
        Port(name="applied.valid", causality="input", kind="boolean",
             description="true if applied.wheel.torque is given; else the estimator takes its own torque for it"),
        Port(name="wheel.torque", causality="output", unit="N.m", size=n, variability="discrete",
             depends_on=(*measured, *cancelled, *commanded),
             description="commanded motor torque, about the wheel's axis"),
        Port(name="reference.mrp", causality="output", unit="1", size=3, variability="discrete",
             depends_on=captured, description="reference attitude, body from inertial"),
        Port(name="reference.modal.displacement", causality="output", unit="m.kg^0.5", size=m,
             variability="discrete", description="reference modal coordinates"),
        Port(name="reference.rate", causality="output", unit="rad/s", size=3, frame="body",
             display_unit="deg/s", variability="discrete", description="reference rate"),
        Port(name="reference.modal.velocity", causality="output", unit="m.kg^0.5/s", size=m,
             variability="discrete", description="reference modal rates"),
        Port(name="reference.wheel.speed", causality="output", unit="rad/s", size=n, display_unit="rpm",
             variability="discrete", description=f"reference {deviation}"),
        Port(name="reference.torque", causality="output", unit="N.m", size=n, variability="discrete",
             depends_on=commanded, description="feed-forward torque"),
        Port(name="estimate.mrp", causality="output", unit="1", size=3, variability="discrete",
             depends_on=measured, description="estimated attitude, body from inertial"),
        Port(name="estimate.modal.displacement", causality="output", unit="m.kg^0.5", size=m,
             variability="discrete", depends_on=measured, description="estimated modal coordinates"),
        Port(name="estimate.rate", causality="output", unit="rad/s", size=3, frame="body",
             display_unit="deg/s", variability="discrete", depends_on=measured, description="estimated rate"),
        Port(name="estimate.modal.velocity", causality="output", unit="m.kg^0.5/s", size=m,
             variability="discrete", depends_on=measured, description="estimated modal rates"),
        Port(name="estimate.wheel.speed", causality="output", unit="rad/s", size=n, display_unit="rpm",
             variability="discrete", depends_on=measured, description=f"estimated {deviation}"),
        Port(name="estimate.disturbance", causality="output", unit="N.m", size=3, frame="body",
             variability="discrete", depends_on=rigid,
             description="estimated external torque; 0 without filter.disturbance"),
        Port(name="estimate.gyro_bias", causality="output", unit="rad/s", size=g, display_unit="deg/s",
             variability="discrete", depends_on=rigid,
             description="estimated bias of each gyro; 0 without filter.gyro_bias"),
        Port(name=VARIANT_PORT, causality="parameter", kind="boolean",
             description="use the published design on the published release's order of mode rows, for any `design`;"
             " attitudes as sums of a quarter of the angle"),
        Port(name="design", causality="parameter", kind="string", start=DEFAULT_DESIGN,
             description=f"gains: {' or '.join(CONTROLLER_DESIGNS)}"),
        Port(name="open_loop", causality="parameter", kind="boolean",
             description="estimate, but command no torque"),
        Port(name="star_tracker.fine", causality="parameter", kind="boolean",
             description="gains for the fine guidance sensor instead of the coarse star tracker"),
        Port(name="filter.disturbance", causality="parameter", kind="boolean",
             description="estimate a constant external torque, and compensate it: no static pointing error"),
        Port(name="filter.gyro_bias", causality="parameter", kind="boolean",
             description="estimate the bias of each gyro, at samples of the star tracker"),
        Port(name="jitter.feed_forward", causality="parameter", kind="boolean", start=True,
             description="predict with the harmonic jitter known from encoder angle and speed"),
        parameter_port(Wheel, "imbalance_force", name="jitter.imbalance_force", start=model.imbalance_force,
                       description="lateral force over wheel speed squared, as the controller believes"),
        parameter_port(Wheel, "imbalance_torque", name="jitter.imbalance_torque", start=model.imbalance_torque,
                       description="lateral torque over wheel speed squared, as the controller believes"),
        Port(name="reference.smoothed", causality="parameter", kind="boolean",
             description="slew reference: smoothed (modes at rest) instead of time-optimal"),
        Port(name="slew.guidance", causality="parameter", kind="string", start=GUIDANCES[0],
             description="slew profile: " + ", ".join(GUIDANCES) + "; smoothed is bang-coast-bang with modes at rest"),
        Port(name="command.during_slew", causality="parameter", kind="string", start=DURING_SLEW[0],
             description="a command that would begin during a slew: refuse, or replan, which brakes and turns to it"),
        Port(name="initial.capture_angle", causality="parameter", unit="rad", start=CAPTURE_ANGLE, minimum=0.0,
             maximum=math.pi, display_unit="arcsec",
             description="a first measured attitude farther from zero than this is where the run begins; a nearer one"
             " is an error to regulate"),
        parameter_port(Slew, "authority", name="slew.authority", start=model.authority,
                       description="share of torque and speed band that the slew plan uses"),
        parameter_port(Wheel, "torque_limit", name="wheel.torque_limit", start=model.torque_limit,
                       description="torque limit of one wheel"),
        parameter_port(Wheel, "speed_band", name="wheel.speed_band", start=model.speed_band, display_unit="rpm",
                       description="allowed wheel speed either side of nominal"),
        Port(name="delay.measurement", causality="parameter", unit="s", start=0.0, minimum=0.0, maximum=LONGEST_DELAY,
             display_unit="ms", description="known delay from sampling to the step that uses it, whole milliseconds"),
        Port(name="delay.actuation", causality="parameter", unit="s", start=0.0, minimum=0.0, maximum=LONGEST_DELAY,
             display_unit="ms", description="known delay from the torque output to the wheels, whole milliseconds"),
        Port(name="wheel.torque_limit_factor", causality="parameter", unit="1", size=n, minimum=0.0,
             maximum=1e3, start=tuple(model.torque_limit_factor.tolist()),
             description="torque limit of each wheel over wheel.torque_limit; 0: it is not used"),
        Port(name="wheel.speed_band_factor", causality="parameter", unit="1", size=n, minimum=0.0,
             maximum=1e3, start=tuple(model.speed_band_factor.tolist()),
             description="speed band of each wheel over wheel.speed_band"),
        Port(name="wheel.speed_offset", causality="parameter", unit="rad/s", size=n, start=0.0, minimum=-1e3,
             maximum=1e3, display_unit="rpm",
             description="speed of each wheel less the nominal one where slews begin: what it has left of its band"),
        Port(name="keep_out.axis", causality="parameter", unit="1", size=3, start=(0.0, 0.0, 1.0), minimum=-1.0,
             maximum=1.0, frame="body", description="axis that slews keep outside the cones, such as a boresight"),
        *(port for name in CONES for port in (
            Port(name=f"keep_out.{name}.direction", causality="parameter", unit="1", size=3, start=0.0, minimum=-1.0,
                 maximum=1.0, frame="inertial", description=f"axis of the {name} cone, such as to the Sun"),
            Port(name=f"keep_out.{name}.half_angle", causality="parameter", unit="rad", start=0.0, minimum=0.0,
                 maximum=math.pi, display_unit="deg",
                 description=f"half-angle of the {name} cone: slews lead round it; 0: none"),
        )),
        *(
            Port(name=f"jitter.{name}_factor", causality="parameter", unit="1", size=n, minimum=0.0, maximum=1e3,
                 start=tuple(getattr(model, f"{name}_factor").tolist()),
                 description=f"jitter.{name} of each wheel over that number, as the controller believes")
            for name in ("imbalance_force", "imbalance_torque")
        ),
        Port(name="slew.least_peak", causality="parameter", kind="boolean",
             description="divide the torque of slews between wheels so that the largest share of a limit is the least,"
             " instead of the sum of the squares of the shares"),
        Port(name="slew.gyroscopic", causality="parameter", kind="boolean", start=model.slew_gyroscopic,
             description="count the gyroscopic torque of body and wheels in the feed-forward torque of slews"),
        Port(name="wheel.null_motion_rate", causality="parameter", unit="1/s", start=0.0, minimum=0.0, maximum=1.0,
             description="rate at which wheels move, without torque on the body, to the least largest share of their"
             " speed bands; 0: the regulator alone moves them to their nominal speeds"),
    )  # fmt: skip


def variant(value: Callable[[str], Any]) -> Variant:
    """Return which of the controller's matrices the parameters choose; `value` gives the value of a port.

    Raises
    ------
    ValueError
        For a design that there is not.
    """
    chosen = value("design")
    if chosen not in CONTROLLER_DESIGNS:
        raise ValueError(f"design must be {' or '.join(CONTROLLER_DESIGNS)}, got {chosen!r}")
    return chosen_by(value, chosen)


def parameters(model: ControllerMatrices, value: Callable[[str], Any]) -> ControllerParameters:
    """Return the parameters of a run; `value` gives the value of a port."""
    return ControllerParameters(
        period=model.period,
        fine_sensor=value("star_tracker.fine"),
        feed_forward_jitter=value("jitter.feed_forward"),
        smoothed=value("reference.smoothed"),
        open_loop=value("open_loop"),
        torque_limit=value("wheel.torque_limit"),
        speed_band=value("wheel.speed_band"),
        authority=value("slew.authority"),
        measurement_delay=value("delay.measurement"),
        actuation_delay=value("delay.actuation"),
        imbalance_force=value("jitter.imbalance_force") * np.array(value("jitter.imbalance_force_factor")),
        imbalance_torque=value("jitter.imbalance_torque") * np.array(value("jitter.imbalance_torque_factor")),
        guidance=value("slew.guidance"),
        during_slew=value("command.during_slew"),
        capture_angle=value("initial.capture_angle"),
        linear_attitude=variant(value).linear_attitude,
        torque_factor=np.array(value("wheel.torque_limit_factor")),
        band_factor=np.array(value("wheel.speed_band_factor")),
        speed_offset=np.array(value("wheel.speed_offset")),
        least_peak=value("slew.least_peak"),
        gyroscopic=value("slew.gyroscopic"),
        estimates_torque=value("filter.disturbance"),
        estimates_bias=value("filter.gyro_bias"),
        null_rate=value("wheel.null_motion_rate"),
        keep_out=keep_out(
            np.array(value("keep_out.axis")),
            np.array([value(f"keep_out.{name}.direction") for name in CONES]),
            np.array([value(f"keep_out.{name}.half_angle") for name in CONES], np.float64),
        ),
    )
