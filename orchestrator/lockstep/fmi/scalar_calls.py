"""Get and set values of FMI 1.0 and 2.0, where every variable is one number or text, by calls with bound arguments."""

from collections.abc import Callable, Mapping
from ctypes import byref, c_char_p, c_size_t, c_void_p

import numpy as np
from numpy.typing import NDArray

from lockstep.fmi.instance import BoundCall, Instance
from lockstep.fmi.native_call import Move, described
from lockstep.fmi.slave import DTYPES, WARNING, Buffer, Scalar
from lockstep.system.component import Value


class Scalars:
    """The values of one instance of FMI 1.0 or 2.0."""

    def __init__(self, instance: Instance) -> None:
        self._instance = instance
        self._letters = instance.prefix == "fmi"  # FMI 1.0 has its Booleans in one byte each
        self._kept: list[object] = []  # what the library holds addresses of

    def forget(self) -> None:
        """Release the memory of all calls that were bound; none of them may be made any more."""
        self._kept.clear()

    def getter(self, scalar: Scalar, references: NDArray[np.uint32], buffer: Buffer) -> Callable[[], int]:
        """Return the call that gets values of one type by reference."""
        name = f"Get{scalar}"
        call = self._bound(name, references)
        if scalar == "String":
            texts = (c_char_p * len(references))()

            def get() -> int:
                status = call(byref(texts))
                if status <= WARNING:
                    buffer[:] = [(text or b"").decode("utf-8", "replace") for text in texts]
                return status

            return get
        if scalar == "Boolean" and self._letters:
            letters = np.zeros(len(references), np.uint8)

            def get_letters() -> int:
                status = call(letters.ctypes.data)
                buffer[:] = letters
                return status

            every = np.arange(len(letters))
            fetch = self._instance.native(name, "values", np.ascontiguousarray(references), letters)
            return described(get_letters, fetch, Move(source=letters, index=every, buffer=buffer))
        return self._in_place(name, references, buffer)

    def setter(self, scalar: Scalar, references: NDArray[np.uint32], buffer: Buffer) -> Callable[[], int]:
        """Return the call that sets values of one type by reference."""
        name = f"Set{scalar}"
        call = self._bound(name, references)
        if scalar == "String":
            return lambda: call(byref((c_char_p * len(references))(*(str(text).encode() for text in buffer))))
        if scalar == "Boolean" and self._letters:
            letters = np.zeros(len(references), np.uint8)

            def set_letters() -> int:
                letters[:] = buffer != 0
                return call(letters.ctypes.data)

            every = np.arange(len(letters))
            send = self._instance.native(name, "values", np.ascontiguousarray(references), letters)
            return described(set_letters, Move(source=buffer, index=every, buffer=letters, scatter=True), send)
        return self._in_place(name, references, buffer)

    def set(self, values: Mapping[int, Value], scalar: Scalar) -> int:
        """Set values of one type by reference, once."""
        buffer: Buffer = np.array(list(values.values()), DTYPES[scalar])
        return self.setter(scalar, np.fromiter(values, np.uint32), buffer)()

    def _in_place(self, name: str, references: NDArray[np.uint32], buffer: Buffer) -> Callable[[], int]:
        """Bind the buffer too: the library reads and writes its memory."""
        if not (buffer.flags.c_contiguous and len(references) == len(buffer)):
            raise ValueError(f"{self._instance.prefix}{name} needs a contiguous buffer of {len(references)} values")
        self._kept.append(buffer)
        references = np.ascontiguousarray(references)
        call = self._bound(name, references, c_void_p(buffer.ctypes.data))
        return described(call, self._instance.native(name, "values", references, buffer))

    def _bound(self, name: str, references: NDArray[np.uint32], *more: object) -> BoundCall:
        references = np.ascontiguousarray(references)
        self._kept.append(references)
        # instances of ctypes are passed as they are; Python integers would be converted at each call
        return self._instance.bind(name, c_void_p(references.ctypes.data), c_size_t(len(references)), *more)
