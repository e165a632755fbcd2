"""Sequences of legal and illegal calls of an FMU, and what the standard says of each: FMI 2.0.4, section 4.2.4.

    python call_sequences.py FMU [--sequences N] [--seed N] [--first N]

makes the sequences in this process, which may crash, and prints what was called how often, as JSON. Each sequence has a
seed of its own: `--first K --sequences 1` repeats sequence K.
"""

from __future__ import annotations

import argparse
import collections
import ctypes
import faulthandler
import json
import math
import random
import sys
import tempfile
from ctypes import byref, c_char, c_char_p, c_double, c_int, c_size_t, c_uint, c_void_p
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))

from fmus.raw_fmu import DISCARD, ERROR, KINDS, OK, Library

# In which states the standard allows a call; a slave without pending steps has no others.
INSTANTIATED, INITIALIZATION, COMPLETE = "instantiated", "initialization mode", "step complete"
TERMINATED, FAILED = "terminated", "error"
ALL = {INSTANTIATED, INITIALIZATION, COMPLETE, TERMINATED, FAILED}
TABLE = {
    "SetDebugLogging": ALL,
    "SetupExperiment": {INSTANTIATED},
    "EnterInitializationMode": {INSTANTIATED},
    "ExitInitializationMode": {INITIALIZATION},
    "Terminate": {COMPLETE},
    "Reset": ALL,
    "Get": {INITIALIZATION, COMPLETE, TERMINATED, FAILED},
    "Set": {INSTANTIATED, INITIALIZATION, COMPLETE},
    "State": ALL,
    "DoStep": {COMPLETE},
    "Status": {COMPLETE, TERMINATED},
    "Never": set(),  # what the model description says is not supported
}
BAD_REFERENCES = (4_000_000_007, 0x7FFFFFF0, 0x7FFFFFF1, 2**31, 100_000)
LONGEST = 24  # calls


class Wrong(AssertionError):
    """A call that was answered otherwise than the standard says."""


class Model:
    """What is known of the instance: the oracle."""

    def __init__(self):
        self.state, self.set_up, self.now, self.stop = INSTANTIATED, False, 0.0, None

    def saved(self):
        """Return what a saved state brings back: the stop time belongs to the experiment, not to the state."""
        return self.state, self.set_up, self.now


class Sequences:
    """Make sequences of calls of one FMU."""

    def __init__(self, library, seed):
        self.library, self.seed = library, seed
        self.counts, self.refused = collections.Counter(), collections.Counter()
        self.other = library.instantiate(b"other")
        _, self.state_of_other = self.other.get_state()
        reals = [(r, v.get("causality"), v.get("variability"), v[0].get("start"))
                 for v, kind, r in library.variables if kind == "Real"]  # fmt: skip
        self.inputs = [(r, float(start)) for r, causality, _, start in reals if causality == "input"]
        self.fixed = [(r, float(start)) for r, _, variability, start in reals if variability == "fixed"]
        self.outputs = library.references("Real", "output")
        self._new()
        self.bases = [self._base(steps) for steps in range(5)]

    def _new(self):
        self.fmu = self.library.instantiate()
        assert self.fmu, self.library.logged
        self.model, self.handles = Model(), []

    def _base(self, steps):
        """Return the handle of a state in each part of the life cycle, from which most sequences begin."""
        h = self.library.step
        calls = [
            lambda: self.fmu.setup(),
            lambda: self.fmu.call("EnterInitializationMode"),
            lambda: self.fmu.call("ExitInitializationMode"),
            lambda: (self.fmu.step(0.0), self.fmu.call("Terminate"))[1],
        ]
        after = [Model() for _ in range(5)]
        states = (INSTANTIATED, INSTANTIATED, INITIALIZATION, COMPLETE, TERMINATED)
        for k, state in enumerate(states):
            after[k].state, after[k].set_up, after[k].now = state, k > 0, h if k == 4 else 0.0
        self.fmu.call("Reset")
        for call in calls[:steps]:
            assert call() == OK, self.library.logged
        status, handle = self.fmu.get_state()
        assert status == OK
        return handle, after[steps].saved()

    def run(self, index):
        """Make one sequence."""
        self.random = random.Random(f"{self.seed} {index}")
        self.trace = []
        draw = self.random.random()
        if draw < 0.005:
            self.fmu.free()
            self._new()
            self.bases = [self._base(steps) for steps in range(5)]
        if draw < 0.02:
            self.do("Reset", lambda: self.fmu.call("Reset"), state=Model().saved())
        else:
            self.begin()
        for _ in range(self.random.randint(1, LONGEST)):
            if self.model.state == FAILED and self.random.random() < 0.4:
                self.begin()  # or else most calls would only be refused since another was
            self.random.choices(*zip(*ACTIONS, strict=True))[0](self)
        for handle, _ in self.handles:
            self.do("State", lambda handle=handle: self.fmu.free_state(handle), what="free")
        self.handles = []

    def do(self, name, call, *, legal=True, state=None, what="", after=None):
        """Make a call, compare its status with the standard, and note what follows. `legal`: are its arguments?"""
        allowed = legal and self.model.state in TABLE[name]
        self.trace.append(f"{name} {what} in {self.model.state}{'' if allowed else ': to be refused'}")
        self.library.logged.clear()
        status = call()
        expected = after if allowed and after is not None else OK if allowed else ERROR
        if status != expected:
            raise Wrong(f"status {status}, expected {expected}: {self.library.logged}")
        self.counts[name] += 1
        if status == ERROR:
            self.refused[name] += 1
            self.model.state = FAILED
            if not any(level == ERROR and text for _, level, _, text in self.library.logged):
                raise Wrong("refused without a message")
        elif state is not None:
            self.model.state, self.model.set_up, self.model.now = state
        return status

    # Actions.

    def begin(self):
        # mostly states after the start of the model: those before it allow few calls
        ((handle, saved),) = self.random.choices(self.bases, (1, 1, 1, 12, 4))
        self.do("State", lambda: self.fmu.set_state(handle), state=saved, what="set")

    def setup(self):
        start = self.random.choice((0.0, 0.0, 5.0, -1.0, math.nan, math.inf))
        stop = self.random.choice((None, None, start + 1e3, start - 1.0, math.nan))
        tolerance = self.random.choice((None, 1e-6, 0.0, -1.0, math.nan))
        legal = math.isfinite(start) and (stop is None or stop >= start) and (tolerance is None or tolerance >= 0.0)
        if self.do("SetupExperiment", lambda: self.fmu.setup(start, stop, tolerance), legal=legal,
                   state=(INSTANTIATED, True, start), what=f"{start} {stop} {tolerance}") == OK:  # fmt: skip
            self.model.stop = stop

    def enter(self):
        now = self.model.now
        self.do("EnterInitializationMode", lambda: self.fmu.call("EnterInitializationMode"), legal=self.model.set_up,
                state=(INITIALIZATION, True, now))  # fmt: skip

    def leave(self):
        self.do("ExitInitializationMode", lambda: self.fmu.call("ExitInitializationMode"),
                state=(COMPLETE, True, self.model.now))  # fmt: skip

    def terminate(self):
        self.do("Terminate", lambda: self.fmu.call("Terminate"), state=(TERMINATED, True, self.model.now))

    def reset(self):
        self.do("Reset", lambda: self.fmu.call("Reset"), state=Model().saved())
        self.model.stop = None

    def step(self):
        h, now = self.library.step, self.model.now
        time = self.random.choice([now] * 12 + [now - h, now + h, math.nan, math.inf, -math.inf])
        step = self.random.choice([h] * 12 + [0.0, -h, math.nan, math.inf, 1.5 * h])
        legal = time == now and step > 0.0 and math.isfinite(step) and (not self.library.fixed_step or step == h)
        legal = legal and (self.model.stop is None or time + step <= self.model.stop)
        if self.do("DoStep", lambda: self.fmu.step(time, step), legal=legal, state=(COMPLETE, True, time + step),
                   what=f"{time} {step}") == OK:  # fmt: skip
            self.read()

    def read(self):
        values = []

        def call():
            status, found = self.fmu.get("Real", self.outputs)
            values.extend(found)
            return status

        self.do("Get", call, what="all outputs")
        if self.model.state != FAILED and not all(map(math.isfinite, values)):
            raise Wrong("an output is not finite")

    def read_wrongly(self):
        kind = self.random.choice(list(KINDS))
        some, one = (c_uint * 1)(self.random.choice(BAD_REFERENCES)), (KINDS[kind] * 1)()
        arguments = self.random.choice(((some, c_size_t(1), one), (None, c_size_t(1), one), (some, c_size_t(1), None)))
        self.do("Get", lambda: self.fmu.call(f"Get{kind}", *arguments), legal=False, what=f"{kind} wrongly")

    def write(self):
        values = [start + self.random.gauss(0.0, 1e-4) for _, start in self.inputs]
        self.do("Set", lambda: self.fmu.set("Real", [r for r, _ in self.inputs], values), what="all inputs")

    def write_nothing(self):
        kind = self.random.choice(list(KINDS))
        self.do("Set", lambda: self.fmu.set(kind, [], []), what="nothing")

    def write_parameter(self):
        reference, start = self.random.choice(self.fixed)
        legal = self.model.state != COMPLETE
        self.do("Set", lambda: self.fmu.set("Real", [reference], [start]), legal=legal, what="a fixed parameter")

    def write_wrongly(self):
        if self.random.random() < 0.5:
            reference = self.random.choice(self.outputs + [r for r, _ in self.inputs])
            value = 1.0 if reference in self.outputs else self.random.choice((math.nan, math.inf))
            self.do("Set", lambda: self.fmu.set("Real", [reference], [value]), legal=False, what="a wrong real")
            return
        kind = self.random.choice(list(KINDS))
        some, one = (c_uint * 1)(self.random.choice(BAD_REFERENCES)), (KINDS[kind] * 1)()
        if kind == "String":
            one[0] = self.random.choice((b"text", b"\xff\xfe", b"\xed\xa0\x80", None))
        arguments = self.random.choice(((some, c_size_t(1), one), (None, c_size_t(1), one), (some, c_size_t(1), None)))
        self.do("Set", lambda: self.fmu.call(f"Set{kind}", *arguments), legal=False, what=f"{kind} wrongly")

    def save(self):
        old = self.random.choice(self.handles) if self.handles and self.random.random() < 0.5 else None
        handle = c_void_p() if old is None else old[0]
        before = handle.value
        self.do("State", lambda: self.fmu.call("GetFMUstate", byref(handle)), what="get")
        if old is not None:
            self.handles.remove(old)
            if handle.value != before:
                raise Wrong("fmi2GetFMUstate did not reuse the state")
        self.handles.append((handle, self.model.saved()))

    def restore(self):
        if not self.handles:
            return
        handle, saved = self.random.choice(self.handles)
        self.do("State", lambda: self.fmu.set_state(handle), state=saved, what="set")

    def free(self):
        if not self.handles:
            return
        handle, _ = self.handles.pop(self.random.randrange(len(self.handles)))
        copy = c_void_p(handle.value)
        self.do("State", lambda: self.fmu.free_state(handle), what="free")
        if handle.value is not None:
            raise Wrong("fmi2FreeFMUstate left the pointer")
        self.do("State", lambda: self.fmu.free_state(handle), what="free null")
        if self.random.random() < 0.3:
            self.use_wrong_state(copy)

    def use_wrong_state(self, handle=None):
        foreign = ctypes.create_string_buffer(256)
        choice = (c_void_p(), c_void_p(ctypes.addressof(foreign)), c_void_p(self.state_of_other.value), c_void_p(1))
        wrong = handle or self.random.choice(choice)
        calls = {
            "set": lambda: self.fmu.set_state(wrong),
            "size": lambda: self.fmu.call("SerializedFMUstateSize", wrong, byref(c_size_t())),
            "serialise": lambda: self.fmu.call("SerializeFMUstate", wrong, foreign, c_size_t(256)),
            "get into NULL": lambda: self.fmu.call("GetFMUstate", None),
        }
        if wrong.value:
            calls["free"] = lambda: self.fmu.call("FreeFMUstate", byref(wrong))
            calls["get"] = lambda: self.fmu.call("GetFMUstate", byref(wrong))
        what = self.random.choice(list(calls))
        self.do("State", calls[what], legal=False, what=f"{what}, a wrong one")

    def serialise(self):
        if not self.handles:
            return
        handle, saved = self.random.choice(self.handles)
        status, content = self.fmu.serialise(handle)
        if status != OK:
            raise Wrong(f"serialising: {status}")
        if self.random.random() < 0.5:
            copy = c_void_p()
            self.do("State", lambda: self.fmu.call("DeSerializeFMUstate", content, c_size_t(len(content)), byref(copy)),
                    what="deserialise")  # fmt: skip
            self.handles.append((copy, saved))
            return
        damaged = bytearray(content)
        at = self.random.randrange(len(damaged))
        damaged[at] ^= 1 << self.random.randrange(8)
        damaged = self.random.choice((bytes(damaged), content[:at], b"", self.random.randbytes(100)))
        calls = {
            "deserialise": lambda: self.fmu.deserialise(damaged)[0],
            "deserialise NULL": lambda: self.fmu.call("DeSerializeFMUstate", None, c_size_t(9), byref(c_void_p())),
            "deserialise to NULL": lambda: self.fmu.call("DeSerializeFMUstate", content, c_size_t(len(content)), None),
            "serialise, wrong size": lambda: self.fmu.call(
                "SerializeFMUstate", handle, (c_char * (len(content) + 9))(), c_size_t(len(content) + 9)
            ),
            "serialise to NULL": lambda: self.fmu.call("SerializeFMUstate", handle, None, c_size_t(len(content))),
            "size to NULL": lambda: self.fmu.call("SerializedFMUstateSize", handle, None),
        }
        what = self.random.choice(list(calls))
        self.do("State", calls[what], legal=False, what=what)

    def log(self):
        names = (c_char_p * 1)(b"logStatusError")
        choice = ((c_int(1), c_size_t(1), names), (c_int(0), c_size_t(0), None), (c_int(1), c_size_t(1), None))
        arguments = self.random.choice(choice)
        legal = arguments[1].value == 0 or arguments[2] is not None
        self.do("SetDebugLogging", lambda: self.fmu.call("SetDebugLogging", *arguments), legal=legal)

    def inquire(self):
        kind = self.random.randrange(4)
        if self.random.random() < 0.5:
            value = c_double()
            self.do("Status", lambda: self.fmu.call("GetRealStatus", c_int(kind), byref(value)),
                    after=OK if kind == 2 else DISCARD, what=f"real {kind}")  # fmt: skip
            if kind == 2 and self.model.state != FAILED and value.value != self.model.now:
                raise Wrong(f"the last successful time is {value.value}, not {self.model.now}")
        else:
            value = c_int(5)
            self.do("Status", lambda: self.fmu.call("GetBooleanStatus", c_int(kind), byref(value)),
                    after=OK if kind == 3 else DISCARD, what=f"boolean {kind}")  # fmt: skip

    def use_unsupported(self):
        one, value, order = (c_uint * 1)(0), (c_double * 1)(), (c_int * 1)(1)
        n = c_size_t(1)
        name, *arguments = self.random.choice((
            ("CancelStep",),
            ("GetDirectionalDerivative", one, n, one, n, value, value),
            ("SetRealInputDerivatives", one, n, order, value),
            ("GetRealOutputDerivatives", one, n, order, value),
        ))  # fmt: skip
        self.do("Never", lambda: self.fmu.call(name, *arguments), what=name)


ACTIONS = [
    (Sequences.setup, 4), (Sequences.enter, 6), (Sequences.leave, 2), (Sequences.terminate, 1), (Sequences.reset, 0.1),
    (Sequences.step, 20), (Sequences.read, 8), (Sequences.read_wrongly, 0.5), (Sequences.write, 12),
    (Sequences.write_nothing, 1), (Sequences.write_parameter, 1), (Sequences.write_wrongly, 1), (Sequences.save, 5),
    (Sequences.restore, 5), (Sequences.free, 3), (Sequences.use_wrong_state, 0.5), (Sequences.serialise, 2),
    (Sequences.log, 1), (Sequences.inquire, 2), (Sequences.use_unsupported, 0.3),
]  # fmt: skip


def main(arguments=None):
    """Run what the command line says; a call that is answered wrongly ends it with the calls before."""
    parser = argparse.ArgumentParser()
    parser.add_argument("fmu", nargs="+")
    parser.add_argument("--sequences", type=int, default=100)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--first", type=int, default=0)
    given = parser.parse_args(arguments)
    faulthandler.enable()
    for path in given.fmu:
        with tempfile.TemporaryDirectory() as folder:
            made = Sequences(Library(path, folder), given.seed)
            for index in range(given.first, given.first + given.sequences):
                try:
                    made.run(index)
                except Wrong as error:
                    calls = "\n  ".join(made.trace)
                    sys.exit(f"{path}: sequence {index}, call {len(made.trace)}: {error}\n  {calls}")
            made.fmu.free()
            made.other.free()
        print(json.dumps({"fmu": path, "calls": sum(made.counts.values()), "refused": dict(made.refused)}), flush=True)


if __name__ == "__main__":
    main()
