"""Save the state of an FMU in a file and restore it, by the functions that FMI 2.0 and 3.0 have for it."""

from __future__ import annotations

from ctypes import byref, c_size_t, c_void_p, create_string_buffer
from pathlib import Path

from lockstep.fmi.instance import Instance
from lockstep.fmi.slave import ERROR, WARNING

FILE = "fmu"


def spelled(instance: Instance) -> tuple[str, str]:
    """Return how a version of FMI spells the state and its restoring: FMI 3.0 writes FMUState, 2.0 FMUstate."""
    return ("FMUState", "Deserialize") if instance.prefix == "fmi3" else ("FMUstate", "DeSerialize")


def serialise_state(instance: Instance, state: c_void_p) -> tuple[int, bytes]:
    """Return a state that the FMU holds as bytes, and the worst status; without bytes if that is above WARNING."""
    name, _ = spelled(instance)
    size = c_size_t()
    status = instance.call(f"Serialized{name}Size", state, byref(size))
    if status > WARNING:
        return status, b""
    buffer = create_string_buffer(max(1, size.value))
    status = max(status, instance.call(f"Serialize{name}", state, buffer, size))
    return status, buffer.raw[: size.value] if status <= WARNING else b""


def deserialise_state(instance: Instance, content: bytes) -> tuple[int, c_void_p]:
    """Have the FMU make a state of bytes; return the status and the state, which has to be freed."""
    name, deserialise = spelled(instance)
    buffer, state = create_string_buffer(content, max(1, len(content))), c_void_p()
    status = instance.call(f"{deserialise}{name}", buffer, c_size_t(len(content)), byref(state))
    return status, state


def state_bytes(instance: Instance) -> tuple[int, bytes]:
    """Return the worst status and the instance's state, without bytes if it is above WARNING."""
    name, _ = spelled(instance)
    state = c_void_p()
    status = instance.call(f"Get{name}", byref(state))
    if status > WARNING:
        return status, b""
    serialised, content = serialise_state(instance, state)
    status = max(status, serialised)
    if status <= ERROR:
        status = max(status, instance.call(f"Free{name}", byref(state)))
    return status, content


def save_state(instance: Instance, folder: str) -> int:
    """Serialise the instance's state into a folder; return the worst status."""
    status, content = state_bytes(instance)
    if status <= WARNING:
        Path(folder, FILE).write_bytes(content)
    return status


def restore_state(instance: Instance, folder: str) -> int:
    """Put the instance into the state that a folder holds; return the worst status."""
    return restore_bytes(instance, Path(folder, FILE).read_bytes())


def restore_bytes(instance: Instance, content: bytes) -> int:
    """Put the instance into a state that `state_bytes` returned; return the worst status."""
    name, _ = spelled(instance)
    status, state = deserialise_state(instance, content)
    if status > WARNING:
        return status
    status = max(status, instance.call(f"Set{name}", state))
    if status <= ERROR:
        status = max(status, instance.call(f"Free{name}", byref(state)))
    return status
