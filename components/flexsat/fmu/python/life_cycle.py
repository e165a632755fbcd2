"""Run a component as an FMI 2.0 co-simulation slave: the one class between pythonfmu and the final shells.

The wrapper of pythonfmu 0.7 returns fmi2OK from every call, or fmi2Fatal if it raises, and then the instance's memory
is freed twice. So no method raises. A refused call is logged at once and noted in memory that the shim reads, which
returns fmi2Error in place of the wrapper. From then on real outputs read not-a-number, and no call reaches the model.
`fmi2Reset`, or setting a saved state, makes the instance usable again.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Mapping, Sequence
from math import nan
from pathlib import Path
from typing import Any, ClassVar, TypeVar
from xml.etree.ElementTree import Element

from pythonfmu import Fmi2Slave
from pythonfmu._version import __version__ as pythonfmu_version
from pythonfmu.enums import Fmi2Status

from ...ports.table import Kind, Naming, Port, PortTable
from .access_plans import AccessPlans
from .call_order import Phase, check_order
from .communication_points import CommunicationPoints
from .host_log import log_text, printf_safe, reason_of
from .model_description import about_component, model_description
from .port_values import AnyArray, PortValues, Refused
from .resources import build_facts, finalise_at_exit, find_resource, remove_from_search_path
from .saved_life_cycle import SavedLifeCycle
from .saved_state import ModelState, pack_state, prefixed, section, unpack_state
from .shared_buffers import BUFFERS_REFERENCE, REFUSAL_REFERENCE, SharedBuffers

Prepared = TypeVar("Prepared")


class ComponentSlave(ModelState, Fmi2Slave):  # type: ignore[misc]  # pythonfmu ships no type information
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
    fixed_order = False  # whether sums are to be the same bits on every processor
    fixed_step: float | None = None  # [s] the only step accepted; None accepts any
    equal_steps: ClassVar[bool] = False  # where any step is accepted: whether all have to be as long as the first
    step_parameter: ClassVar[str | None] = None  # parameter that sets it, if one does
    log_categories: ClassVar[dict[str, str]] = {  # the only category that is logged; the wrapper refuses others
        "logStatusError": "why a call failed, with the traceback if the model raised; the instance then stops"
    }

    def __init__(self, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self._failure: str | None = None
        if "logger" not in kwargs:  # a build or a test
            self._make()
            return
        try:  # raising would crash the host in a reset
            remove_from_search_path(self.resources)
            finalise_at_exit(self.resources)
            self._make()
        except BaseException as error:
            self._failure = reason_of("instantiate", error, brief=False)
            text = log_text("instantiate", error, isinstance(error, ValueError))
            self.log(printf_safe(text), Fmi2Status.error, "logStatusError")

    def _make(self) -> None:
        self._build = build = build_facts(self.resources)
        self.modelName = str(build.get("model_name", type(self).__name__))
        self.guid = str(build.get("guid", type(self).__qualname__))
        naming: Naming = "flat" if build.get("naming") == "flat" else "structured"
        self.table = PortTable(self.ports(), naming)
        self.values = PortValues(self.table)
        self._starting = {port.name for port in self.table if self.table.starts_from(port)}
        self._feeds_on_demand = any(port.on_demand and port.depends_on for port in self.table)
        self._follows = any(port.follows_inputs for port in self.table)
        self._buffers = SharedBuffers(self.values, self._feeds_on_demand)
        self._plans, self._points = AccessPlans(), CommunicationPoints()
        self._set_by = self.step_parameter and f"parameter {self.step_parameter}"
        self._first = self.first_step if self.equal_steps else None
        self._started = False  # whether `start` has run with the present parameters and inputs
        self._ready: bytes | None = None  # of a state before `start`: the parameters that it ran with last
        self._stale = False  # whether the outputs on demand are older than the state
        self._enter(Phase.INSTANTIATED)

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

    def first_step(self, step: float) -> None:
        """Prepare for steps of this length [s], where they are equal; raise ValueError if none can be made."""

    def evaluate(self) -> None:
        """Compute the outputs on demand from the present state."""

    def follow_inputs(self) -> None:
        """Compute the outputs that follow inputs from the present state and inputs."""

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
        """Accept an experiment."""
        self._attempt("setupExperiment", self._points.set_up, start_time, stop_time, tolerance)

    def enter_initialization_mode(self) -> None:
        """Begin initialisation."""
        self._attempt("enterInitializationMode", self._begin_initialisation)

    def exit_initialization_mode(self) -> None:
        """Start the model; from here on parameters are fixed."""
        self._attempt("exitInitializationMode", self._end_initialisation)

    def do_step(self, current_time: float, step_size: float) -> bool:
        """Advance the model, or log why not and return false."""
        try:
            if self._phase is not Phase.STEPPING:
                check_order("doStep", self._phase, self._failure)
            length = self._points.admit(current_time, step_size, self.fixed_step, self._set_by, self._first)
            self._stale = True
            self.advance(current_time, length)
            self.values.check_outputs()
            self._buffers.note_inputs(False)
            self._points.advance(current_time, step_size)
            return True
        except BaseException as error:
            self._fail(f"doStep at t = {current_time!r} s", error)
            return False

    def terminate(self) -> None:
        """End the run; values can still be read."""
        self._attempt("terminate", self._enter, Phase.TERMINATED)

    # Values, called by the wrapper with fresh lists: the methods for reals are the hot path where no shim copies them.

    def get_real(self, vrs: list[int]) -> list[float]:
        """Read reals."""
        try:
            plan = self._plans.reads.get((vrs[0], len(vrs))) if vrs else None
            if plan is None or plan[0] != vrs:
                return self._read("real", vrs)
            if plan[2] and self._stale:
                self._evaluate()
            if self._follows and self._buffers.inputs_set:
                self._follow()
            return plan[1]()
        except BaseException as error:
            self._fail("getReal", error)
            return [nan] * len(vrs)

    def set_real(self, vrs: list[int], values: list[float]) -> None:
        """Write reals."""
        try:
            plan = self._plans.writes.get((vrs[0], len(vrs))) if vrs else None
            if plan is None or plan[0] != vrs or not plan[2](values):
                self._write("real", vrs, values)
                return
            plan[1](*values)
            self._buffers.note_inputs(True)
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
            made = hasattr(self, "_points")
            return [self._buffers.layout(str(self.guid), self._points.address) if made else ""]
        return [text.encode("utf-8", "replace").decode() for text in self._read_or("string", vrs, "")]

    def set_integer(self, vrs: list[int], values: list[int]) -> None:
        """Write integers."""
        self._write_or_fail("integer", vrs, values)

    def set_boolean(self, vrs: list[int], values: list[bool]) -> None:
        """Write booleans."""
        self._write_or_fail("boolean", vrs, values)

    def set_string(self, vrs: list[int], values: list[str]) -> None:
        """Write strings; the shim writes what it refuses to one that is no variable."""
        if vrs == [REFUSAL_REFERENCE]:
            call, _, reason = values[0].partition(": ")
            self._fail(call, Refused(reason))
            return
        self._write_or_fail("string", vrs, values)

    # State: bytes from the start, so that restoring it here and in a new process is the same.

    def _get_fmu_state(self) -> bytes:
        try:
            life_cycle = SavedLifeCycle(
                phase=self._phase, experiment=self._points.defined, time=self._points.present, step=self._points.length,
                started=self._started, stale=self._stale, inputs_set=self._buffers.inputs_set)  # fmt: skip
            values = prefixed(life_cycle.values(), "life_cycle") | prefixed(self.values.saved(), "ports")
            return pack_state(str(self.guid), values | prefixed(self.saved_state(), "state"))
        except BaseException as error:
            self._fail("getFMUstate", error)
            return b""

    def _set_fmu_state(self, state: bytes) -> None:
        call = "deSerializeFMUstate" if self._buffers.checking else "setFMUstate"
        try:
            saved = unpack_state(str(self.guid), state)
            then, ports = SavedLifeCycle.read(section(saved, "life_cycle")), section(saved, "ports")
            self.values.check_saved(ports)
            if not self._buffers.checking:
                self._restore(ports, section(saved, "state"), started=then.started)
                self._points.restore(then.time, then.experiment, then.step)
                if then.step:
                    self.first_step(then.step)
                self._started, self._stale = then.started, then.stale
                self._buffers.note_inputs(then.inputs_set)
                self._failure = None if then.phase is not Phase.FAILED else "the state was saved after an error"
                self._enter(then.phase)
        except BaseException as error:
            self._fail(call, Refused(str(error)) if isinstance(error, ValueError) else error)

    def _restore(self, ports: Mapping[str, AnyArray], state: Mapping[str, AnyArray], *, started: bool) -> None:
        before = self.values.parameter_bytes() if self._started else self._ready
        self._started, self._ready = False, None  # until all of it is restored
        self.values.restore(ports)
        if started and before != self.values.parameter_bytes():
            self.start()
            self.values.restore(ports)
        if started:
            self.restore_state(state)
        self._ready = None if started else before

    @staticmethod
    def _fmu_state_to_bytes(state: bytes) -> bytes:
        return state

    @staticmethod
    def _fmu_state_from_bytes(state: bytes) -> bytes:
        return state  # checked when it is set: raising here would be fatal

    def to_xml(self, model_options: dict[str, str] | None = None) -> Element:
        """Write the model description."""
        assert not model_options, "options are class attributes of the shell"
        return model_description(self.table, about_component(self, self._build, f"PythonFMU {pythonfmu_version}"))

    # Inside.

    def _enter(self, phase: Phase) -> None:
        self._phase = phase
        self._plans.clear()
        self._buffers.enter(phase)

    def _attempt(self, call: str, action: Callable[..., None], *arguments: object) -> None:
        """Do what a call asks for, unless it is out of order; report what that raises."""
        try:
            check_order(call, self._phase, self._failure)
            action(*arguments)
        except BaseException as error:
            self._fail(call, error)

    def _begin_initialisation(self) -> None:
        self._points.check_defined()
        self._enter(Phase.INITIALIZING)

    def _end_initialisation(self) -> None:
        self._prepare()
        self._enter(Phase.STEPPING)

    def _prepare(self) -> None:
        """Run `start` unless it has run with the present parameters and inputs."""
        if not self._started:
            self._ready = None
            self.start()
            self._buffers.note_inputs(True)
            self._started, self._stale = True, True
            self.values.check_outputs()

    def _evaluate(self) -> None:
        self.evaluate()
        self._stale = False
        self.values.check_outputs()

    def _follow(self) -> None:
        self.follow_inputs()
        self._buffers.note_inputs(False)
        self.values.check_outputs()

    def _read(self, kind: Kind, vrs: list[int]) -> list[Any]:
        check_order("get", self._phase, self._failure)
        if not vrs:
            return []
        reader = self.values.reader(kind, vrs)
        ports = self.values.ports(kind, vrs)
        if self._failure is None:
            if self._phase is Phase.INITIALIZING and any(port.causality == "output" for port in ports):
                self._prepare()
            on_demand = any(port.on_demand for port in ports)
            if on_demand and self._stale and self._started:
                self._evaluate()
            if self._started and self._buffers.inputs_set and any(port.follows_inputs for port in ports):
                self._follow()
            if self._phase is Phase.STEPPING:
                self._plans.keep_read(kind, vrs, reader, on_demand)
        return reader()

    def _write(self, kind: Kind, vrs: list[int], values: Sequence[Any]) -> None:
        check_order("set", self._phase, self._failure)
        if not vrs:
            return
        writer = self.values.writer(kind, vrs)
        running = self._phase is Phase.STEPPING
        for reference, value in zip(vrs, values, strict=True):
            self.values.admit(kind, reference, value, parameters=not running)
        writer(*values)
        self._buffers.note_inputs(True)
        ports = self.values.ports(kind, vrs)
        if running:
            self._stale |= self._feeds_on_demand
            if any(port.variability == "tunable" for port in ports):
                self.tuned()
            else:
                self._plans.keep_write(kind, vrs, writer, self.values.admits(kind, vrs), self._feeds_on_demand)
        elif any(port.name in self._starting for port in ports):
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
            self.values.poison()
        self._started &= isinstance(error, Refused)  # else the model is in an unknown state
        self._enter(Phase.FAILED)
        self._buffers.fail(Fmi2Status.error)
        self.log(printf_safe(log_text(call, error, brief)), Fmi2Status.error, "logStatusError")
