"""Get and set values of FMI 3.0: variables are arrays of a dozen types, and each call transfers whole arrays.

To the master every element is one value in one of the types of `lockstep.fmi.slave`, by the reference in
`Variable`. The present values of all elements are kept here, so that some can be set alone.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from ctypes import byref, c_char_p, c_size_t, c_void_p
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lockstep.fmi.instance import BoundCall, Instance
from lockstep.fmi.model_description import Variable
from lockstep.fmi.native_call import Move, described, native
from lockstep.fmi.slave import DTYPES, ERROR, WARNING, Buffer, Scalar
from lockstep.system.component import Value

_NATIVE: Mapping[str, type] = {
    "Float32": np.float32,
    "Float64": np.float64,
    "Int8": np.int8,
    "Int16": np.int16,
    "Int32": np.int32,
    "Int64": np.int64,
    "UInt8": np.uint8,
    "UInt16": np.uint16,
    "UInt32": np.uint32,
    "UInt64": np.uint64,
    "Boolean": np.bool_,
    "String": np.object_,
}
Positions = slice | NDArray[np.intp]


def _function_type(variable: Variable) -> str:
    return "Int64" if variable.native == "Enumeration" else variable.native


@dataclass(frozen=True, slots=True)
class _Part:
    """The elements of one type in a call: their positions in its buffer and in their arrays."""

    kind: str
    positions: Positions  # in the buffer of the call
    handles: NDArray[np.uint32]  # value references of the arrays, in the order of their first element
    elements: NDArray[np.intp]  # in the arrays, laid one after the other
    size: int  # of these together


class Arrays:
    """The values of one instance. `problem` is why a call failed before the FMU was called: a value out of range."""

    def __init__(self, instance: Instance, variables: Iterable[Variable]) -> None:
        self._instance = instance
        self._variables = {v.reference: v for v in variables if v.scalar is not None}
        self._sizes: dict[int, int] = {}
        for variable in self._variables.values():
            self._sizes[variable.array] = max(self._sizes.get(variable.array, 0), variable.element + 1)
        self._kept: list[object] = []  # what the library holds addresses of
        self._places: dict[int, int] = {}  # where each array that can be set begins in the memory of its type
        self._memory = self._settable_memory()
        self.present: dict[int, NDArray[Any]] = {  # what the arrays that can be set hold now, by value reference
            handle: self._memory[_function_type(members[0])][place : place + len(members)]
            for handle, members in self._settable().items()
            for place in (self._places[handle],)
        }
        self.problem = ""
        self.last = ""  # the name of the function that failed last

    def _settable(self) -> dict[int, list[Variable]]:
        found: dict[int, dict[int, Variable]] = {}
        for variable in self._variables.values():
            if variable.settable:
                found.setdefault(variable.array, {})[variable.element] = variable
        return {handle: [members[k] for k in sorted(members)] for handle, members in found.items()}

    def _settable_memory(self) -> dict[str, NDArray[Any]]:
        """Return the start values of all arrays of a type that can be set, one after the other."""
        values: dict[str, list[Value]] = {}
        for handle, members in self._settable().items():
            part = values.setdefault(_function_type(members[0]), [])
            self._places[handle] = len(part)
            part += [start_of(variable) for variable in members]
        return {kind: np.array(part, _NATIVE[kind]) for kind, part in values.items()}

    def getter(self, references: NDArray[np.uint32], buffer: Buffer) -> Callable[[], int]:
        """Return a call that fills the buffer with elements."""
        return _in_turn([self._get(part, buffer) for part in self._parts(references)])

    def setter(self, references: NDArray[np.uint32], buffer: Buffer) -> Callable[[], int]:
        """Return a call that sets elements; the others of their arrays stay what they are."""
        return _in_turn([self._set(part, references, buffer) for part in self._parts(references)])

    def set(self, values: Mapping[int, Value], scalar: Scalar) -> int:
        """Set elements of one type by reference, once."""
        buffer: Buffer = np.array(list(values.values()), DTYPES[scalar])
        return self.setter(np.fromiter(values, np.uint32), buffer)()

    def _parts(self, references: NDArray[np.uint32]) -> list[_Part]:
        """Group elements by type."""
        groups: dict[str, list[int]] = {}
        for position, reference in enumerate(references.tolist()):
            groups.setdefault(_function_type(self._variables[reference]), []).append(position)
        parts = []
        for kind, positions in groups.items():
            members = [self._variables[references[position]] for position in positions]
            begins: dict[int, int] = {}
            size = 0
            for member in members:
                if member.array not in begins:
                    begins[member.array] = size
                    size += self._sizes[member.array]
            elements = [begins[member.array] + member.element for member in members]
            handles, spots = np.array(list(begins), np.uint32), np.array(elements, np.intp)
            parts.append(_Part(kind, _positions(positions), handles, spots, size))
        return parts

    def _get(self, part: _Part, buffer: Buffer) -> Callable[[], int]:
        function = self._bound("Get", part.kind, part.handles)
        positions, elements = part.positions, _positions(part.elements.tolist())
        if part.kind == "String":
            texts = (c_char_p * part.size)()
            address, count = byref(texts), part.size

            def get_texts() -> int:
                status = function(address, count)
                if status <= WARNING:
                    found = np.array([(text or b"").decode("utf-8", "replace") for text in texts], np.object_)
                    buffer[positions] = found[elements]
                return status

            return get_texts
        straight = isinstance(positions, slice) and isinstance(elements, slice) and len(buffer) == part.size
        if straight and buffer.dtype == _NATIVE[part.kind] and buffer.flags.c_contiguous:
            return self._with(function, buffer, f"Get{part.kind}", part)  # already in the order and type of the FMU
        values: NDArray[Any] = np.zeros(part.size, _NATIVE[part.kind])
        call = self._with(function, values, f"Get{part.kind}", part)

        def get() -> int:
            status = call()
            buffer[positions] = values[elements]
            return status

        if not (isinstance(positions, slice) and _movable(buffer, part.kind)):
            return get
        move = Move(source=values, index=part.elements, buffer=buffer[positions])
        return described(get, *(native(call) or ()), move)

    def _set(self, part: _Part, references: NDArray[np.uint32], buffer: Buffer) -> Callable[[], int]:
        function = self._bound("Set", part.kind, part.handles)
        memory, handles = self._memory[part.kind], part.handles.tolist()
        # where the elements of the call lie in the memory of the type, and from there those that are set
        every = np.concatenate([self._places[handle] + np.arange(self._sizes[handle]) for handle in handles])
        target, positions = every[part.elements], part.positions
        names = [self._variables[r].name for r in references[positions].tolist()]
        fit = self._fitting(part.kind, names)
        together = _positions(every.tolist())  # of one array or several neighbours: sent as they lie in the memory
        values: NDArray[Any] = memory[together]
        copied = not isinstance(together, slice)
        send = (
            self._text_sender(function, values)
            if part.kind == "String"
            else self._with(function, values, f"Set{part.kind}", part)
        )

        def put() -> int:
            given = fit(buffer[positions])
            if given is None:
                return ERROR
            memory[target] = given
            if copied:
                values[:] = memory[every]
            return send()

        parts = native(send)
        if parts is None or not (isinstance(positions, slice) and _movable(buffer, part.kind)):
            return put
        scatter = Move(source=buffer[positions], index=target, buffer=memory, scatter=True)
        if not copied:
            return described(put, scatter, *parts)
        if memory.dtype.itemsize == 1:  # there is no such move
            return put
        return described(put, scatter, Move(source=memory, index=every, buffer=values), *parts)

    def _fitting(self, kind: str, names: Sequence[str]) -> Callable[[NDArray[Any]], NDArray[Any] | None]:
        """Return a function that converts values to a type, or notes the problem: no number is changed to fit."""
        native = _NATIVE[kind]
        if kind in ("Float64", "String"):
            return lambda values: values
        if kind == "Boolean":
            return lambda values: np.asarray(values != 0)

        def fit(values: NDArray[Any]) -> NDArray[Any] | None:
            with np.errstate(over="ignore"):
                given: NDArray[Any] = values.astype(native)
            bad = ~np.isfinite(given) if kind == "Float32" else given != values
            if bad.any():
                first = int(np.argmax(bad))
                self.problem = f"cannot set {names[first]}: {values[first]} does not fit into {kind}"
                return None
            return given

        return fit

    def _text_sender(self, function: BoundCall, values: NDArray[Any]) -> Callable[[], int]:
        return lambda: function(byref((c_char_p * len(values))(*(str(text).encode() for text in values))), len(values))

    def _with(self, function: BoundCall, values: NDArray[Any], name: str, part: _Part) -> Callable[[], int]:
        self._kept.append(values)
        address, count = c_void_p(values.ctypes.data), c_size_t(len(values))

        def note(status: int) -> None:
            if status > WARNING:
                self.last = name

        call = self._instance.native(name, "arrays", part.handles, values, note=note)
        return described(lambda: function(address, count), call)

    def _bound(self, verb: str, kind: str, handles: NDArray[np.uint32]) -> BoundCall:
        """Return fmi3Get<kind> or fmi3Set<kind> of these arrays, which then takes address and number of values."""
        self._kept.append(handles)
        name = f"{verb}{kind}"
        # instances of ctypes are passed as they are; Python integers would be converted at each call
        function = self._instance.bind(name, c_void_p(handles.ctypes.data), c_size_t(len(handles)))

        def bound(values: object, count: object) -> int:
            status = function(values, count)
            if status > WARNING:
                self.last = name
            return status

        return bound


def start_of(variable: Variable) -> Value:
    """Return the start value; the model description has one for all that can be set."""
    text = variable.start
    match variable.scalar:
        case "String":
            return text or ""
        case "Boolean":
            return text in ("true", "1")
        case "Real":
            return float(text or 0.0)
    return int(text or 0)


def _positions(indices: Sequence[int]) -> Positions:
    """Return consecutive indices as a slice, which copies nothing, and others as an array."""
    first, count = indices[0], len(indices)
    if list(indices) == list(range(first, first + count)):
        return slice(first, first + count)
    return np.array(indices, np.intp)


def _movable(buffer: Buffer, kind: str) -> bool:
    """Return whether C can copy values between a buffer of the master and one of this type."""
    return bool(buffer.flags.c_contiguous and (buffer.dtype == _NATIVE[kind] or kind == "Boolean"))


def _in_turn(calls: Sequence[Callable[[], int]]) -> Callable[[], int]:
    if len(calls) == 1:
        return calls[0]

    def all_of_them() -> int:
        worst = 0
        for call in calls:
            worst = max(worst, call())
            if worst > WARNING:
                break
        return worst

    parts = [native(call) for call in calls]
    if None in parts:
        return all_of_them
    return described(all_of_them, *(each for part in parts for each in part or ()))
