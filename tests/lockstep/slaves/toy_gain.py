"""Multiply the input by a gain that may change in a run; keep the last output while the input is no number."""

from pythonfmu import Boolean, Fmi2Causality, Fmi2Slave, Fmi2Variability, Integer, Real


class ToyGain(Fmi2Slave):
    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.u, self.y, self.bad, self.gain, self.shift, self.on = 0.0, 0.0, 0, 1.0, 0, True
        inp, out, par = Fmi2Causality.input, Fmi2Causality.output, Fmi2Causality.parameter
        self.register_variable(Real("u", causality=inp))
        self.register_variable(Real("y", causality=out))
        self.register_variable(Integer("bad", causality=out, variability=Fmi2Variability.discrete))
        self.register_variable(Real("gain", causality=par, variability=Fmi2Variability.tunable))
        self.register_variable(Integer("shift", causality=par, variability=Fmi2Variability.tunable))
        self.register_variable(Boolean("on", causality=par, variability=Fmi2Variability.tunable))

    def do_step(self, _current_time, _step_size):
        if self.u != self.u or self.gain != self.gain:
            self.bad += 1
        else:
            self.y = (self.gain * self.u + self.shift) * self.on
        return True
