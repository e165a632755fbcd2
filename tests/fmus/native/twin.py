"""Compile the C twin of a component, and call it by the contract of component.h, without FMI."""

import ctypes
import re
import subprocess
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from flexsat.fmu.native.matrix_source import matrix_sources
from flexsat.fmu.native.port_source import port_places
from flexsat.fmu.native.sources import c_files
from flexsat.fmu.python.shim import c_compiler
from flexsat.ports.table import Port, PortTable

OPTIONS = ("-std=c99", "-O2", "-Wall", "-Wextra", "-Wconversion", "-Werror", "-ffp-contract=off")
MESSAGE_SIZE = 512


class Memory(ctypes.Structure):
    """`Memory` of memory.h."""

    _fields_ = [("allocate", ctypes.c_void_p), ("release", ctypes.c_void_p), ("last", ctypes.c_void_p),
                ("failed", ctypes.c_int)]  # fmt: skip


class Component(ctypes.Structure):
    """`Component` of component.h."""

    _fields_ = [
        ("real", ctypes.c_void_p),
        ("integer", ctypes.c_void_p),
        ("boolean", ctypes.c_void_p),
        ("string", ctypes.c_void_p),
        ("memory", Memory),
        ("state", ctypes.c_void_p),
        ("state_size", ctypes.c_size_t),
        ("start_time", ctypes.c_double),
        ("step_length", ctypes.c_double),
        ("own", ctypes.c_void_p),
        ("message", ctypes.c_char * MESSAGE_SIZE),
    ]


def sources_of(name: str) -> list[Path]:
    """Return the source files that a C file needs: its own, and those of the headers that it includes."""
    there = c_files()
    found: list[Path] = []
    waiting = [name]
    while waiting:
        stem = waiting.pop()
        for path in (there.get(f"{stem}.c"), there.get(f"{stem}.h")):
            if path is not None and path not in found:
                found.append(path)
                waiting += re.findall(r'#include "(\w+)\.h"', path.read_text(encoding="utf-8"))
    return sorted(path for path in found if path.suffix == ".c")


def compile_library(
    sources: Sequence[Path], out: Path, options: Sequence[str] = (), include: Sequence[Path] = ()
) -> Path:
    """Compile C files into a shared library; fail with the compiler's words.

    Its functions call each other, whatever the process has of the same names: libc has `step`.
    """
    own = sorted({path.parent for path in c_files().values()})
    folders = [f"-I{folder}" for folder in (*own, *include)]
    command = [
        *c_compiler(),
        *OPTIONS,
        *options,
        "-fPIC",
        "-shared",
        "-Wl,-Bsymbolic",
        *folders,
        "-o",
        str(out),
        *map(str, sources),
        "-lm",
    ]
    result = subprocess.run(command, capture_output=True, text=True)
    assert result.returncode == 0, result.stderr
    return out


def compile_twin(
    component: str, ports: Sequence[Port], variants: Mapping[str, Any], folder: Path, options: Sequence[str] = ()
) -> Path:
    """Compile the twin of a component with its matrices into a shared library in a folder, and return its path.

    Parameters
    ----------
    component : "plant", "sensors", "controller"
    ports : of the component; matrix sets by the names of their variants, as in `matrix_sources`; none if it has none
    options : further ones of the compiler
    """
    folder.mkdir(parents=True, exist_ok=True)
    files = (matrix_sources(component, variants) if variants else {}) | {"ports.h": port_places(PortTable(ports))}
    for name, text in files.items():
        (folder / name).write_text(text, encoding="utf-8")
    sources = [*sources_of(component), *([folder / "data.c"] if variants else [])]
    return compile_library(sources, folder / f"{component}.so", options, [folder])


class Twin:
    """One instance of a compiled component. Calls raise ValueError with the component's message."""

    def __init__(self, library: Path, ports: Sequence[Port], **values: Any) -> None:
        """Make the instance with the start values of its ports, changed by `values` (dots of names as `__`)."""
        self.table = PortTable(ports)
        self._library = ctypes.CDLL(str(library))
        heap = ctypes.CDLL(None)
        self.arrays = {
            kind: np.array([start for port in self.table if port.kind == kind for start in port.starts], dtype)
            for kind, dtype in (("real", np.float64), ("integer", np.int32), ("boolean", np.int32))
        }
        texts = [str(start).encode() for port in self.table if port.kind == "string" for start in port.starts]
        self._texts = (ctypes.c_char_p * max(1, len(texts)))(*texts)
        self.component = Component(
            real=self.arrays["real"].ctypes.data,
            integer=self.arrays["integer"].ctypes.data,
            boolean=self.arrays["boolean"].ctypes.data,
            string=ctypes.addressof(self._texts),
            memory=Memory(
                allocate=ctypes.cast(heap.calloc, ctypes.c_void_p).value,
                release=ctypes.cast(heap.free, ctypes.c_void_p).value,
            ),
        )
        for name, value in values.items():
            self.set(name.replace("__", "."), value)

    def close(self) -> None:
        """Release the memory of the instance."""
        self._library.memory_release(ctypes.byref(self.component.memory))

    def view(self, name: str) -> np.ndarray[Any, Any]:
        """Return the values of a port that is no string, (size,), as a view."""
        return self.arrays[self.table[name].kind][self.table.span(name)]

    def text(self, name: str) -> str:
        """Return the value of a string port."""
        return self._texts[self.table.span(name).start].decode()

    def set(self, name: str, value: Any) -> None:
        """Set all values of a port."""
        if self.table[name].kind == "string":
            self._texts[self.table.span(name).start] = str(value).encode()
        else:
            self.view(name)[:] = value

    def _call(self, name: str, *arguments: float) -> None:
        function = self._library[f"component_{name}"]
        if function(ctypes.byref(self.component), *map(ctypes.c_double, arguments)) != 0:
            raise ValueError(self.component.message.decode())

    def start(self, time: float = 0.0) -> None:
        """Prepare, and make the state at the start of a run."""
        self.close()
        self.component.start_time = time
        self._call("start")

    def first_step(self, length: float) -> None:
        """Prepare for steps of this length [s]."""
        self._call("first_step", length)

    def advance(self, time: float, step: float) -> None:
        """Make a step."""
        self._call("advance", time, step)

    def tuned(self) -> None:
        """Use the present values of tunable parameters."""
        self._call("tuned")

    def follow_inputs(self) -> None:
        """Compute the outputs that follow inputs."""
        self._call("follow_inputs")

    def evaluate(self) -> None:
        """Compute the outputs on demand."""
        self._call("evaluate")

    def save(self) -> tuple[bytes, dict[str, Any], float]:
        """Return a copy of the state, the values and the step length."""
        state = ctypes.string_at(self.component.state, self.component.state_size)
        values = {kind: array.copy() for kind, array in self.arrays.items()}
        return state, values, float(self.component.step_length)

    def restore(self, saved: tuple[bytes, dict[str, Any], float]) -> None:
        """Continue where a state was saved, by an instance with the same parameters."""
        state, values, self.component.step_length = saved
        assert len(state) == self.component.state_size
        ctypes.memmove(self.component.state, state, len(state))
        for kind, array in values.items():
            self.arrays[kind][:] = array
        self._call("restored")
