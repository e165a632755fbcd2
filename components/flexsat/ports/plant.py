"""Ports and parameters of the plant."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from ..parameters import DEGREE, Wheel
from ..runtime.plant_parameters import PlantMatrices, PlantParameters, lowest_modes, parameters_of_run
from ..runtime.turning.angles import at_angles
from ..variants import VARIANT_PORT
from .declared import parameter_port
from .table import Port

# Beyond these the integration, explicit in the products of velocities, does not conserve energy to 1e-4 at 1 ms.
FASTEST = 0.2  # rad/s about each axis: 12 % of the energy are made in 5 s at 0.5 rad/s
LARGEST = 100.0  # of each modal coordinate, m sqrt(kg) and m sqrt(kg)/s; at 1000 the motion diverges

FULL_TURN = 2.0 * np.pi  # rad
ANGLE = "appendage.angle"  # of a plant with appendages that turn
JITTER = tuple(f"jitter.{kind}_{axis}" for kind in ("force", "torque") for axis in "xyz")


def ports(model: PlantMatrices) -> tuple[Port, ...]:
    """Return the ports of a plant of this size. The stepper's inputs and outputs stand in the same order."""
    m, n = model.modes, model.wheels
    gyros, accelerometers = len(model.gyro_axis), len(model.accelerometer_axis)
    return (
        Port(name="wheel.torque", causality="input", unit="N.m", size=n,
             description="motor torque on the wheel, about its axis; its reaction acts on the structure"),
        *(
            Port(name=f"jitter.force_{axis}", causality="input", unit="N", size=model.mounts, frame="body",
                 description=f"jitter force of the wheels on each mount, along {axis}")
            for axis in "xyz"
        ),
        *(
            Port(name=f"jitter.torque_{axis}", causality="input", unit="N.m", size=model.mounts, frame="body",
                 description=f"jitter torque of the wheels on each mount, about {axis}")
            for axis in "xyz"
        ),
        Port(name="external.force", causality="input", unit="N", size=3, frame="body",
             description="external force at the body origin"),
        Port(name="external.torque", causality="input", unit="N.m", size=3, frame="body",
             description="external torque"),
        Port(name="attitude.mrp", causality="output", unit="1", size=3,
             description="attitude, modified Rodrigues parameters, body from inertial, short rotation"),
        Port(name="attitude.quaternion", causality="output", unit="1", size=4,
             description="attitude, scalar-last quaternion, body from inertial"),
        Port(name="rate", causality="output", unit="rad/s", size=3, frame="body", display_unit="deg/s",
             description="angular rate of the body"),
        Port(name="velocity", causality="output", unit="m/s", size=3, frame="body",
             description="velocity of the body origin"),
        Port(name="wheel.speed", causality="output", unit="rad/s", size=n, display_unit="rpm",
             description="wheel speed relative to its mount, about its axis"),
        Port(name="gyro_site.rate", causality="output", unit="rad/s", size=gyros, display_unit="deg/s",
             description="true rate about each gyro's axis: bus x y z, then x y at each site"),
        Port(name="accelerometer_site.acceleration", causality="output", unit="m/s2", size=accelerometers,
             depends_on=("wheel.torque", *JITTER, "external.force", "external.torque"), follows_inputs=True,
             description="true acceleration along each accelerometer's axis: bus x y z, then z at each site"),
        Port(name="wheel.angle", causality="output", unit="rad", size=n,
             description="wheel angle relative to its mount, not wrapped"),
        # of 198 elements, each is said to start from its own value: all parameters would make 5 MB of the XML
        Port(name="modal.displacement", causality="output", unit="m.kg^0.5", size=m, on_demand=True,
             initial_depends_on=("initial.modal.displacement[i]", "modes", VARIANT_PORT),
             description="mass-normalised modal coordinates"),
        Port(name="modal.velocity", causality="output", unit="m.kg^0.5/s", size=m, on_demand=True,
             initial_depends_on=("initial.modal.velocity[i]", "modes", VARIANT_PORT),
             description="rates of the modal coordinates"),
        Port(name="rms_deformation", causality="output", unit="m", display_unit="um", on_demand=True,
             description="RMS deformation of the structure, mass-weighted"),
        Port(name="angular_momentum", causality="output", unit="N.m.s", size=3, frame="inertial", on_demand=True,
             description="total angular momentum about the body origin"),
        Port(name="energy", causality="output", unit="J", on_demand=True,
             description="kinetic and elastic energy, wheels included"),
        Port(name=VARIANT_PORT, causality="parameter", kind="boolean",
             description="use the matrices of the published release: 25 modes, with its order of mode rows"),
        Port(name="modes", causality="parameter", kind="integer", start=0, minimum=0, maximum=m,
             description="lowest modes that are simulated; 0: all. Values of the others are 0"),
        Port(name="seed", causality="parameter", kind="integer", start=0, minimum=0,
             description="seed of what is random at the start"),
        Port(name="initial.random_wheel_phases", causality="parameter", kind="boolean", start=True,
             description="draw each wheel's initial angle from the seed, on top of initial.wheel.angle"),
        Port(name="initial.attitude_deviation", causality="parameter", unit="rad", start=0.0,
             minimum=0.0,
             maximum=DEGREE, display_unit="arcsec",
             description="standard deviation per axis of an initial attitude error drawn from the seed"),
        Port(name="initial.mrp", causality="parameter", unit="1", size=3, minimum=-1.0, maximum=1.0,
             description="initial attitude, body from inertial"),
        Port(name="initial.rate", causality="parameter", unit="rad/s", size=3, frame="body",
             minimum=-FASTEST, maximum=FASTEST, display_unit="deg/s",
             description="initial angular rate"),
        Port(name="initial.velocity", causality="parameter", unit="m/s", size=3, frame="body",
             minimum=-1e4, maximum=1e4,
             description="initial velocity"),
        Port(name="initial.modal.displacement", causality="parameter", unit="m.kg^0.5", size=m,
             minimum=-LARGEST, maximum=LARGEST,
             description="initial modal coordinates"),
        Port(name="initial.modal.velocity", causality="parameter", unit="m.kg^0.5/s", size=m,
             minimum=-LARGEST, maximum=LARGEST,
             description="initial rates of the modal coordinates"),
        Port(name="initial.wheel.speed_offset", causality="parameter", unit="rad/s", size=n, display_unit="rpm",
             minimum=-1e3, maximum=1e3,
             description="initial wheel speed less the nominal one"),
        Port(name="initial.wheel.angle", causality="parameter", unit="rad", size=n,
             minimum=-1e6, maximum=1e6,
             description="initial wheel angle"),
        parameter_port(Wheel, "torque_limit", name="wheel.torque_limit", start=model.torque_limit,
                       description="largest torque of a motor, times its wheel.torque_limit_factor"),
        Port(name="dispersion.frequency", causality="parameter", unit="1", size=m,
             minimum=-1.0, maximum=1.0,
             description="relative error of each modal frequency"),
        Port(name="dispersion.damping", causality="parameter", unit="1", size=m,
             minimum=-1.0, maximum=10.0,
             description="relative error of each mode's damping"),
        Port(name="dispersion.inertia", causality="parameter", unit="1", size=3, frame="body",
             minimum=-1.0, maximum=1.0,
             description="relative error of the principal inertias"),
        Port(name="gyroscopics", causality="parameter", kind="boolean", start=True,
             description="false leaves out the gyroscopic torques of the wheels, to show what they contribute"),
        Port(name="wheel.friction_torque", causality="parameter", unit="N.m", size=n, minimum=0.0, maximum=1e6,
             variability="tunable", start=tuple(model.friction_torque.tolist()),
             description="dry friction of the bearing: brakes the wheel against its mount, then holds it; 0: none"),
        Port(name="dispersion.participation", causality="parameter", unit="1", size=m,
             minimum=-1.0, maximum=1.0,
             description="relative error of each mode's coupling to the motion of the rigid body"),
        Port(name="wheel.torque_limit_factor", causality="parameter", unit="1", size=n, minimum=0.0, maximum=1e3,
             start=tuple(model.torque_limit_factor.tolist()),
             description="torque limit of each motor over wheel.torque_limit; 0: it gives none"),
        parameter_port(Wheel, "speed_limit", name="wheel.speed_limit", size=n, display_unit="rpm",
                       start=tuple(model.speed_limit.tolist()),
                       description="wheel speed, either sense, at which the motor's torque ends; 0: none"),
        parameter_port(Wheel, "full_torque_speed", name="wheel.full_torque_speed", size=n, display_unit="rpm",
                       start=tuple(model.full_torque_speed.tolist()),
                       description="wheel speed above which the motor's limit falls, in a line, to zero at"
                       " wheel.speed_limit; 0: it does not fall"),
        parameter_port(Wheel, "torque_step", name="wheel.torque_step", size=n, start=tuple(model.torque_step.tolist()),
                       description="the motor rounds its command to whole steps of this; 0: none"),
        *(Port(name=ANGLE, causality="parameter", unit="rad", size=count, minimum=-FULL_TURN, maximum=FULL_TURN,
               display_unit="deg", variability="tunable", start=tuple(model.turn_angle.tolist()),
               description="angle of the drive of each appendage that turns, in the order of the spacecraft's file")
          for count in [len(model.turn_angle)] if count),
    )  # fmt: skip


def simulated(model: PlantMatrices, value: Callable[[str], Any]) -> PlantMatrices:
    """Return the matrices with the modes that a run simulates; `value` gives the value of a port."""
    return lowest_modes(model, value("modes"))


def at_present_angles(model: PlantMatrices, value: Callable[[str], Any]) -> PlantMatrices:
    """Return the matrices with appendages at the angles of the parameters; the same ones if none turns."""
    return at_angles(model, value(ANGLE)) if len(model.turn_angle) else model


def parameters(model: PlantMatrices, value: Callable[[str], Any]) -> PlantParameters:
    """Return the parameters of a run; `value` gives the value of a port, whose modes may be more than the model's.

    Raises
    ------
    ValueError
        For a value that the plant refuses, or the motion of a mode that is not simulated.
    """
    for name in ("initial.modal.displacement", "initial.modal.velocity"):
        rest = np.flatnonzero(value(name)[model.modes :])
        if len(rest):
            place = int(model.modes + rest[0])
            raise ValueError(
                f"{name}[{place + 1}] = {value(name)[place]:g}: {model.modes} modes are simulated; set it to 0"
            )
    return parameters_of_run(
        model,
        seed=value("seed"),
        random_wheel_phases=value("initial.random_wheel_phases"),
        attitude_deviation=value("initial.attitude_deviation"),
        mrp=value("initial.mrp"),
        rate=value("initial.rate"),
        velocity=value("initial.velocity"),
        modal_displacement=value("initial.modal.displacement")[: model.modes],
        modal_velocity=value("initial.modal.velocity")[: model.modes],
        wheel_speed_offset=value("initial.wheel.speed_offset"),
        wheel_angle=value("initial.wheel.angle"),
        torque_limit=value("wheel.torque_limit"),
        frequency_dispersion=value("dispersion.frequency")[: model.modes],
        damping_dispersion=value("dispersion.damping")[: model.modes],
        inertia_dispersion=value("dispersion.inertia"),
        gyroscopics=value("gyroscopics"),
        participation_dispersion=value("dispersion.participation")[: model.modes],
        torque_factor=value("wheel.torque_limit_factor"),
        speed_limit=value("wheel.speed_limit"),
        full_torque_speed=value("wheel.full_torque_speed"),
        torque_step=value("wheel.torque_step"),
    )
