"""The functions that the library of a co-simulation FMU exports, by version of FMI, and those of capability flags."""

from __future__ import annotations

from collections.abc import Mapping

from lockstep.fmi.signatures import NATIVE_TYPES

_TYPES = ("Real", "Integer", "Boolean", "String")
_GET_AND_SET = ("Get", "Set")
_SERIAL = "Serialized{0}Size", "Serialize{0}", "{1}{0}"


def _state(prefix: str, state: str, deserialize: str) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return the functions of the state, and those of the serialised state."""
    held = tuple(f"{prefix}{verb}{state}" for verb in ("Get", "Set", "Free"))
    return held, tuple(f"{prefix}{name.format(state, deserialize)}" for name in _SERIAL)


_STATE2, _SERIAL2 = _state("fmi2", "FMUstate", "DeSerialize")
_STATE3, _SERIAL3 = _state("fmi3", "FMUState", "Deserialize")
_DIRECTIONAL = ("fmi2GetDirectionalDerivative",)
_INTERPOLATION = ("fmi2SetRealInputDerivatives",)
_ASYNCHRONOUS = ("fmi2CancelStep", "fmi2GetStatus", *(f"fmi2Get{kind}Status" for kind in _TYPES))

_FUNCTIONS1 = (
    "GetTypesPlatform", "GetVersion", "SetDebugLogging", "InstantiateSlave", "InitializeSlave", "TerminateSlave",
    "ResetSlave", "FreeSlaveInstance", *(f"{verb}{kind}" for verb in _GET_AND_SET for kind in _TYPES),
    "SetRealInputDerivatives", "GetRealOutputDerivatives", "CancelStep", "DoStep", "GetStatus",
    *(f"Get{kind}Status" for kind in _TYPES),
)  # fmt: skip
# FMI 2.0.5, 2.3: all functions of co-simulation are present, even those of capabilities that the FMU lacks
_FUNCTIONS2 = (
    "fmi2GetTypesPlatform", "fmi2GetVersion", "fmi2SetDebugLogging", "fmi2Instantiate", "fmi2FreeInstance",
    "fmi2SetupExperiment", "fmi2EnterInitializationMode", "fmi2ExitInitializationMode", "fmi2Terminate", "fmi2Reset",
    *(f"fmi2{verb}{kind}" for verb in _GET_AND_SET for kind in _TYPES),
    "fmi2DoStep", "fmi2GetRealOutputDerivatives",
    *_STATE2, *_SERIAL2, *_DIRECTIONAL, *_INTERPOLATION, *_ASYNCHRONOUS,
)  # fmt: skip
_FUNCTIONS3 = (
    *(f"fmi3{name}" for name in (
        "GetVersion", "SetDebugLogging", "InstantiateCoSimulation", "FreeInstance", "EnterInitializationMode",
        "ExitInitializationMode", "Terminate", "Reset", "DoStep",
    )),
    *(f"fmi3{verb}{kind}" for verb in _GET_AND_SET for kind in NATIVE_TYPES),
    *_STATE3, *_SERIAL3,
)  # fmt: skip

_FLAGS2 = {
    "canGetAndSetFMUstate": _STATE2,
    "canSerializeFMUstate": (*_STATE2, *_SERIAL2),
    "providesDirectionalDerivative": _DIRECTIONAL,
    "canInterpolateInputs": _INTERPOLATION,
    "canRunAsynchronuously": _ASYNCHRONOUS,  # FMI spells it so
}
_FLAGS3 = {
    "canGetAndSetFMUstate": _STATE3,
    "canSerializeFMUstate": (*_STATE3, *_SERIAL3),
    "providesDirectionalDerivative": ("fmi3GetDirectionalDerivative",),
    "hasEventMode": ("fmi3EnterEventMode", "fmi3EnterStepMode", "fmi3UpdateDiscreteStates"),
}


def functions_of(version: str, identifier: str) -> tuple[str, ...]:
    """Return the functions that a library has to export."""
    match version:
        case "1.0":
            return tuple(f"{identifier}_fmi{name}" for name in _FUNCTIONS1)
        case "3.0":
            return _FUNCTIONS3
    return _FUNCTIONS2


def functions_of_flags(version: str) -> Mapping[str, tuple[str, ...]]:
    """Return the functions that a capability flag promises, by the flag as FMI 2.0 writes it."""
    return {"1.0": {}, "3.0": _FLAGS3}.get(version, _FLAGS2)
