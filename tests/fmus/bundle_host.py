"""Write bundles, and call one function by function, its variables by their names."""

from ctypes import byref, c_size_t, c_void_p, create_string_buffer
from dataclasses import replace
from pathlib import Path

import numpy as np

from lockstep import Component, load_system, simulate
from lockstep.bundle.contents import contents
from lockstep.bundle.ports import Choice
from lockstep.bundle.write import bundle_bytes
from lockstep.fmi.instantiate import instantiate
from lockstep.fmi.model_description import read_description
from lockstep.fmi.slave import DTYPES

MS = 1_000_000  # [ns]
CLOSED = Choice(inputs=("none",), outputs=("all",))


def bundled(system, path, choice=CLOSED, overrides=None, step=None, version="2.0"):
    """Write the bundle of a system; return its path."""
    path.write_bytes(bundle_bytes(contents(system, overrides or {}, choice, step), version=version))
    return path


def recorded(system, stop, **more):
    """Simulate a system, all FMUs in this process, and return all recorded outputs at each tick by name."""
    parts = (replace(component, isolated=False) for component in system.components)
    signals = simulate(replace(system, components=tuple(parts)), stop_time=stop, record=("all",), **more)
    return {name: np.asarray(signals[name]) for name in signals}


def alone(path, stop, **more):
    """Simulate an FMU, and return all recorded outputs by the names that they have in it."""
    return {
        name.partition(".")[2] or name: values for name, values in recorded(load_system(path), stop, **more).items()
    }


def bits(values):
    """Return values as they are compared."""
    return values.tolist() if values.dtype == object else values.tobytes()


class Host:
    """One instance; calls return the status and never raise."""

    def __init__(self, path: Path, folder: Path, name="it"):
        part = Component(name=name, source=path, period=MS)
        self.description = read_description(part)
        self.log = []
        self.slave = instantiate(part, self.description, folder, lambda *entry: self.log.append(entry))

    def call(self, name, *arguments):
        """Call a function by its name in FMI 2.0, without prefix."""
        if self.description.version == "3.0":
            name = name.replace("FMUstate", "FMUState").replace("DeSerialize", "Deserialize")
        return self.slave.instance.call(name, *arguments)

    def __enter__(self):
        """Return the host; the instance is freed at the end."""
        return self

    def __exit__(self, *_):
        """Free the instance."""
        self.slave.close()

    def start(self, at=0.0, **values):
        """Bring the instance to step mode, with start values."""
        self.slave.setup_experiment(at, None)
        self.set(**values)
        worst = max(self.slave.enter_initialization(), self.slave.exit_initialization())
        assert worst == 0, self.texts
        return self

    def set(self, **values):
        """Set variables, two underscores for a dot; return the worst status."""
        return max((self.set_one(key.replace("__", "."), value) for key, value in values.items()), default=0)

    def set_one(self, name, value):
        """Set a variable; return the status."""
        variable = self.description.variables[name]
        return self.slave.set_start({variable.reference: value}, variable.scalar)

    def get(self, *names):
        """Return values of variables."""
        found = []
        for name in names:
            variable = self.description.variables[name]
            buffer = np.zeros(1, DTYPES[variable.scalar])
            status = self.slave.getter(variable.scalar, np.array([variable.reference], np.uint32), buffer)()
            assert status <= 1, self.texts
            found.append(buffer[0])
        return found

    def row(self):
        """Return all outputs."""
        return tuple(self.get(*self.description.names("output")))

    def run(self, first, last, step=0.001):
        """Make steps from one tick to another, and return the rows after each."""
        rows = []
        for tick in range(first, last):
            assert self.slave.do_step(tick * step, step, 1) == 0, self.texts
            rows.append(self.row())
        return rows

    @property
    def texts(self):
        """The texts of all messages."""
        return [entry[2] if len(entry) == 3 else entry[-1] for entry in self.log]

    def state(self):
        """Return a state."""
        state = c_void_p()
        assert self.call("GetFMUstate", byref(state)) == 0, self.texts
        return state

    def serialised(self, state):
        """Return a state as bytes."""
        size = c_size_t()
        assert self.call("SerializedFMUstateSize", state, byref(size)) == 0
        buffer = create_string_buffer(size.value)
        assert self.call("SerializeFMUstate", state, buffer, size) == 0, self.texts
        return buffer.raw

    def deserialised(self, content):
        """Return the status and the state of bytes."""
        state = c_void_p()
        status = self.call(
            "DeSerializeFMUstate", create_string_buffer(content, len(content)), len(content), byref(state)
        )
        return status, state
