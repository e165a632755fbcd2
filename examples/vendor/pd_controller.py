"""A controller as another team would deliver it: PD, angles in degrees, a scalar-first quaternion, scalars x, y, z.

    pythonfmu build -f examples/vendor/pd_controller.py -d vendor

makes vendor/PdController.fmu. It knows nothing of flexsat: six wheels on the axes of the bus, an attitude quaternion
that turns body components into inertial ones, rates in deg/s, torques in N.m.
"""

import math

from pythonfmu import Fmi2Causality, Fmi2Slave, Fmi2Variability, Real
from pythonfmu.variables import Integer

INERTIA = (60000.0, 60000.0, 120000.0)  # [kg.m2], what the vendor believes of the spacecraft
DEGREE = math.pi / 180.0


class PdController(Fmi2Slave):
    """Torque of six wheels from attitude quaternion and rates."""

    author = "a vendor"
    description = "PD attitude controller"

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.q_s, self.q_x, self.q_y, self.q_z = 1.0, 0.0, 0.0, 0.0
        self.rate_x = self.rate_y = self.rate_z = 0.0
        self.torque_1 = self.torque_2 = self.torque_3 = self.torque_4 = self.torque_5 = self.torque_6 = 0.0
        self.mode = 1  # 0 off, 1 pointing
        self.frequency, self.damping = 0.05, 0.7
        for name in ("q_s", "q_x", "q_y", "q_z"):
            self._real(name, Fmi2Causality.input, "attitude quaternion")
        for name in ("rate_x", "rate_y", "rate_z"):
            self._real(name, Fmi2Causality.input, "body rate [deg/s]")
        for wheel in range(1, 7):
            self._real(f"torque_{wheel}", Fmi2Causality.output, "motor torque of a wheel [N.m]")
        self.register_variable(Integer("mode", causality=Fmi2Causality.input, variability=Fmi2Variability.discrete))
        for name in ("frequency", "damping"):
            self.register_variable(Real(name, causality=Fmi2Causality.parameter, variability=Fmi2Variability.fixed))

    def _real(self, name, causality, description):
        self.register_variable(
            Real(name, causality=causality, variability=Fmi2Variability.discrete, description=description)
        )

    def do_step(self, _current_time, _step_size):
        """Compute the torques from the inputs; each axis has two wheels, whose torques the structure feels reversed."""
        sign = -1.0 if self.q_s < 0.0 else 1.0  # of the two quaternions of an attitude the one of the short rotation
        angles = [-2.0 * sign * part for part in (self.q_x, self.q_y, self.q_z)]
        rates = [DEGREE * rate for rate in (self.rate_x, self.rate_y, self.rate_z)]
        for axis, (angle, rate, inertia) in enumerate(zip(angles, rates, INERTIA, strict=True)):
            wanted = inertia * self.frequency * (self.frequency * angle + 2.0 * self.damping * rate)
            for wheel, along in ((axis + 1, 1.0), (axis + 4, -1.0)):
                setattr(self, f"torque_{wheel}", along * 0.5 * wanted if self.mode == 1 else 0.0)
        return True
