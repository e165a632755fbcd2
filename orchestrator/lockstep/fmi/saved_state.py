"""The state of an FMU in a file, by the functions that FMI 2.0 and 3.0 have for it."""

from __future__ import annotations

from collections.abc import Callable
from ctypes import byref, c_size_t, c_void_p, create_string_buffer
from pathlib import Path

from lockstep.fmi.slave import ERROR, WARNING

_FILE = "fmu"
_NAMES = {  # get, size, serialise, deserialise, set, free
    "fmi2": ("GetFMUstate", "SerializedFMUstateSize", "SerializeFMUstate", "DeSerializeFMUstate", "SetFMUstate",
             "FreeFMUstate"),
    "fmi3": ("GetFMUState", "SerializedFMUStateSize", "SerializeFMUState", "DeserializeFMUState", "SetFMUState",
             "FreeFMUState"),
}  # fmt: skip

Function = Callable[..., Callable[..., int]]  # a function of the library, by its name and the types of its arguments


def save_state(function: Function, prefix: str, instance: int, folder: str) -> int:
    """Serialise the instance's state into a folder; return the worst status."""
    get, measure, serialise, _, _, free = (f"{prefix}{name}" for name in _NAMES[prefix])
    state, size = c_void_p(), c_size_t()
    status = function(get, c_void_p, c_void_p)(instance, byref(state))
    if status > WARNING:
        return status
    status = max(status, function(measure, c_void_p, c_void_p, c_void_p)(instance, state, byref(size)))
    if status <= WARNING:
        buffer = create_string_buffer(max(1, size.value))
        call = function(serialise, c_void_p, c_void_p, c_void_p, c_size_t)
        status = max(status, call(instance, state, buffer, size))
        if status <= WARNING:
            Path(folder, _FILE).write_bytes(buffer.raw[: size.value])
    if status <= ERROR:
        status = max(status, function(free, c_void_p, c_void_p)(instance, byref(state)))
    return status


def restore_state(function: Function, prefix: str, instance: int, folder: str) -> int:
    """Put the instance into the state that a folder holds; return the worst status."""
    _, _, _, deserialise, put, free = (f"{prefix}{name}" for name in _NAMES[prefix])
    content = Path(folder, _FILE).read_bytes()
    buffer = create_string_buffer(content, max(1, len(content)))
    state = c_void_p()
    call = function(deserialise, c_void_p, c_void_p, c_size_t, c_void_p)
    status = call(instance, buffer, c_size_t(len(content)), byref(state))
    if status > WARNING:
        return status
    status = max(status, function(put, c_void_p, c_void_p)(instance, state))
    if status <= ERROR:
        status = max(status, function(free, c_void_p, c_void_p)(instance, byref(state)))
    return status
