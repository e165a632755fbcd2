"""Hold the values of all ports in flat buffers, with the fastest reader and writer of each list of references."""

from __future__ import annotations

import struct
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from math import isfinite
from typing import Any

import numpy as np

from ...ports.table import CAUSALITIES, KINDS, Kind, Port, PortTable, Scalar, Variable

AnyArray = np.ndarray[Any, Any]
Indices = slice | np.ndarray[Any, np.dtype[np.intp]]


class Refused(ValueError):
    """A call that is not allowed: logged in one line, without a traceback."""


class PortValues:
    """The values of a port table: one flat array for the reals, one each for integers and booleans, and strings.

    A view of a port stays valid for the life of the object: values are only ever written in place.
    """

    __slots__ = ("_outputs", "_parameters", "_ranges", "_variables", "_zeros", "arrays", "strings", "table")

    def __init__(self, table: PortTable) -> None:
        self.table = table
        self._variables = {kind: table.of_kind(kind) for kind in KINDS}
        starts = {kind: [v.port.starts[v.element] for v in self._variables[kind]] for kind in KINDS}
        self.arrays: dict[Kind, AnyArray] = {
            "real": np.array(starts["real"], dtype=np.float64),
            "integer": np.array(starts["integer"], dtype=np.int32),
            "boolean": np.array(starts["boolean"], dtype=np.bool_),
        }
        self.strings: list[str] = [str(text) for text in starts["string"]]
        self._outputs = self.arrays["real"][table.run("output")]
        self._zeros = np.zeros_like(self._outputs)
        self._parameters = [array[table.run("parameter", kind)] for kind, array in self.arrays.items()]
        numbers: tuple[Kind, ...] = ("real", "integer")
        self._ranges = {kind: _limits(self._variables[kind]) for kind in numbers}

    def view(self, name: str) -> AnyArray:
        """Return a port as a writable view: shape (size,), or () for a scalar, which is written `view[()] = x`."""
        port = self.table[name]
        if port.kind == "string":
            raise ValueError(f"{name}: a string has no view; read it with `value`, write it with `put`")
        part = self.arrays[port.kind][self.table.span(name)]
        return part if port.size is not None else part.reshape(())

    def value(self, name: str) -> Any:
        """Return a port as a Python value, or as a copy of its array."""
        port = self.table[name]
        if port.kind == "string":
            texts = self.strings[self.table.span(name)]
            return texts[0] if port.size is None else tuple(texts)
        view = self.view(name)
        return view.item() if port.size is None else view.copy()

    def put(self, name: str, value: Any) -> None:
        """Write a port, whatever its kind."""
        port = self.table[name]
        if port.kind == "string":
            self.strings[self.table.span(name)] = [value] if port.size is None else value
        else:
            self.view(name)[...] = value

    def variable(self, kind: Kind, reference: int) -> Variable:
        """Return the variable behind a value reference."""
        known = self._variables[kind]
        place = reference - self.table.first_reference[kind]
        if 0 <= place < len(known):
            return known[place]
        other = next((v for v in self.table.variables if v.value_reference == reference), None)
        if other is not None:
            reason = f"it is that of {other.name}, which is {other.port.kind}"
        elif known:
            reason = f"there are {len(known)}, from {self.table.first_reference[kind]} on"
        else:
            reason = "there are none"
        raise Refused(f"{kind} value reference {reference}: no such variable; {reason}")

    def admit(self, kind: Kind, reference: int, value: Any, *, parameters: bool) -> None:
        """Refuse a value that may not be set; `parameters`: whether fixed parameters may be."""
        variable = self.variable(kind, reference)
        if variable.port.causality == "output":
            raise Refused(f"{variable.name} is an output and cannot be set")
        if variable.port.variability == "fixed" and not parameters:
            raise Refused(f"{variable.name} is a fixed parameter and cannot be set after initialisation, got {value!r}")
        objection = variable.port.objection(value)
        if objection:
            raise Refused(f"{variable.name} {objection}")

    def admits(self, kind: Kind, references: Sequence[int]) -> Callable[[Sequence[float]], bool]:
        """Return a function that says whether reals are finite, and within the limits declared for the references."""
        if not any(port.limited for port in self.ports(kind, references)):
            return lambda values: isfinite(sum(values))
        indices = self.indices(kind, references)
        lowest, highest = (limits[indices] for limits in self._ranges[kind])

        def within(values: Sequence[float]) -> bool:
            given = np.array(values)
            return bool(((given >= lowest) & (given <= highest)).all())  # not of NaN

        return within

    def ports(self, kind: Kind, references: Sequence[int]) -> list[Port]:
        """Return the ports of references, each once."""
        return list({(port := self.variable(kind, reference).port).name: port for reference in references}.values())

    def indices(self, kind: Kind, references: Sequence[int]) -> Indices:
        """Return the indices of references in the kind's buffer: a slice if they are contiguous, which is faster."""
        places = self.places(kind, references)
        first = places[0]
        if places == list(range(first, first + len(places))):
            return slice(first, first + len(places))
        return np.array(places, dtype=np.intp)

    def places(self, kind: Kind, references: Sequence[int]) -> list[int]:
        """Return the positions of references in the kind's buffer."""
        return [self.variable(kind, reference).place for reference in references]

    def reader(self, kind: Kind, references: Sequence[int]) -> Callable[[], list[Any]]:
        """Return a function that lists the values of the references."""
        indices = self.indices(kind, references)
        if kind == "string":
            chosen = self.places(kind, references)
            return lambda: [self.strings[i] for i in chosen]
        array = self.arrays[kind]
        if isinstance(indices, slice):
            return array[indices].tolist
        return lambda: array[indices].tolist()

    def writer(self, kind: Kind, references: Sequence[int]) -> Callable[..., None]:
        """Return a function that writes values, given one by one as arguments, to the references.

        For a run of reals this is `struct.pack_into`: 130 values take 0.9 us, against 2.2 us for an array assignment.
        """
        indices = self.indices(kind, references)
        if kind == "real" and isinstance(indices, slice):
            pack = struct.Struct(f"{len(references)}d").pack_into
            return partial(pack, self.arrays["real"].data.cast("B"), 8 * indices.start)
        chosen = self.places(kind, references)

        def write_numbers(*values: Scalar) -> None:
            self.arrays[kind][indices] = values

        def write_strings(*values: str) -> None:
            for i, value in zip(chosen, values, strict=True):
                self.strings[i] = value

        return write_strings if kind == "string" else write_numbers

    def check_outputs(self) -> None:
        """Refuse a non-finite output by name. Products with zero find one in a third of a microsecond."""
        try:
            if self._outputs.dot(self._zeros) == 0.0:
                return
        except (RuntimeWarning, FloatingPointError):  # infinity times zero, in a host that makes warnings errors
            pass
        raise Refused(f"output {self.first_non_finite('output')} is not finite")

    def first_non_finite(self, causality: str) -> str | None:
        """Name the first real input, output or parameter that is not finite, with its value."""
        assert causality in CAUSALITIES
        for variable in self._variables["real"]:
            value = self.arrays["real"][variable.place]
            if variable.port.causality == causality and not np.isfinite(value):
                return f"{variable.name} = {value}"
        return None

    def poison(self) -> None:
        """Make every real output not-a-number, so that it is not mistaken for a result."""
        self._outputs[:] = np.nan

    def parameter_bytes(self) -> bytes:
        """Return all that decides how a model starts, to be compared."""
        return b"".join(part.tobytes() for part in self._parameters) + repr(self.strings).encode()

    def saved(self) -> dict[str, AnyArray]:
        """Return all values by kind, to be saved; strings as UTF-8, each ended by a zero byte."""
        texts = b"".join(text.encode("utf-8", "replace") + b"\0" for text in self.strings)
        arrays: dict[str, AnyArray] = {str(kind): array for kind, array in self.arrays.items()}
        return arrays | {"string": np.frombuffer(texts, dtype=np.uint8)}

    def check_saved(self, saved: Mapping[str, AnyArray]) -> None:
        """Refuse saved values of other ports, and any that a host could not have set.

        Outputs are not examined: those of a failed instance are not-a-number.

        Raises
        ------
        ValueError
            If a kind is missing, or has another number of values or another type; or by the name of a variable.
        """
        counts = {"string": (len(_texts(saved)), len(self.strings))}
        for kind, array in self.arrays.items():
            if kind not in saved or saved[kind].dtype != array.dtype:
                raise ValueError(f"the saved state lacks the {kind} values of the ports")
            counts[kind] = (saved[kind].size, array.size)
        for name, (found, needed) in counts.items():
            if found != needed:
                raise ValueError(f"the saved state has {found} {name} values, this component {needed}")
        for number, (lowest, highest) in self._ranges.items():
            given = saved[number].reshape(-1)
            wrong = np.flatnonzero(~((given >= lowest) & (given <= highest)))  # the negation also finds NaN
            for variable in (self._variables[number][i] for i in wrong):
                if variable.port.causality != "output":
                    objection = variable.port.objection(given[variable.place].item())
                    raise ValueError(f"{variable.name} {objection} in the saved state")

    def restore(self, saved: Mapping[str, AnyArray]) -> None:
        """Write saved values back, in place; `check_saved` has found no fault in them."""
        for kind, array in self.arrays.items():
            np.copyto(array, saved[kind].reshape(-1))
        self.strings[:] = _texts(saved)


def _texts(saved: Mapping[str, AnyArray]) -> list[str]:
    return bytes(saved.get("string", np.empty(0, np.uint8))).decode("utf-8").split("\0")[:-1]


def _limits(variables: Sequence[Variable]) -> tuple[AnyArray, AnyArray]:
    """Return the least and the greatest value of each variable; finite, so that infinity lies outside."""
    ports = [variable.port for variable in variables]
    greatest = np.finfo(np.float64).max
    lowest = np.array([-greatest if port.minimum is None else port.minimum for port in ports])
    return lowest, np.array([greatest if port.maximum is None else port.maximum for port in ports])
