"""Count steps, and output the time at which the last one began: a sampled source."""

from pythonfmu import Boolean, Fmi2Causality, Fmi2Slave, Fmi2Variability, Integer, Real


class ToyCounter(Fmi2Slave):
    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.count, self.began, self.even, self.gain = 0.0, -1.0, True, 1.0
        self.steps, self.fail_at, self.nan_at = 0, -1, -1
        out, par = Fmi2Causality.output, Fmi2Causality.parameter
        self.register_variable(Real("count", causality=out))
        self.register_variable(Real("began", causality=out))
        self.register_variable(Integer("steps", causality=out, variability=Fmi2Variability.discrete))
        self.register_variable(Boolean("even", causality=out, variability=Fmi2Variability.discrete))
        self.register_variable(Real("gain", causality=par, variability=Fmi2Variability.fixed))
        self.register_variable(Integer("fail_at", causality=par, variability=Fmi2Variability.fixed))
        self.register_variable(Integer("nan_at", causality=par, variability=Fmi2Variability.fixed))

    def do_step(self, current_time, _step_size):
        self.steps += 1
        self.even = self.steps % 2 == 0
        self.count = float("nan") if self.steps == self.nan_at else self.gain * self.steps
        self.began = current_time
        if self.steps == self.fail_at:
            raise RuntimeError("the counter fails as configured")
        return True
