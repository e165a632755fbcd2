"""Run a component as an FMI 2.0 co-simulation slave: the one class between pythonfmu and the final shells.

The wrapper of pythonfmu 0.7 limits how errors can be reported to the host:

- `do_step` returns true (fmi2OK) or false (fmi2Discard, and fmi2Terminated becomes true);
- every other call is fmi2OK, or fmi2Fatal if it raises, and then the instance's memory is freed twice.

So no method raises. A failed call is logged with status fmi2Error at once; from then on real outputs read
not-a-number and each `do_step` returns fmi2Discard without calling the model. `fmi2Reset`, or setting a saved
state, makes the instance usable again.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from enum import Enum, auto
from math import isfinite, nan
from pathlib import Path
from typing import Any, ClassVar, TypeVar
from xml.etree.ElementTree import Element

import numpy as np
from pythonfmu import Fmi2Slave
from pythonfmu._version import __version__ as pythonfmu_version
from pythonfmu.enums import Fmi2Status

from ...ports.table import Kind, Naming, Port, PortTable
from ...runtime.named_state import named_values, restore_values
from .access_plans import AccessPlans
from .host_log import log_text, printf_safe, reason_of
from .model_description import About, build_date, model_description
from .port_values import AnyArray, PortValues, Refused
from .resources import build_facts, finalise_at_exit, find_resource, remove_from_search_path
from .saved_state import pack_state, prefixed, section, unpack_state
from .shared_buffers import BUFFERS_REFERENCE, SharedBuffers

Prepared = TypeVar("Prepared")

STEP_TOLERANCE = 1e-6  # relative; a host that subtracts times at t = 1e5 s errs by 1e-11 s in its step


class Phase(Enum):
    """State of an instance in the FMI life cycle."""

    INSTANTIATED = auto()
    INITIALIZING = auto()
    STEPPING = auto()
    TERMINATED = auto()


class ComponentSlave(Fmi2Slave):  # type: ignore[misc]  # pythonfmu ships no type information
    """Give a stepper ports and a life cycle. A final class states its ports and calls its stepper.

    A final class implements `ports`, `start` and `advance`, and `evaluate` if it has outputs on demand.
    `self.state` holds everything that changes in a run; `start` computes the rest from parameters and resources.
    """

    description: ClassVar[str] = ""
    author: ClassVar[str] = "flexsat developers"
    license: ClassVar[str] = "BSD-3-Clause"
    version: ClassVar[str] = "0"
    preferred_step: float = 1e-3  # [s] what the model description recommends where any step is accepted
    stop_time: ClassVar[float | None] = None  # [s] end of the default experiment
    fixed_step: float | None = None  # [s] the only step accepted; None accepts any
    step_parameter: ClassVar[str | None] = None  # parameter that sets it, if one does
    log_categories: ClassVar[dict[str, str]] = {  # the only category that is logged; the wrapper refuses others
        "logStatusError": "why a call failed, with the traceback if the model raised; the instance then stops"
    }

    state: Any = None

    def __init__(self, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        if "logger" in kwargs:  # instantiated by the wrapper, not by a build or a test
            remove_from_search_path(self.resources)
        build = build_facts(self.resources)
        self.modelName = str(build.get("model_name", type(self).__name__))
        if "logger" in kwargs:
            finalise_at_exit(self.resources)
        self.guid = str(build.get("guid", type(self).__qualname__))
        self._version = str(build.get("version", type(self).version))
        naming: Naming = "flat" if build.get("naming") == "flat" else "structured"
        self.table = PortTable(self.ports(), naming)
        self.values = PortValues(self.table)
        self._starting = {port.name for port in self.table if self.table.starts_from(port)}
        self._feeds_on_demand = any(port.on_demand and port.depends_on for port in self.table)
        self._buffers = SharedBuffers(self.values, self._feeds_on_demand)
        self._enter(Phase.INSTANTIATED)
        self._started = False  # whether `start` has run with the present parameters and inputs
        self._stale = False  # whether the outputs on demand are older than the state
        self._failure: str | None = None
        self._plans = AccessPlans()

    # What a final class implements.

    @abstractmethod
    def ports(self) -> Sequence[Port]:
        """Return the ports. Resources may be read, parameters not yet."""

    @abstractmethod
    def start(self) -> None:
        """Make `self.state` and the initial outputs; parameters are final. Raise ValueError with a one-line reason.

        May be called again during initialisation, whenever a host reads outputs between changes of parameters.
        """

    @abstractmethod
    def advance(self, time: float, step: float, /) -> None:
        """Step the model from `time` to `time + step` [s], from the input views to the output views."""

    def evaluate(self) -> None:
        """Compute the outputs on demand from the present state."""

    def tuned(self) -> None:
        """Use the present values of tunable parameters, one of which has just changed."""

    # What a final class uses.

    def in_use(self, prepared: Prepared) -> Prepared:
        """Return what the steps use of what was prepared: that itself, or where it is replaced, its equal."""
        return prepared

    def view(self, name: str) -> AnyArray:
        """Return a port's values as a view that stays valid; shape () for a scalar."""
        return self.values.view(name)

    def value(self, name: str) -> Any:
        """Return a port's value as a Python value, or as a copy of its array."""
        return self.values.value(name)

    def resource(self, name: str) -> Path:
        """Return the path of a file that travels in the FMU's resources."""
        return find_resource(self.resources, name)

    # Life cycle, called by the wrapper.

    def setup_experiment(
        self, start_time: float, stop_time: float | None = None, tolerance: float | None = None
    ) -> None:
        """Accept any experiment."""

    def enter_initialization_mode(self) -> None:
        """Begin initialisation."""
        self._enter(Phase.INITIALIZING)

    def exit_initialization_mode(self) -> None:
        """Start the model; from here on parameters are fixed."""
        try:
            if self._failure is not None:
                raise Refused(f"not started since: {self._failure}")
            self._prepare()
            self._enter(Phase.STEPPING)
        except BaseException as error:
            self._fail("exitInitializationMode", error)

    def do_step(self, current_time: float, step_size: float) -> bool:
        """Advance the model, or log why not and return false."""
        try:
            if self._failure is not None or self._phase is not Phase.STEPPING:
                raise Refused("not initialised" if self._failure is None else f"not stepped since: {self._failure}")
            fixed = self.fixed_step
            if fixed is not None:
                if step_size != fixed and not abs(step_size - fixed) <= STEP_TOLERANCE * fixed:
                    remedy = f", set by parameter {self.step_parameter}" if self.step_parameter else ""
                    raise Refused(f"a step of {step_size!r} s is not accepted; the step is {fixed!r} s{remedy}")
                step_size = fixed
            elif not step_size > 0.0:
                raise Refused(f"a step of {step_size!r} s is not accepted; a step is > 0 s")
            self._stale = True
            self.advance(current_time, step_size)
            self.values.check_outputs()
            return True
        except BaseException as error:
            self._fail(f"doStep at t = {current_time!r} s", error)
            return False

    def terminate(self) -> None:
        """End the run; values can still be read."""
        self._enter(Phase.TERMINATED)

    # Values, called by the wrapper with fresh lists at every step: the two methods for reals are the hot path where
    # no shim copies them.

    def get_real(self, vrs: list[int]) -> list[float]:
        """Read reals."""
        try:
            if not vrs:
                return []
            plan = self._plans.reads.get((vrs[0], len(vrs)))
            if plan is None or plan[0] != vrs:
                return self._read("real", vrs)
            if plan[2] and self._stale:
                self._evaluate()
            return plan[1]()
        except BaseException as error:
            self._fail("getReal", error)
            return [nan] * len(vrs)

    def set_real(self, vrs: list[int], values: list[float]) -> None:
        """Write reals."""
        try:
            if not vrs:
                return
            plan = self._plans.writes.get((vrs[0], len(vrs)))
            if plan is None or plan[0] != vrs or not isfinite(sum(values)):
                self._write("real", vrs, values)
                return
            plan[1](*values)
            if self._feeds_on_demand:
                self._stale = True
        except BaseException as error:
            self._fail("setReal", error)

    def get_integer(self, vrs: list[int]) -> list[int]:
        """Read integers."""
        return self._read_or("integer", vrs, 0)

    def get_boolean(self, vrs: list[int]) -> list[bool]:
        """Read booleans."""
        return self._read_or("boolean", vrs, False)

    def get_string(self, vrs: list[int]) -> list[str]:
        """Read strings; the shim asks for one that is no variable."""
        if vrs == [BUFFERS_REFERENCE]:
            return [self._buffers.layout()]
        return self._read_or("string", vrs, "")

    def set_integer(self, vrs: list[int], values: list[int]) -> None:
        """Write integers."""
        self._write_or_fail("integer", vrs, values)

    def set_boolean(self, vrs: list[int], values: list[bool]) -> None:
        """Write booleans."""
        self._write_or_fail("boolean", vrs, values)

    def set_string(self, vrs: list[int], values: list[str]) -> None:
        """Write strings."""
        self._write_or_fail("string", vrs, values)

    # State: bytes from the start, so that restoring it here and in a new process is the same.

    def _get_fmu_state(self) -> bytes:
        try:
            life_cycle = {
                "phase": np.array(self._phase.value),
                "started": np.array(self._started),
                "stale": np.array(self._stale),
            }
            values = prefixed(life_cycle, "life_cycle") | prefixed(self.values.saved(), "ports")
            return pack_state(str(self.guid), values | prefixed(named_values(self.state), "state"))
        except BaseException as error:
            self._fail("getFMUstate", error)
            return b""

    def _set_fmu_state(self, state: bytes) -> None:
        try:
            saved = unpack_state(str(self.guid), state)
            life_cycle, ports = section(saved, "life_cycle"), section(saved, "ports")
            phase, started = Phase(life_cycle["phase"].item()), bool(life_cycle["started"])
            parameters = self.values.parameter_bytes()
            self.values.restore(ports)
            if started and not (
                self._started and self._failure is None and parameters == self.values.parameter_bytes()
            ):
                self.start()
                self.values.restore(ports)
            if started:
                restore_values(self.state, section(saved, "state"))
            self._enter(phase)
            self._started, self._stale = started, bool(life_cycle["stale"])
            self._failure = None
            self._plans.clear()
        except ValueError as error:
            self._fail("setFMUstate", Refused(str(error)))
        except BaseException as error:
            self._fail("setFMUstate", error)

    @staticmethod
    def _fmu_state_to_bytes(state: bytes) -> bytes:
        return state

    @staticmethod
    def _fmu_state_from_bytes(state: bytes) -> bytes:
        return state  # checked when it is set: raising here would be fatal

    def to_xml(self, model_options: dict[str, str] | None = None) -> Element:
        """Write the model description."""
        assert not model_options, "options are class attributes of the shell"
        kind = type(self)
        about = About(
            model_name=self.modelName,
            guid=self.guid,
            description=kind.description,
            version=self._version,
            author=kind.author,
            license=kind.license,
            generation_tool=f"PythonFMU {pythonfmu_version}",
            step_size=self.fixed_step or self.preferred_step,
            any_step=self.fixed_step is None,
            stop_time=kind.stop_time,
            date=build_date(),
            log_categories=self.log_categories,
        )
        return model_description(self.table, about)

    # Inside.

    def _enter(self, phase: Phase) -> None:
        self._phase = phase
        self._buffers.allow(phase in (Phase.STEPPING, Phase.TERMINATED))

    def _prepare(self) -> None:
        """Run `start` unless it has run with the present parameters and inputs."""
        if not self._started:
            self.start()
            self._started, self._stale = True, True
            self.values.check_outputs()

    def _evaluate(self) -> None:
        self.evaluate()
        self._stale = False
        self.values.check_outputs()

    def _read(self, kind: Kind, vrs: list[int]) -> list[Any]:
        if not vrs:
            return []
        reader = self.values.reader(kind, vrs)
        ports = {self.values.variable(kind, reference).port for reference in vrs}
        if self._failure is None:
            if self._phase is Phase.INITIALIZING and any(port.causality == "output" for port in ports):
                self._prepare()
            on_demand = self._on_demand(kind, vrs)
            if on_demand and self._stale and self._started:
                self._evaluate()
            if self._phase is Phase.STEPPING:
                self._plans.keep_read(kind, vrs, reader, on_demand)
        return reader()

    def _write(self, kind: Kind, vrs: list[int], values: Sequence[Any]) -> None:
        if not vrs:
            return
        writer = self.values.writer(kind, vrs)
        running = self._phase in (Phase.STEPPING, Phase.TERMINATED)
        for reference, value in zip(vrs, values, strict=True):
            self.values.admit(kind, reference, value, parameters=not running)
        writer(*values)
        if running:
            self._stale |= self._feeds_on_demand
            ports = [self.values.variable(kind, i).port for i in vrs]
            if any(port.variability == "tunable" for port in ports):
                self.tuned()
            else:
                self._plans.keep_write(kind, vrs, writer, ports, self._feeds_on_demand)
        elif any(port in self._starting for port in {self.values.variable(kind, i).port.name for i in vrs}):
            self._started = False

    def _read_or(self, kind: Kind, vrs: list[int], nothing: Any) -> list[Any]:
        plan = self._plans.flag_reads.get((kind, *vrs))
        if plan is not None:
            return plan()
        try:
            return self._read(kind, vrs)
        except BaseException as error:
            self._fail(f"get{kind.capitalize()}", error)
            return [nothing] * len(vrs)

    def _write_or_fail(self, kind: Kind, vrs: list[int], values: Sequence[Any]) -> None:
        plan = self._plans.flag_writes.get((kind, *vrs))
        if plan is not None:
            plan(*values)
            return
        try:
            self._write(kind, vrs, values)
        except BaseException as error:
            self._fail(f"set{kind.capitalize()}", error)

    def _fail(self, call: str, error: BaseException) -> None:
        """Log an error and stop the instance. Must not raise."""
        brief = isinstance(error, Refused) or (self._phase is Phase.INITIALIZING and isinstance(error, ValueError))
        if self._failure is None:
            self._failure = reason_of(call, error, brief)
            self._plans.clear()
            self.values.poison()
        self._log_error(log_text(call, error, brief))

    def _log_error(self, text: str) -> None:
        self.log(printf_safe(text), Fmi2Status.error, "logStatusError")

    def _on_demand(self, kind: Kind, vrs: Sequence[int]) -> bool:
        return any(self.values.variable(kind, reference).port.on_demand for reference in vrs)
