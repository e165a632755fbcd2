"""Output a multiple of the input, and the inputs that report the acting output: a sampled component."""

from pythonfmu import Boolean, Fmi2Causality, Fmi2Slave, Fmi2Variability, Real


class ToyTracker(Fmi2Slave):
    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.u, self.y, self.gain = 0.0, 0.0, 1.0
        self.applied, self.valid, self.applied_seen, self.valid_seen = 0.0, False, 0.0, False
        inp, out, disc = Fmi2Causality.input, Fmi2Causality.output, Fmi2Variability.discrete
        self.register_variable(Real("u", causality=inp))
        self.register_variable(
            Real("applied.y", causality=inp, getter=lambda: self.applied, setter=lambda v: setattr(self, "applied", v))
        )
        self.register_variable(
            Boolean("applied.valid", causality=inp, variability=disc,
                    getter=lambda: self.valid, setter=lambda v: setattr(self, "valid", v))
        )  # fmt: skip
        self.register_variable(Real("y", causality=out))
        self.register_variable(Real("applied_seen", causality=out))
        self.register_variable(Boolean("valid_seen", causality=out, variability=disc))
        self.register_variable(Real("gain", causality=Fmi2Causality.parameter, variability=Fmi2Variability.fixed))

    def do_step(self, _current_time, _step_size):
        self.y, self.applied_seen, self.valid_seen = self.gain * self.u, self.applied, self.valid
        return True
