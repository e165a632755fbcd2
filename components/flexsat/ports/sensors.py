"""Ports and parameters of the sensors and the wheel jitter."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from ..parameters import Rates, SensorNoise, Wheel
from ..quantities import quantity
from ..runtime.periods import whole_multiple
from ..runtime.sensor_parameters import SensorMatrices, SensorParameters
from ..runtime.wheel_jitter import Harmonics
from ..sensor_errors import prepare_errors
from ..variants import VARIANT_PORT, chosen_by
from . import sensor_errors
from .declared import parameter_port
from .table import Port

# Ports that the sensors read of the plant, and those that the controller reads of the sensors; arrays by name.
TRUTH = ("attitude.quaternion", "wheel.speed", "gyro_site.rate", "accelerometer_site.acceleration", "wheel.angle")
JITTER_NUMBERS = ("imbalance_force", "imbalance_torque", "broadband_force", "broadband_torque")
MEASUREMENTS = (
    "gyro.rate",
    "accelerometer.acceleration",
    "encoder.speed",
    "encoder.angle",
    "star_tracker.mrp",
    "star_tracker.valid",
)


def ports(model: SensorMatrices) -> tuple[Port, ...]:
    """Return the ports of sensors of these sizes."""
    n, g, k = len(model.nominal_speed), model.gyros, model.accelerometers
    mounts = len(model.wrench_of_jitter) // 6
    jitter = "imbalance harmonic and broadband noise of the wheels on each mount, held over the step"
    return (
        Port(name="attitude.quaternion", causality="input", unit="1", size=4, start=(0.0, 0.0, 0.0, 1.0),
             description="true attitude, scalar-last quaternion, body from inertial"),
        Port(name="wheel.speed", causality="input", unit="rad/s", size=n, display_unit="rpm",
             start=tuple(model.nominal_speed.tolist()), description="true wheel speed relative to its mount"),
        Port(name="gyro_site.rate", causality="input", unit="rad/s", size=g, display_unit="deg/s",
             description="true rate about each gyro's axis"),
        Port(name="accelerometer_site.acceleration", causality="input", unit="m/s2", size=k,
             description="true acceleration along each accelerometer's axis"),
        Port(name="wheel.angle", causality="input", unit="rad", size=n,
             description="true wheel angle relative to its mount"),
        *(
            Port(name=f"jitter.force_{axis}", causality="output", unit="N", size=mounts, frame="body",
                 depends_on=("wheel.speed", "wheel.angle"), description=f"{jitter}, force along {axis}")
            for axis in "xyz"
        ),
        *(
            Port(name=f"jitter.torque_{axis}", causality="output", unit="N.m", size=mounts, frame="body",
                 depends_on=("wheel.speed", "wheel.angle"), description=f"{jitter}, torque about {axis}")
            for axis in "xyz"
        ),
        Port(name="gyro.rate", causality="output", unit="rad/s", size=g, display_unit="deg/s",
             period_parameter="fast_period",
             depends_on=("gyro_site.rate[i]",), description="measured rate about each gyro's axis"),
        Port(name="accelerometer.acceleration", causality="output", unit="m/s2", size=k,
             period_parameter="fast_period",
             depends_on=("accelerometer_site.acceleration[i]",),
             description="measured acceleration, after the anti-aliasing filter"),
        Port(name="encoder.speed", causality="output", unit="rad/s", size=n, display_unit="rpm",
             period_parameter="fast_period",
             depends_on=("wheel.speed[i]",), description="measured wheel speed"),
        Port(name="encoder.angle", causality="output", unit="rad", size=n,
             period_parameter="fast_period",
             depends_on=("wheel.angle[i]",), description="measured wheel angle"),
        Port(name="star_tracker.quaternion", causality="output", unit="1", size=4,
             period_parameter="star_tracker.period",
             depends_on=("attitude.quaternion",),
             description="measured attitude, scalar-last quaternion, body from inertial"),
        Port(name="star_tracker.mrp", causality="output", unit="1", size=3,
             period_parameter="star_tracker.period",
             depends_on=("attitude.quaternion",),
             description="measured attitude, modified Rodrigues parameters, body from inertial"),
        Port(name="star_tracker.valid", causality="output", kind="boolean",
             period_parameter="fast_period",
             description="true from a star tracker sample to the next sample of gyros and encoders"),
        Port(name=VARIANT_PORT, causality="parameter", kind="boolean",
             description="nominal wheel speeds and accelerometer noise of the published release"),
        Port(name="seed", causality="parameter", kind="integer", variability="tunable", start=0, minimum=0,
             description="seed of all noise; set during a run, it begins all noise anew"),
        parameter_port(Rates, "sensors", name="step_size", start=0.0, minimum=0.0, display_unit="ms",
                       description="the only communication step accepted; 0: that of the first step"),
        parameter_port(Rates, "controller", name="fast_period", start=model.fast_period, display_unit="ms",
                       description="period of gyros, accelerometers and encoders; a whole multiple of the step"),
        parameter_port(Rates, "star_tracker", name="star_tracker.period", start=model.star_tracker_period,
                       display_unit="ms", description="period of the star tracker; a whole multiple of fast_period"),
        Port(name="star_tracker.fine", causality="parameter", kind="boolean",
             description="true for the fine guidance sensor, false for the coarse star tracker"),
        parameter_port(SensorNoise, "star_tracker_coarse", name="star_tracker.noise_coarse", display_unit="arcsec",
                       start=model.star_tracker_coarse,
                       description="coarse star tracker: standard deviation of a sample, each axis"),
        parameter_port(SensorNoise, "star_tracker_fine", name="star_tracker.noise_fine", display_unit="arcsec",
                       start=model.star_tracker_fine,
                       description="fine guidance sensor: standard deviation of a sample, each axis"),
        parameter_port(SensorNoise, "gyro", name="gyro.noise", start=model.gyro_noise, display_unit="deg/s",
                       description="standard deviation of a gyro sample, times the factor of each gyro"),
        Port(name="gyro.noise_factor", causality="parameter", unit="1", size=g, minimum=0.0, maximum=1e3,
             start=tuple(model.gyro_noise_factor.tolist()), description="noise of each gyro over gyro.noise"),
        parameter_port(SensorNoise, "accelerometer", name="accelerometer.noise", start=model.accelerometer_noise,
                       description="standard deviation of an accelerometer sample"),
        parameter_port(SensorNoise, "filter_frequency", name="accelerometer.filter_frequency",
                       start=model.filter_frequency,
                       description="corner of the second-order Butterworth anti-aliasing filter"),
        parameter_port(SensorNoise, "encoder", name="encoder.noise", start=model.encoder_noise,
                       description="standard deviation of an encoder sample"),
        Port(name="jitter.enabled", causality="parameter", kind="boolean", start=True,
             description="false for wheels without imbalance"),
        parameter_port(Wheel, "imbalance_force", name="jitter.imbalance_force", start=model.imbalance_force,
                       description="lateral force over wheel speed squared"),
        parameter_port(Wheel, "imbalance_torque", name="jitter.imbalance_torque", start=model.imbalance_torque,
                       description="lateral torque over wheel speed squared"),
        parameter_port(Wheel, "broadband_force", name="jitter.broadband_force", start=model.broadband_force,
                       description="standard deviation of the broadband force, held over fast_period"),
        parameter_port(Wheel, "broadband_torque", name="jitter.broadband_torque", start=model.broadband_torque,
                       description="standard deviation of the broadband torque, held over fast_period"),
        *(
            Port(name=f"jitter.{name}_factor", causality="parameter", unit="1", size=n, minimum=0.0, maximum=1e3,
                 start=tuple(getattr(model, f"{name}_factor").tolist()),
                 description=f"jitter.{name} of each wheel over that number")
            for name in JITTER_NUMBERS
        ),
        # spacecraft whose wheels have no further harmonics have no number that would do nothing
        *[Port(name="jitter.harmonics_factor", causality="parameter", unit="1", size=n, minimum=0.0, maximum=1e3,
               start=1.0, description="multiplies the harmonics of each wheel beside the first")][: len(
               model.harmonic_order)],
        *sensor_errors.ports(model),
    )  # fmt: skip


def parameters(model: SensorMatrices, value: Callable[[str], Any], step: float | None = None) -> SensorParameters:
    """Return the parameters of a run.

    Parameters
    ----------
    value : gives the value of a port
    step : that the component is stepped with [s]; None: the parameter step_size. Where neither gives it, it is
        not known before the first step, and what depends on it is as if the fastest instruments were sampled each step

    Raises
    ------
    ValueError
        If the periods do not fit each other, or the step.
    """
    least, given = quantity(Rates, "sensors").range.least, value("step_size")
    if least is not None and 0.0 < given < least:
        raise ValueError(f"step_size must be 0 for that of the first step, or >= {least:g} s, got {given!r}")
    step = step or given
    known = "the step of" if step else "fast_period ="
    step = step or value("fast_period")
    numbers = [value(f"jitter.{name}") * np.array(value(f"jitter.{name}_factor")) for name in JITTER_NUMBERS]
    grade = "fine" if value("star_tracker.fine") else "coarse"
    return SensorParameters(
        seed=value("seed"),
        gyro_noise=value("gyro.noise"),
        gyro_noise_factor=np.array(value("gyro.noise_factor")),
        accelerometer_noise=value("accelerometer.noise"),
        accelerometer_noise_is_gyros=chosen_by(value).accelerometer_noise_is_gyros,
        encoder_noise=value("encoder.noise"),
        star_tracker_noise=value(f"star_tracker.noise_{grade}"),
        filter_frequency=value("accelerometer.filter_frequency"),
        step=step,
        fast_steps=whole_multiple("fast_period", value("fast_period"), step),
        star_tracker_steps=whole_multiple("star_tracker.period", value("star_tracker.period"), step, known),
        jitter=value("jitter.enabled"),
        imbalance_force=numbers[0],
        imbalance_torque=numbers[1],
        broadband_force=numbers[2],
        broadband_torque=numbers[3],
        harmonics=_harmonics(model, value),
        errors=prepare_errors(
            sensor_errors.parameters(value),
            model.gyro_axis,
            model.rate_of_gyros,
            value("fast_period"),
            value("star_tracker.period"),
        ),
        wrench_of_jitter=model.wrench_of_jitter,
        wheels=len(model.nominal_speed),
        gyros=model.gyros,
        accelerometers=model.accelerometers,
        nominal_speed=model.nominal_speed,
    )


def _harmonics(model: SensorMatrices, value: Callable[[str], Any]) -> Harmonics | None:
    if not len(model.harmonic_order):
        return None
    factor = np.array(value("jitter.harmonics_factor"))
    return Harmonics(
        order=model.harmonic_order,
        force=model.harmonic_force * factor,
        torque=model.harmonic_torque * factor,
        phase=model.harmonic_phase,
    )
