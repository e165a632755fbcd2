"""Output the inputs: a sampled component."""

from pythonfmu import Boolean, Fmi2Causality, Fmi2Slave, Fmi2Variability, Integer, Real
from pythonfmu.enums import Fmi2Status


class ToyEcho(Fmi2Slave):
    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.u = [0.0, 0.0]
        self.y = [0.0, 0.0]
        self.flag = self.flag_out = False
        self.number = self.number_out = 0
        self.refuse_at = -1.0
        inp, out, disc = Fmi2Causality.input, Fmi2Causality.output, Fmi2Variability.discrete
        for i in range(2):
            self.register_variable(
                Real(f"u[{i + 1}]", causality=inp, getter=lambda i=i: self.u[i], setter=lambda v, i=i: self._set(i, v))
            )
        for i in range(2):
            self.register_variable(Real(f"y[{i + 1}]", causality=out, getter=lambda i=i: self.y[i]))
        self.register_variable(Boolean("flag", causality=inp, variability=disc))
        self.register_variable(Boolean("flag_out", causality=out, variability=disc))
        self.register_variable(Integer("number", causality=inp, variability=disc))
        self.register_variable(Integer("number_out", causality=out, variability=disc))
        self.register_variable(Real("refuse_at", causality=Fmi2Causality.parameter, variability=Fmi2Variability.fixed))

    def _set(self, index, value):
        self.u[index] = value

    def do_step(self, current_time, _step_size):
        self.y = list(self.u)
        self.flag_out, self.number_out = self.flag, self.number
        if 0 <= self.refuse_at <= current_time:
            self.log("the echo refuses", Fmi2Status.error)
            return False
        return True
