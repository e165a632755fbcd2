"""Plan a run: everything that is known before any FMU is started."""

from collections.abc import Iterable, Mapping, Sequence

from lockstep.array_names import name_and_arrays
from lockstep.errors import InputError, compact
from lockstep.fmi.model_description import Description
from lockstep.fmi.slave import Scalar
from lockstep.plain_values import plain_value
from lockstep.plan.bus_layout import Layout, Reference
from lockstep.plan.input_files import InputPart, Paths, fed_inputs, open_inputs, read_inputs
from lockstep.plan.overrides import Override
from lockstep.plan.schedule import Schedule, build_schedule, whole_ticks
from lockstep.plan.wiring import Wiring, wire
from lockstep.processes.isolation_policy import settle
from lockstep.results.signal_patterns import Signal, select
from lockstep.shadow.component import check_times, described, recorded, shadow_descriptions, tolerances_of
from lockstep.system.clock import Time, nanoseconds, seconds_text
from lockstep.system.component import Value
from lockstep.system.system import System

DEFAULT_STOP_TIME = 1_000_000_000  # [ns], where neither the file nor the user gives one


class Plan:
    """A checked run: schedule, descriptions, wiring, signals and memory layout. Raises InputError."""

    def __init__(
        self,
        system: System,
        stop_time: float | str | None,
        overrides: Mapping[str, Override],
        record: Sequence[str] | None,
        record_period: float | str | None,
        strict_inputs: bool = False,
        strict: bool = False,
        inputs: Paths = (),
    ) -> None:
        self.system = system
        stop = system.stop_time if stop_time is None else nanoseconds(stop_time, "stop time")
        self.assumed: tuple[str, ...] = ()
        if stop is None:
            span = max(1, DEFAULT_STOP_TIME // system.tick) * system.tick
            stop = system.start_time + span
            self.assumed = (f"no stop time is given: {seconds_text(span)} s are simulated; --stop-time changes it",)
        self.stop_time: Time = stop
        self.ticks = self._whole_ticks(stop)
        self.schedule: Schedule = build_schedule(system)
        self.descriptions = {component.name: described(component) for component in system.components}
        self.shadows = shadow_descriptions(system)
        check_times(system, stop)
        self.tolerances = tolerances_of(system, {**self.descriptions, **self.shadows})
        self.system = system = settle(system, {**self.descriptions, **self.shadows})
        if strict:
            self._refuse_warnings()
        self.input_files = open_inputs(inputs, system, self.descriptions)
        self.wiring: Wiring = wire(system, self.descriptions, overrides, strict_inputs, fed_inputs(self.input_files))
        self.inputs: tuple[InputPart, ...] = read_inputs(self.input_files)
        self.record = _patterns(system.record if record is None else record)
        self.signals: tuple[Signal, ...] = select(system, self.descriptions, self.record)
        period = system.record_period if record_period is None else nanoseconds(record_period, "record period")
        self.layout = Layout(
            schedule=self.schedule,
            links=self.wiring.links,
            recorded=_by_component(signal for signal in self.signals if not signal.held),
            held=_by_component(signal for signal in self.signals if signal.held),
            compared=_compared(system, self.descriptions),
            record_ticks=1 if period is None else whole_ticks(period, system.tick, "record period"),
        )
        self.layout.cycle  # noqa: B018 (refuses a plan that would be too long, before any FMU is started)
        self.names = {
            (name, variable.scalar, variable.reference): variable.name
            for name, description in self.descriptions.items()
            for variable in description.variables.values()
            if variable.scalar is not None and variable.causality in ("output", "input", "calculatedParameter")
        }
        for one in self.signals:  # an output or input may have further names
            if one.variable.scalar is not None:
                self.names.setdefault((one.component, one.variable.scalar, one.variable.reference), one.variable.name)

    def _whole_ticks(self, stop: Time) -> int:
        """Return how many ticks the run has; refuse a stop time that is not after the start, or between two ticks."""
        start, tick = self.system.start_time, self.system.tick
        if not start:
            return whole_ticks(stop, tick, "stop time")
        if stop <= start:
            times = f"stop time {seconds_text(stop)} s: must be after the start time, {seconds_text(start)} s"
            raise InputError(f"{times}; choose a later one")
        return whole_ticks(stop - start, tick, f"stop time {seconds_text(stop)} s: the simulated time of")

    def _refuse_warnings(self) -> None:
        """Raise InputError for the first offence of a file."""
        problems = [text for description in self.descriptions.values() for text in description.problems]
        for text in (*self.system.warnings, *problems):
            raise InputError(f"{text}; with --strict this is an error")

    @property
    def warnings(self) -> tuple[str, ...]:
        """What was amended in the system file or is wrong in an FMU's, and which inputs keep their start values."""
        inputs = [f"{name}.{compact(loose)}" for name, loose in self.wiring.unconnected.items()]
        kept = [f"not connected, and keep their start values: {'; '.join(inputs)}"] if inputs else []
        problems = [text for description in self.descriptions.values() for text in description.problems]
        return (*self.system.warnings, *dict.fromkeys(problems), *self.assumed, *kept)

    def starts(self, name: str) -> dict[Scalar, dict[int, Value]]:
        """Return a component's parameters and start values by type and reference."""
        return self.wiring.starts(name, self.descriptions[name])


def _patterns(record: Sequence[str]) -> tuple[str, ...]:
    """Return what to record: one pattern, or several."""
    patterns = [record] if isinstance(record, str) else plain_value(record, "record")
    if not (isinstance(patterns, list) and all(isinstance(pattern, str) for pattern in patterns)):
        raise InputError(f"record = {record!r} must be a list of texts, for example ['plant.rate']")
    return tuple(patterns)


def _compared(system: System, descriptions: Mapping[str, Description]) -> dict[str, frozenset[Reference]]:
    """Return the outputs of components with shadows by which these are evaluated."""
    found: dict[str, frozenset[Reference]] = {}
    for component in system.components:
        patterns = set(recorded(component))
        variables = descriptions[component.name].variables.values() if patterns else ()
        found[component.name] = frozenset(
            (v.scalar, v.reference)
            for v in variables
            if v.scalar is not None and patterns & set(name_and_arrays(f"{component.name}.{v.name}"))
        )
    return found


def _by_component(signals: Iterable[Signal]) -> dict[str, tuple[Reference, ...]]:
    grouped: dict[str, list[Reference]] = {}
    for signal in signals:
        if signal.variable.scalar is not None:
            grouped.setdefault(signal.component, []).append((signal.variable.scalar, signal.variable.reference))
    return {name: tuple(references) for name, references in grouped.items()}
