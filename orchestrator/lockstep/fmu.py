"""FMI 2.0 co-simulation FMUs: what they declare, and running instances. The only module that imports fmpy."""

import hashlib
import os
from collections import deque
from collections.abc import Callable, Mapping
from contextlib import suppress
from ctypes import byref, c_char_p, c_double, c_int, c_size_t, c_void_p
from dataclasses import dataclass
from functools import partial
from itertools import count
from pathlib import Path
from typing import Any
from weakref import WeakValueDictionary

import fmpy
import numpy as np
from fmpy import fmi2
from fmpy.logging import addLoggerProxy
from fmpy.model_description import read_model_description
from numpy.typing import NDArray

from lockstep.archive import open_file, open_zip
from lockstep.errors import InputError, RunError, compact, siblings, suggestion
from lockstep.slave import DTYPES, ERROR, FATAL, OK, Buffer, Scalar
from lockstep.system import Component, Value
from lockstep.units import BASES, Unit

SSP_SCHEMAS = Path(fmpy.__file__).parent / "ssp" / "schema"
FMI2_SCHEMA = Path(fmpy.__file__).parent / "schema" / "fmi2" / "fmi2ModelDescription.xsd"
PLATFORM = str(fmpy.platform)  # as FMI 2.0 names the folder of its binaries
VERSION = str(fmpy.__version__)

Log = Callable[[str, int, str, str], None]  # component, status, category, message

# fmpy's proxy, which fills in the variadic arguments of a message, knows one logger for the whole process: the
# last one given. So there is one, and it finds the instance by the environment that an FMU hands through.
_instances: WeakValueDictionary[int, "FmuSlave"] = WeakValueDictionary()
_environments = count(1)


@dataclass(frozen=True, slots=True, kw_only=True)
class Variable:
    """What a model description says about one variable."""

    name: str
    reference: int
    type: str
    causality: str
    unit: Unit | None = None
    relative: bool = False  # a difference: the unit's offset does not apply
    minimum: float | None = None
    maximum: float | None = None
    description: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Description:
    """What the master uses of a model description, and the digest of the file it came from."""

    model: str
    guid: str
    identifier: str
    once_per_process: bool
    sha256: str
    variables: Mapping[str, Variable]

    def names(self, *causalities: str) -> list[str]:
        """Return the names of the variables of these causalities, in the order of the file."""
        return [v.name for v in self.variables.values() if v.causality in causalities]

    def lacks(self, component: str, name: str, kind: str) -> str:
        """Say that there is no such variable, and which there are."""
        # an input may be given a start value like a parameter, so both are offered
        kinds = ("parameter", "input") if kind == "parameter" else (kind,)
        names = [found for each in kinds for found in self.names(each)]
        there = compact(siblings(name, names)) + suggestion(name, names)
        return f"{component}.{name}: no such {kind}; {component} has {there}"


def read_description(component: Component) -> Description:
    """Read the FMU of a component, or raise InputError."""
    with open_file(component.source, component.archive, component.name) as stream:
        digest = hashlib.sha256(stream.read()).hexdigest()
        stream.seek(0)
        with open_zip(stream, f"{component.name}: {component.source}") as archive:
            if "modelDescription.xml" not in archive.namelist():
                raise InputError(f"{component.name}: {component.source} is no FMU: it has no modelDescription.xml")
            members = set(archive.namelist())
        stream.seek(0)
        try:
            model = read_model_description(stream)
        except Exception as error:  # fmpy raises bare Exception for whatever is wrong in the XML
            reason = " ".join(str(error).split())
            raise InputError(f"{component.name}: {component.source} has a bad model description: {reason}") from None
    where = f"{component.name}: {component.source}"
    if model.fmiVersion != "2.0" or model.coSimulation is None:
        kind = f"FMI {model.fmiVersion}" + ("" if model.coSimulation else " without co-simulation")
        raise InputError(f"{where} is {kind}; an FMI 2.0 co-simulation FMU is needed")
    identifier = model.coSimulation.modelIdentifier
    if f"binaries/{fmpy.platform}/{identifier}{fmpy.sharedLibraryExtension}" not in members:
        there = sorted({m.split("/")[1] for m in members if m.startswith("binaries/") and m.count("/") > 1})
        raise InputError(f"{where} has no binary for {fmpy.platform}; it has {', '.join(there) or 'none'}")
    units = {unit.name: _unit(unit) for unit in model.unitDefinitions}
    return Description(
        model=model.modelName,
        guid=model.guid,
        identifier=identifier,
        once_per_process=bool(model.coSimulation.canBeInstantiatedOnlyOncePerProcess),
        sha256=digest,
        variables={v.name: _variable(v, units) for v in model.modelVariables},
    )


def validation_problems(path: Path) -> list[str]:
    """Return what FMPy's own validation objects to in an FMU; nothing for a good one."""
    from fmpy.validation import validate_fmu  # here only: it loads a grammar

    return [str(problem) for problem in validate_fmu(str(path))]


def _unit(unit: Any) -> Unit:
    base = unit.baseUnit
    if base is None:
        return Unit(name=unit.name)
    exponents = tuple(int(getattr(base, name)) for name in BASES)
    return Unit(name=unit.name, exponents=exponents, factor=float(base.factor), offset=float(base.offset))


def _variable(variable: Any, units: Mapping[str, Unit]) -> Variable:
    declared = variable.declaredType
    unit = variable.unit or (declared.unit if declared else None)
    minimum, maximum = (_bound(variable, declared, bound) for bound in ("min", "max"))
    return Variable(
        name=variable.name,
        reference=variable.valueReference,
        type=variable.type,
        causality=variable.causality or "local",
        unit=units.get(unit, Unit(name=unit)) if unit else None,
        relative=bool(variable.relativeQuantity or (declared and declared.relativeQuantity)),
        minimum=minimum,
        maximum=maximum,
        description=variable.description or "",
    )


def _bound(variable: Any, declared: Any, name: str) -> float | None:
    text = getattr(variable, name) or (getattr(declared, name) if declared else None)
    return float(text) if text and variable.type in ("Real", "Integer") else None


class FmuSlave:
    """One running instance. Implements `lockstep.slave.Slave` by direct calls into the library."""

    def __init__(self, component: Component, description: Description, folder: Path, log: Log) -> None:
        self.name = component.name
        self._status = 0
        self._alive = self._stepping = False
        self._kept: list[object] = []  # what the library holds addresses of
        self._messages: deque[str] = deque(maxlen=3)
        self._log = log
        with (
            open_file(component.source, component.archive, component.name) as stream,
            open_zip(stream, f"{component.name}: {component.source}") as archive,
        ):
            archive.extractall(folder)
        self._fmu = self._load(description, folder)
        self._instantiate()
        self.do_step: Callable[[float, float, int], int] = partial(
            self._function("fmi2DoStep", c_void_p, c_double, c_double, c_int), self._fmu.component
        )

    def _load(self, description: Description, folder: Path) -> Any:
        directory = Path.cwd()  # fmpy changes it while loading, and does not change it back on failure
        try:
            return fmi2.FMU2Slave(
                guid=description.guid,
                modelIdentifier=description.identifier,
                unzipDirectory=str(folder),
                instanceName=self.name,
            )
        except Exception as error:  # fmpy raises bare Exception, ctypes AttributeError for a missing function
            raise RunError(f"{self.name}: cannot load the FMU: {' '.join(str(error).split())}") from None
        finally:
            os.chdir(directory)

    def _instantiate(self) -> None:
        callbacks = fmi2.fmi2CallbackFunctions()
        callbacks.logger = _LOGGER
        callbacks.allocateMemory = fmi2.fmi2CallbackAllocateMemoryTYPE(fmpy.calloc)
        callbacks.freeMemory = fmi2.fmi2CallbackFreeMemoryTYPE(fmpy.free)
        callbacks.componentEnvironment = next(_environments)
        _instances[callbacks.componentEnvironment] = self
        addLoggerProxy(byref(callbacks))
        try:
            self._fmu.instantiate(callbacks=callbacks, loggingOn=True)
        except Exception:  # a bare Exception; the reason is what the FMU logged
            self._fmu.freeLibrary()
            reason = self.last_messages() or "it logged no reason (a GUID mismatch is one)"
            raise RunError(f"{self.name}: cannot be instantiated: {reason}") from None
        self._alive = True

    def _function(self, name: str, *argument_types: type) -> Callable[..., int]:
        # indexing makes a function object of our own: fmpy's keeps its argument types, which copy buffers
        function = self._fmu.dll[name]
        function.argtypes, function.restype = argument_types, c_int
        return function  # type: ignore[no-any-return]

    def logged(self, status: int, category: str, message: str) -> None:
        """Take a message from the FMU."""
        self._messages.append(" ".join(message.split()))
        self._log(self.name, status, category, message)

    def getter(self, scalar: Scalar, references: NDArray[np.uint32], buffer: Buffer) -> Callable[[], int]:
        """Return fmi2Get<scalar> with its arguments bound."""
        return self._exchange(f"fmi2Get{scalar}", references, buffer)

    def setter(self, scalar: Scalar, references: NDArray[np.uint32], buffer: Buffer) -> Callable[[], int]:
        """Return fmi2Set<scalar> with its arguments bound."""
        return self._exchange(f"fmi2Set{scalar}", references, buffer)

    def _exchange(self, name: str, references: NDArray[np.uint32], buffer: Buffer) -> Callable[[], int]:
        if not (references.flags.c_contiguous and buffer.flags.c_contiguous and len(references) == len(buffer)):
            raise ValueError(f"{self.name}: {name} needs contiguous buffers of one length")
        self._kept += [references, buffer]
        function = self._function(name, c_void_p, c_void_p, c_size_t, c_void_p)
        # instances of the ctypes are handed over as they are; Python integers would be converted at each call
        address, values = c_void_p(references.ctypes.data), c_void_p(buffer.ctypes.data)
        return partial(function, c_void_p(self._fmu.component), address, c_size_t(len(references)), values)

    def set_start(self, values: Mapping[int, Value], scalar: str) -> int:
        """Set parameters and start values of one type by value reference."""
        if scalar == "String":
            references = np.fromiter(values, np.uint32)
            texts = (c_char_p * len(values))(*(str(text).encode() for text in values.values()))
            function = self._function("fmi2SetString", c_void_p, c_void_p, c_size_t, c_void_p)
            return function(self._fmu.component, references.ctypes.data, len(values), byref(texts))
        buffer: Buffer = np.array(list(values.values()), DTYPES[scalar])
        return self._exchange(f"fmi2Set{scalar}", np.fromiter(values, np.uint32), buffer)()

    def setup_experiment(self, start: float, stop: float) -> int:
        """Announce the time span, without a tolerance."""
        return self._call(
            "fmi2SetupExperiment", (c_int, 0), (c_double, 0), (c_double, start), (c_int, 1), (c_double, stop)
        )

    def enter_initialization(self) -> int:
        """Call fmi2EnterInitializationMode."""
        return self._call("fmi2EnterInitializationMode")

    def exit_initialization(self) -> int:
        """Call fmi2ExitInitializationMode."""
        status = self._call("fmi2ExitInitializationMode")
        self._stepping = status < ERROR
        return status

    def _call(self, name: str, *arguments: tuple[type, float]) -> int:
        function = self._function(name, c_void_p, *(kind for kind, _ in arguments))
        return function(self._fmu.component, *(value for _, value in arguments))

    def failed(self, status: int) -> None:
        """Note the status that ended the run."""
        self._status = max(self._status, status)

    def last_messages(self) -> str:
        """Return what the FMU logged last above fmi2OK."""
        return " | ".join(self._messages)

    def close(self) -> None:
        """Terminate unless the instance failed or never began, free it unless the failure was fatal, unload."""
        if not self._alive:
            return
        self._alive = False
        if self._status >= FATAL:
            return  # no call is allowed any more; not even unloading is safe
        if self._stepping and self._status < ERROR:
            self._status = max(self._status, self._call("fmi2Terminate"))
        if self._status < FATAL:
            self._fmu.freeInstance()


def _logged(environment: int | None, name: bytes, status: int, category: bytes, message: bytes) -> None:
    if status == OK:
        return
    with suppress(Exception):  # nothing may be raised into C
        slave = _instances.get(environment or 0)
        if slave is None:  # an FMU that does not hand the environment through
            slave = next(slave for slave in _instances.values() if slave.name.encode() == name)
        slave.logged(status, (category or b"").decode("utf-8", "replace"), message.decode("utf-8", "replace").strip())


_LOGGER = fmi2.fmi2CallbackLoggerTYPE(_logged)
