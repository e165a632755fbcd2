"""Compile the exported controller and call its five functions."""

import ctypes
import subprocess
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from flexsat.fmu.embedded.export import EXAMPLE
from flexsat.fmu.embedded.header import EXACT, field, parameter_ports
from flexsat.fmu.native.compile import OPTIONS
from flexsat.fmu.python.shim import c_compiler
from flexsat.ports.table import PortTable

STATUS = ("ok", "command refused", "bad input", "failed")
WARNINGS = ("-Wall", "-Wextra", "-Wconversion", "-Werror")


def target_sources(folder: Path) -> list[str]:
    """Return the C files of an export that a target compiles."""
    return sorted(path.name for path in folder.glob("*.c") if path.name not in EXAMPLE)


def compile_export(files: Mapping[str, bytes], folder: Path, options: Sequence[str] = ()) -> Path:
    """Write an export and compile it into a shared library; further options replace those before."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, content in files.items():
        (folder / name).write_bytes(content)
    flags = [option for option in OPTIONS if option != "-fvisibility=hidden"]
    command = [*c_compiler(), *flags, *WARNINGS, *options, "-o", "controller.so", *target_sources(folder), "-lm"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return folder / "controller.so"


def constant(header: bytes, name: str) -> int:
    """Return a number that a header defines."""
    return int(next(line.split()[2] for line in header.decode().splitlines() if line.startswith(f"#define {name} ")))


class Exported:
    """A controller in memory of its own. Inputs, outputs and parameters are structures of ctypes."""

    def __init__(self, library: Path, table: PortTable, header: bytes, **parameters: Any) -> None:
        self.real = ctypes.c_float if b"typedef float" in header else ctypes.c_double
        self.library = ctypes.CDLL(str(library))
        self.library.flexsat_prepare.restype = ctypes.c_void_p
        self.state_size, self.memory_size = (constant(header, f"FLEXSAT_{n}_SIZE") for n in ("STATE", "MEMORY"))
        self.inputs = self._structure([p for p in table if p.causality == "input"])()
        states = sum(table[f"estimate.{name}"].length for name in
                     ("mrp", "modal.displacement", "rate", "modal.velocity", "wheel.speed"))  # fmt: skip
        wheels = table["wheel.torque"].length
        layout = {"wheel_torque": wheels, "reference_torque": wheels, "reference": states, "estimate": states,
                  "slow_errors": table["estimate.disturbance"].length + table["estimate.gyro_bias"].length}  # fmt: skip
        fields = [(name, self.real * size) for name, size in layout.items()]
        self.outputs = type("Outputs", (ctypes.Structure,), {"_fields_": fields})()
        kind = self._structure(parameter_ports(table), ctypes.c_double)
        self.parameters = kind.from_buffer_copy(kind.in_dll(self.library, "flexsat_default_parameters"))
        for name, value in parameters.items():
            place = getattr(self.parameters, name)
            setattr(self.parameters, name, type(place)(*value) if isinstance(place, ctypes.Array) else value)
        self._reason = ctypes.c_char_p()
        self.prepare(self.memory_size)

    def _structure(self, ports: Sequence[Any], real: Any = None) -> Any:
        def kind(port: Any) -> Any:
            one = ctypes.c_int
            if port.kind == "real":
                one = ctypes.c_double if port.name in EXACT else real or self.real
            return one if port.size is None else one * port.length

        return type("Fields", (ctypes.Structure,), {"_fields_": [(field(p), kind(p)) for p in ports]})

    @property
    def reason(self) -> str:
        """Return why the last call returned something other than ok."""
        return (self._reason.value or b"").decode()

    def prepare(self, size: int) -> bool:
        """Prepare in this much memory; return whether that was accepted."""
        self._memory = (ctypes.c_double * (size // 8 + 1))()
        made = self.library.flexsat_prepare(
            ctypes.byref(self.parameters), self._memory, ctypes.c_size_t(size), ctypes.byref(self._reason)
        )
        self._controller = ctypes.c_void_p(made)
        return made is not None

    def init(self) -> str:
        """Begin with the command that is in the inputs."""
        rotation, start = self.inputs.command_rotation, ctypes.c_double(self.inputs.command_start_time)
        return STATUS[self.library.flexsat_init(self._controller, rotation, start)]

    def set(self, name: str, value: Any) -> None:
        """Set an input by the name of its port."""
        place = getattr(self.inputs, name.replace(".", "_"))
        if isinstance(place, ctypes.Array):
            place[:] = np.ravel(value).tolist()
        else:
            setattr(self.inputs, name.replace(".", "_"), value)

    def step(self) -> str:
        """Make a step."""
        return STATUS[
            self.library.flexsat_step(self._controller, ctypes.byref(self.inputs), ctypes.byref(self.outputs))
        ]

    def result(self) -> np.ndarray:
        """Return the outputs: torque, reference torque, reference, estimate."""
        return np.concatenate([np.array(getattr(self.outputs, name)) for name, _ in self.outputs._fields_])

    def save(self) -> bytes:
        """Return the state."""
        bytes_ = (ctypes.c_ubyte * self.state_size)()
        self.library.flexsat_save(self._controller, bytes_)
        return bytes(bytes_)

    def restore(self, state: bytes) -> str:
        """Continue from a state."""
        return STATUS[
            self.library.flexsat_restore(self._controller, (ctypes.c_ubyte * self.state_size).from_buffer_copy(state))
        ]
