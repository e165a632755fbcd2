"""Step an FMU of the study with inputs that depend on the step's number alone, in the fresh process of a test."""

import random
import sys
from pathlib import Path

from session import FMICallException, Session

STEP = {"plant": 1e-3, "sensors": 1e-3, "controller": 5e-3}[Path(sys.argv[1]).stem]  # of the script's first argument


class Driven(Session):
    """A session that sets every input and returns every output bitwise."""

    def __init__(self, path, name="one"):
        super().__init__(path, name)
        self.of = {}
        for v in self.description.modelVariables:
            self.of.setdefault((v.causality, v.type), []).append(v)

    def feed(self, k):
        """Set all inputs but commands: their start values with noise that is seeded by the number of the step."""
        draw = random.Random(k)
        reals = [v for v in self.of["input", "Real"] if not v.name.startswith("command.")]
        self.fmu.setReal([v.valueReference for v in reals], [float(v.start) + draw.gauss(0.0, 1e-4) for v in reals])
        for v in self.of.get(("input", "Boolean"), []):
            self.fmu.setBoolean([v.valueReference], [k % 20 == 0])

    def outputs(self):
        """Return all outputs, reals in hexadecimal."""
        values = self.fmu.getReal([v.valueReference for v in self.of["output", "Real"]])
        flags = self.of.get(("output", "Boolean"), [])
        return [x.hex() for x in values] + [bool(x) for v in flags for x in self.fmu.getBoolean([v.valueReference])]

    def drive(self, first, last, step=STEP):
        """Step from one number to another, and return the outputs of each step."""
        trace = []
        for k in range(first, last):
            self.feed(k)
            self.fmu.doStep(k * step, step)
            trace.append(self.outputs())
        assert not self.messages, self.messages
        return trace


def refused(one, time, step):
    """Return the message with which a step is refused."""
    accepted, status = True, None
    try:
        one.fmu.doStep(time, step)
    except FMICallException as error:
        accepted, status = False, error.status
    assert not accepted, "the step was accepted"
    assert status == 3, status  # fmi2Error
    return one.messages[-1][2]
