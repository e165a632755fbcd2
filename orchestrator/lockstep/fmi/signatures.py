"""Signatures of the C functions of FMI 1.0, 2.0 and 3.0, as ctypes needs them; nothing else writes them."""

from collections.abc import Mapping
from ctypes import c_bool, c_char, c_double, c_int, c_size_t, c_void_p

Signature = tuple[type, ...]  # of the arguments behind the instance

_VALUES = (c_void_p, c_size_t, c_void_p)  # value references, their number, values
_ARRAYS = (*_VALUES, c_size_t)  # and the number of values: FMI 3.0 sets and gets arrays
_SCALARS = ("Real", "Integer", "Boolean", "String")
NATIVE_TYPES = (  # of FMI 3.0
    *("Float32", "Float64", "Int8", "Int16", "Int32", "Int64", "UInt8", "UInt16", "UInt32", "UInt64"),
    *("Boolean", "String"),
)
_STATE: Mapping[str, Signature] = {
    "Get{state}": (c_void_p,),
    "Set{state}": (c_void_p,),
    "Free{state}": (c_void_p,),
    "Serialized{state}Size": (c_void_p, c_void_p),
    "Serialize{state}": (c_void_p, c_void_p, c_size_t),
    "{deserialize}{state}": (c_void_p, c_size_t, c_void_p),
}


def _state_functions(state: str, deserialize: str) -> dict[str, Signature]:
    """Return the functions of the state under the spelling of a version: `FMUstate` in 2.0, `FMUState` in 3.0."""
    return {name.format(state=state, deserialize=deserialize): kinds for name, kinds in _STATE.items()}


# by the prefix of a version's functions, and by the name of the function without it
SIGNATURES: Mapping[str, dict[str, Signature]] = {
    "fmi": {
        "InitializeSlave": (c_double, c_char, c_double),
        "DoStep": (c_double, c_double, c_char),
        "TerminateSlave": (),
        "FreeSlaveInstance": (),
        **{f"{verb}{kind}": _VALUES for verb in ("Get", "Set") for kind in _SCALARS},
    },
    "fmi2": {
        "SetupExperiment": (c_int, c_double, c_double, c_int, c_double),
        "EnterInitializationMode": (),
        "ExitInitializationMode": (),
        "DoStep": (c_double, c_double, c_int),
        "GetBooleanStatus": (c_int, c_void_p),
        "GetRealStatus": (c_int, c_void_p),
        "SetDebugLogging": (c_int, c_size_t, c_void_p),
        "Reset": (),
        "Terminate": (),
        "FreeInstance": (),
        **{f"{verb}{kind}": _VALUES for verb in ("Get", "Set") for kind in _SCALARS},
        **_state_functions("FMUstate", "DeSerialize"),
    },
    "fmi3": {
        "EnterInitializationMode": (c_bool, c_double, c_double, c_bool, c_double),
        "ExitInitializationMode": (),
        "DoStep": (c_double, c_double, c_bool, c_void_p, c_void_p, c_void_p, c_void_p),
        "Reset": (),
        "Terminate": (),
        "FreeInstance": (),
        **{f"{verb}{kind}": _ARRAYS for verb in ("Get", "Set") for kind in NATIVE_TYPES},
        **_state_functions("FMUState", "Deserialize"),
    },
}
# functions that only the checks call: an FMU without them runs
OPTIONAL: Mapping[str, dict[str, Signature]] = {
    "fmi": {"ResetSlave": ()},
    "fmi2": {},
    "fmi3": {"SetDebugLogging": (c_bool, c_size_t, c_void_p)},
}
# the calls that end an instance, in their order
ENDINGS = {
    "fmi": ("TerminateSlave", "FreeSlaveInstance"),
    "fmi2": ("Terminate", "FreeInstance"),
    "fmi3": ("Terminate", "FreeInstance"),
}
