"""Read any variable of a run between two ticks by name, and set free inputs and tunable parameters."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NoReturn

import numpy as np
from numpy.typing import NDArray

from lockstep.array_names import array_of, elements_of, grid_axes, split_element
from lockstep.errors import InputError, compact, suggestion
from lockstep.fmi.model_description import Variable
from lockstep.fmi.parameter_values import parse_value
from lockstep.fmi.slave import DTYPES, Buffer, Scalar, Slave
from lockstep.plan.overrides import Override, resolve_overrides
from lockstep.plan.plan import Plan
from lockstep.run.exchange import Exchange
from lockstep.run.overlapped_steps import Overlapping
from lockstep.system.component import Component, Value

_LARGEST = sys.float_info.max

Read = Callable[[], Any]


class Values:
    """The variables of all components by `component.variable`, an array of them by its name."""

    def __init__(self, plan: Plan, slaves: Mapping[str, Slave], exchange: Exchange, now: Callable[[], float]) -> None:
        """Read and set nothing yet; `now` returns the simulated time [s]."""
        self._now = now
        self._plan, self._slaves, self._exchange = plan, slaves, exchange
        self._readers: dict[str, Read] = {}
        self._quick: dict[str, _QuickSet | None] = {}
        self._given: dict[str, Value] = {}  # by `component.variable`
        links = plan.layout.links
        self._connected = {(k.consumer, k.target_scalar or k.scalar, target) for k in links for target in k.targets}
        self._fed = {(p.component, p.scalar, reference) for p in plan.inputs for reference in p.references}
        faults = exchange.faults
        self._faulty = frozenset[tuple[str, Scalar, int]]() if faults is None else faults.set_parameters

    def names(self) -> list[str]:
        """Return the names that can be read: of each component its arrays and variables."""
        found: dict[str, None] = {}
        for component, description in self._plan.descriptions.items():
            for name, variable in description.variables.items():
                if variable.scalar is not None:
                    found.setdefault(f"{component}.{array_of(name)}")
                    found.setdefault(f"{component}.{name}")
        return list(found)

    def read(self, name: str) -> Any:
        """Return the present value: a number, a bool, a text, or a numpy array of them; raise InputError."""
        reader = self._readers.get(name)
        if reader is None:
            reader = self._readers[name] = self._reader(name)
        return reader()

    def _reader(self, name: str) -> Read:
        component, variables, single = self._found(name)
        scalar = variables[0].scalar
        if scalar is None or any(variable.scalar != scalar for variable in variables):
            raise InputError(f"{name}: values of type {variables[0].type} cannot be read")
        if component.adapter is not None and variables[0].causality == "parameter":
            return lambda: self._parameters(component.name, variables, single)
        references = [variable.reference for variable in variables]
        buffer: Buffer = np.zeros(len(references), DTYPES[scalar])
        get = self._slaves[component.name].getter(scalar, np.array(references, np.uint32), buffer)
        check, call, shape = self._exchange.check, f"Get{scalar}", _shape(variables)

        def fetched() -> Buffer:
            status = get()
            if status:
                check(component.name, call, self._now(), status)
            return buffer

        if single and scalar == "Boolean":
            return lambda: bool(fetched()[0])
        if single:
            return lambda: fetched().item()
        if scalar == "Boolean":
            return lambda: (fetched() != 0).reshape(shape)
        return lambda: fetched().reshape(shape).copy()

    def _parameters(self, component: str, variables: Sequence[Variable], single: bool) -> Any:
        """Return parameters behind an adapter, through which no value comes back, as they were given."""
        found: list[Value] = []
        for variable in variables:
            name, given = f"{component}.{variable.name}", self._plan.wiring.parameters[component]
            value = given.get(variable.name, variable.start)
            if value is None:
                raise InputError(f"{name}: has no start value, and no value comes back through an adapter")
            found.append(self._given.get(name, parse_value(value, variable, name)))
        values = np.array(found)
        return values[0].item() if single else values.reshape(_shape(variables))

    def _found(self, name: str) -> tuple[Component, list[Variable], bool]:
        """Return the component, its variables of a name, and whether that is the name of a single one."""
        part, dot, rest = name.partition(".")
        names = [component.name for component in self._plan.system.components]
        if not dot or part not in names:
            near = suggestion(name, self.names()) or suggestion(part, names)
            raise InputError(f"{name}: write component.variable; components are {compact(names)}{near}")
        description = self._plan.descriptions[part]
        elements = [rest] if rest in description.variables else elements_of(rest, description.variables)
        if not elements:
            there = [one for one, variable in description.variables.items() if variable.scalar is not None]
            near = suggestion(rest, dict.fromkeys([*map(array_of, there), *there]))
            raise InputError(f"{name}: no such variable; {part} has {compact(there)}{near}")
        variables = [description.variables[element] for element in elements]
        return self._plan.system.component(part), variables, elements == [rest]

    def set(self, name: str, value: Override) -> None:
        """Set free inputs or tunable parameters, as `--set` does; raise InputError.

        An input keeps its value until it is set again.
        """
        if name not in self._quick:
            self._quick[name] = self._quick_set(name)
        quick = self._quick[name]
        if quick is not None and quick.fits(value):
            status = quick.call()
            if status:
                self._exchange.check(quick.component, "SetReal", self._now(), status)
            return
        by_call: dict[tuple[str, Scalar], dict[int, Value]] = {}
        given: dict[str, Value] = {}
        for component, variable, item in resolve_overrides(name, value, self._plan.system, self._plan.descriptions):
            scalar = self._settable(component, variable)
            by_call.setdefault((component, scalar), {})[variable.reference] = item
            given[f"{component}.{variable.name}"] = item
        for (component, scalar), values in by_call.items():
            status = self._slaves[component].set_start(values, scalar)
            self._exchange.check(component, f"Set{scalar}", self._now(), status)
        self._given |= given

    def _settable(self, component: str, variable: Variable) -> Scalar:
        """Return the type of a variable that can be set while the FMU runs, or raise InputError."""
        scalar, name = variable.scalar, f"{component}.{variable.name}"
        if scalar is None:
            raise InputError(f"{name}: values of type {variable.type} cannot be set")
        key = (component, scalar, variable.reference)
        if key in self._connected:
            self._refuse_connected(component, variable)
        if key in self._fed:
            raise InputError(
                f"{name}: an input file feeds it, so that a value for it has no effect; leave out its column"
            )
        if key in self._faulty:
            raise InputError(f"{name}: a fault sets it; leave out the fault, or set another parameter")
        if variable.causality == "input" or (variable.causality, variable.variability) == ("parameter", "tunable"):
            return scalar
        remedy = f"give it when the run is opened: overrides={{{name!r}: VALUE}}"
        kind = f"{variable.variability} {variable.causality}"
        raise InputError(f"{name}: is a {kind}, which cannot change while the FMU runs; {remedy}")

    def _refuse_connected(self, component: str, variable: Variable) -> NoReturn:
        system = self._plan.system
        sources = [
            f"{c.from_component}.{c.output}"
            for c in system.connections
            if (c.to_component, c.input) == (component, variable.name)
        ]
        by = f"is connected to {sources[0]}" if sources else "is another name of a connected input"
        raise InputError(
            f"{component}.{variable.name}: {by}, so that a value for it has no effect; open the run without that "
            "connection, as System.without(component) does, or inject a fault of kind stuck"
        )

    def _quick_set(self, name: str) -> _QuickSet | None:
        """Return what sets Real inputs of one component from numbers without looking at their names again."""
        if any(name in (one.name, array_of(one.name)) for one in self._plan.system.inputs):
            return None  # a connector of the whole system
        component, variables, _ = self._found(name)
        slave = self._slaves[component.name]
        plain = all((v.scalar, v.type, v.causality) == ("Real", "Real", "input") for v in variables)
        if not plain or isinstance(slave, Overlapping):
            return None
        for variable in variables:
            self._settable(component.name, variable)
        lower = [-_LARGEST if v.minimum is None else v.minimum for v in variables]
        upper = [_LARGEST if v.maximum is None else v.maximum for v in variables]
        buffer = np.zeros(len(variables))
        references = np.array([variable.reference for variable in variables], np.uint32)
        return _QuickSet(
            component=component.name,
            buffer=buffer,
            lower=np.array(lower),
            upper=np.array(upper),
            low=max(lower),
            high=min(upper),
            call=slave.setter("Real", references, buffer),
            shape=_shape(variables),
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class _QuickSet:
    """A bound call that sets some Real inputs to what the buffer holds."""

    component: str
    buffer: NDArray[np.float64]
    lower: NDArray[np.float64]
    upper: NDArray[np.float64]
    low: float  # one value for all lies between this
    high: float  # and this
    call: Callable[[], int]
    shape: tuple[int, ...]

    def fits(self, value: object) -> bool:
        """Fill the buffer with numbers that fit; False for anything else, which is then judged with its name."""
        if isinstance(value, float):  # those of numpy too
            if self.low <= value <= self.high:  # not for what is no number, or infinite
                self.buffer[:] = value
                return True
            return False
        if not (isinstance(value, np.ndarray) and value.dtype == np.float64):
            return False
        if value.shape != self.shape and value.shape != self.buffer.shape:
            return False
        given = value.reshape(-1)
        if ((given >= self.lower) & (given <= self.upper)).all():
            self.buffer[:] = given
            return True
        return False


def _shape(variables: Sequence[Variable]) -> tuple[int, ...]:
    """Return the shape of an array: that of its indices if they fill a grid, else one dimension."""
    axes = grid_axes([split_element(variable.name)[1] for variable in variables])
    return tuple(map(len, axes)) if axes else (len(variables),)
