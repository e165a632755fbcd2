"""Sequences of legal and illegal calls of an FMU of FMI 3.0, each compared with the standard: 3.0.2, sections 2.3, 4.2.

    python call_sequences3.py FMU [--sequences N] [--seed N]

prints how often calls were made and refused. The FMU is the native toy, or one whose steps all have the default length.
"""

from __future__ import annotations

import argparse
import collections
import faulthandler
import math
import random
import sys
import tempfile
from ctypes import byref, c_bool, c_size_t, c_void_p
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))

from fmus.raw_fmu3 import ERROR, OK, Library3

INSTANTIATED, INITIALIZATION, STEP, TERMINATED = "instantiated", "initialization mode", "step mode", "terminated"
FAILED = "error"  # the standard calls it terminated, too
ALL = {INSTANTIATED, INITIALIZATION, STEP, TERMINATED, FAILED}
LONGEST = 24  # calls
UNSUPPORTED = ("EnterEventMode", "EnterStepMode", "EnterConfigurationMode", "ExitConfigurationMode",
               "EvaluateDiscreteStates", "EnterContinuousTimeMode")  # fmt: skip


class Sequences:
    """Make sequences with an instance, and keep what is known of it: its state and time."""

    def __init__(self, library, seed):
        self.library, self.seed = library, seed
        self.counts, self.refused = collections.Counter(), collections.Counter()
        self.fmu, self.other = library.instantiate(), library.instantiate(b"other")
        self.foreign = self.other.get_state()[1]
        doubles = [v for v in library.variables if v.tag == "Float64"]
        self.outputs = [v.get("name") for v in doubles if v.get("causality") == "output"]
        self.inputs = [v.get("name") for v in doubles if v.get("causality") == "input"]
        self.starts = {v.get("name"): [float(x) for x in v.get("start").split()] for v in doubles if v.get("start")}
        self.others = [v.get("name") for v in library.variables if v.tag != "Float64"]
        self.fixed = [v.get("name") for v in doubles if v.get("variability") == "fixed"]

    def run(self, index):
        """Make one sequence."""
        self.random = random.Random(f"{self.seed} {index}")
        self.trace, self.saved = [], []
        self.do("Reset", lambda: self.fmu.call("Reset"), ALL, after=(INSTANTIATED, 0.0))
        for action in (self.enter, self.leave)[: self.random.choice((0, 0, 1, 2, 2, 2, 2))]:
            action()
        for _ in range(self.random.randint(1, LONGEST)):
            if self.state == FAILED and self.random.random() < 0.4:
                self.do("Reset", lambda: self.fmu.call("Reset"), ALL, after=(INSTANTIATED, 0.0))
            self.random.choice((self.enter, self.leave, self.terminate, self.step, self.step, self.step, self.read,
                                self.write, self.write_wrongly, self.read_wrongly, self.save, self.restore,
                                self.unsupported))()  # fmt: skip
        for handle, _ in self.saved:
            self.do("FreeFMUState", lambda handle=handle: self.fmu.call("FreeFMUState", byref(handle)), ALL)

    def do(self, name, call, allowed, *, legal=True, after=None):
        """Make a call and compare its status with the standard. `legal`: are its arguments? `after`: state and time."""
        expected = OK if legal and (name == "Reset" or self.state in allowed) else ERROR
        self.trace.append(f"{name} in {getattr(self, 'state', 'none')}, expected {expected}")
        self.library.logged.clear()
        status = call()
        assert status == expected, (status, self.library.logged)
        assert len(self.library.logged) == (status == ERROR), self.library.logged  # one line for each refusal
        self.counts[name] += 1
        if status == ERROR:
            self.refused[name] += 1
            self.state = FAILED
        elif after is not None:
            self.state, self.now = after
        return status

    def enter(self):
        start = self.random.choice((0.0, 0.0, 5.0, -1.0, math.nan))
        stop = self.random.choice((None, None, start + 1e3, start - 1.0))
        legal = math.isfinite(start) and (stop is None or stop >= start)
        self.do("Enter", lambda: self.fmu.enter(start, stop), {INSTANTIATED}, legal=legal,
                after=(INITIALIZATION, start))  # fmt: skip

    def leave(self):
        self.do("Leave", lambda: self.fmu.call("ExitInitializationMode"), {INITIALIZATION}, after=(STEP, self.now))

    def terminate(self):
        self.do("Terminate", lambda: self.fmu.call("Terminate"), {STEP}, after=(TERMINATED, self.now))

    def step(self):
        h, now = self.library.step, self.now
        time, step = self.random.choice([(now, h)] * 12 + [(now + h, h), (math.nan, h), (now, 0.0), (now, -h),
                                                           (now, math.nan), (now, math.inf)])  # fmt: skip
        legal = (time, step) == (now, h)
        status = self.do("DoStep", lambda: self.fmu.step(time, step), {STEP}, legal=legal, after=(STEP, time + step))
        assert list(self.fmu.flags) == [False] * 3
        if status == OK:
            assert self.fmu.reached.value == self.now
            self.read()

    def read(self):
        values = []

        def call():
            status, found = self.fmu.get("Float64", ["time", *self.outputs])
            values.extend(found)
            return status

        status = self.do("Get", call, ALL - {INSTANTIATED})
        if status == OK and self.state != FAILED:
            assert values[0] == self.now
            assert all(map(math.isfinite, values))

    def write(self):
        name = self.random.choice([*self.inputs, *self.fixed])
        allowed = {INSTANTIATED, INITIALIZATION} | (set() if name in self.fixed else {STEP})
        self.do("Set", lambda: self.fmu.set("Float64", [name], self.starts[name]), allowed)

    def write_wrongly(self):
        name = self.random.choice(self.inputs)
        call = self.random.choice((
            lambda: self.fmu.set("Float64", [name], [math.nan] * self.library.size[name]),
            lambda: self.fmu.set("Float64", [name], self.starts[name] + [0.0]),
            lambda: self.fmu.set("Float64", [self.outputs[0]], [0.0] * self.library.size[self.outputs[0]]),
            lambda: self.fmu.set("Float64", ["time"], [0.0]),
            lambda: self.fmu.set("Int32", [name], [0] * self.library.size[name]),
            lambda: self.fmu.call("SetFloat64", None, c_size_t(1), None, c_size_t(1)),
        ))  # fmt: skip
        self.do("Set wrongly", call, set())

    def read_wrongly(self):
        reference = self.random.choice((4_000_000_007, len(self.library.variables), 2**31, *self.others))
        kind = self.random.choice(("Float64", "Float64", "UInt8", "Int64", "Clock"))
        if kind == "Clock":
            self.do("Get wrongly", lambda: self.fmu.call("GetClock", None, c_size_t(1), None), set())
        elif kind == "Float64":
            self.do("Get wrongly", lambda: self.fmu.get(kind, [reference], 1)[0], set())
        else:
            self.do("Get wrongly", lambda: self.fmu.call(f"Get{kind}", None, c_size_t(3), None, c_size_t(3)), set())

    def save(self):
        handle = c_void_p()
        self.do("GetFMUState", lambda: self.fmu.call("GetFMUState", byref(handle)), ALL)
        self.saved.append((handle, (self.state, self.now)))

    def restore(self):
        if not self.saved or self.random.random() < 0.2:
            foreign = self.random.choice((self.foreign, c_void_p(), c_void_p(8)))
            self.do("SetFMUState wrongly", lambda: self.fmu.call("SetFMUState", foreign), set())
            return
        handle, after = self.random.choice(self.saved)
        if self.random.random() < 0.5:
            content = bytearray(self.fmu.serialise(handle)[1])
            damaged = self.random.random() < 0.5
            if damaged:
                content[self.random.randrange(len(content))] ^= 1 << self.random.randrange(8)
            made = []

            def call():
                status, copy = self.fmu.deserialise(bytes(content))
                made.append(copy)
                return status

            if self.do("DeserializeFMUState", call, ALL, legal=not damaged) == ERROR:
                return
            handle = made[0]
            self.saved.append((handle, after))
        self.do("SetFMUState", lambda: self.fmu.call("SetFMUState", handle), ALL, after=after)

    def unsupported(self):
        name = self.random.choice(UNSUPPORTED)
        self.do("unsupported", lambda: self.fmu.call(name), set())
        self.do("log", lambda: self.fmu.call("SetDebugLogging", c_bool(True), c_size_t(0), None), ALL)


def run(fmu, folder, sequences, seed=0):
    """Make sequences, and return how many calls were made and refused, by name; the first wrong answer is an error."""
    made = Sequences(Library3(fmu, folder), seed)
    for index in range(sequences):
        try:
            made.run(index)
        except AssertionError as error:
            raise AssertionError(f"sequence {index}: {error}\n" + "\n".join(made.trace)) from None
    made.fmu.free()
    made.other.free()
    return made.counts, made.refused


if __name__ == "__main__":
    faulthandler.enable()
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("fmu")
    parser.add_argument("--sequences", type=int, default=100_000)
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as unpacked:
        calls, refusals = run(given.fmu, unpacked, given.sequences, given.seed)
    print(sum(calls.values()), "calls,", sum(refusals.values()), "refused:", dict(refusals))
