"""Integrate the input, held over the step: a continuous component."""

from pythonfmu import Fmi2Causality, Fmi2Slave, Fmi2Variability, Real


class ToyIntegrator(Fmi2Slave):
    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.u, self.x, self.clock, self.x0 = 0.0, 0.0, 0.0, 0.0
        self.register_variable(Real("u", causality=Fmi2Causality.input))
        self.register_variable(Real("x", causality=Fmi2Causality.output))
        self.register_variable(Real("clock", causality=Fmi2Causality.output))
        self.register_variable(Real("x0", causality=Fmi2Causality.parameter, variability=Fmi2Variability.fixed))

    def exit_initialization_mode(self):
        self.x = self.x0

    def do_step(self, current_time, step_size):
        self.x += self.u * step_size
        self.clock = current_time + step_size
        return True
