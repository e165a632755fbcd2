"""Declare a component's ports once, for the shell, the model description and the documentation."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Literal

from .units import unit_of

Causality = Literal["input", "output", "parameter"]
Kind = Literal["real", "integer", "boolean", "string"]
Variability = Literal["fixed", "tunable", "discrete", "continuous"]
Scalar = float | int | bool | str
Naming = Literal["structured", "flat"]
FmiVersion = Literal["2.0", "3.0"]  # of an FMU: 3.0 has one variable a port, 2.0 one a scalar

CAUSALITIES: tuple[Causality, ...] = ("input", "output", "parameter")  # also the order of the value references
KINDS: tuple[Kind, ...] = ("real", "integer", "boolean", "string")
ELEMENTWISE = "[i]"  # suffix of a dependency: element i depends on element i alone

_NAME = re.compile(r"[A-Za-z_]\w*(\.[A-Za-z_]\w*)*", re.ASCII)
_ZERO: dict[Kind, Scalar] = {"real": 0.0, "integer": 0, "boolean": False, "string": ""}
_TYPES: dict[Kind, tuple[type, ...]] = {"real": (float, int), "integer": (int,), "boolean": (bool,), "string": (str,)}


@dataclass(frozen=True, slots=True, kw_only=True)
class Port:
    """One named quantity of a component's interface: a scalar, or an array whose elements are numbered from 1.

    Attributes
    ----------
    size : None for a scalar, else the number of elements
    start : value before initialisation, or one per element (inputs and parameters only)
    variability : None chooses fixed for a parameter, continuous for a real, discrete otherwise; a tunable parameter may
        be set during a run
    depends_on : inputs that feed through to this output; "name[i]" when element i depends on element i alone
    initial_depends_on : what an output's initial value depends on; None means all parameters and no input
    on_demand : an output that is computed only when it is read
    follows_inputs : an output that is computed again if it is read after inputs were set, without a step
    frame : frame the quantity is expressed in, written in the description
    display_unit : unit that tools should show
    period_parameter : the parameter that sets how often an output changes; None for every step of the component
    """

    name: str
    causality: Causality
    unit: str = "1"
    description: str
    size: int | None = None
    start: Scalar | tuple[Scalar, ...] | None = None
    kind: Kind = "real"
    variability: Variability | None = None
    depends_on: tuple[str, ...] = ()
    initial_depends_on: tuple[str, ...] | None = None
    on_demand: bool = False
    follows_inputs: bool = False
    minimum: float | None = None
    maximum: float | None = None
    frame: str | None = None
    display_unit: str | None = None
    period_parameter: str | None = None

    def __post_init__(self) -> None:
        if not _NAME.fullmatch(self.name):
            raise ValueError(f"port {self.name!r}: not a structured FMI name such as 'wheel.torque'")
        for what, value, accepted in (("causality", self.causality, CAUSALITIES), ("kind", self.kind, KINDS)):
            if value not in accepted:
                raise ValueError(f"port {self.name}: {what} must be one of {', '.join(accepted)}, got {value!r}")
        if not self.description.strip():
            raise ValueError(f"port {self.name}: a description is required")
        if self.size is not None and not (type(self.size) is int and self.size >= 1):
            raise ValueError(f"port {self.name}: size must be None or a whole number from 1, got {self.size!r}")
        self._check_unit()
        self._check_variability()
        if self.causality != "output" and (self.depends_on or self.initial_depends_on or self.on_demand):
            raise ValueError(f"port {self.name}: only an output has dependencies or is on demand")
        if self.follows_inputs and (self.on_demand or not self.depends_on):
            raise ValueError(f"port {self.name}: an output that follows inputs depends on some, and is not on demand")
        if self.kind not in ("real", "integer") and not (self.minimum is None and self.maximum is None):
            raise ValueError(f"port {self.name}: only a real or an integer has a minimum or a maximum")
        self._check_start()

    def _check_unit(self) -> None:
        try:
            unit = unit_of(self.unit)
        except ValueError as error:
            raise ValueError(f"port {self.name}: {error}") from None
        if self.kind != "real" and (self.unit != "1" or self.display_unit is not None):
            raise ValueError(f"port {self.name}: only a real has a unit, got {self.unit!r}")
        if self.display_unit is not None and self.display_unit not in unit.display:
            shown = ", ".join(unit.display) or "none"
            raise ValueError(f"port {self.name}: {self.unit} has no display unit {self.display_unit!r}; it has {shown}")

    def _check_variability(self) -> None:
        chosen = self.variability
        if chosen is None:
            chosen = "continuous" if self.kind == "real" else "discrete"
            if self.causality == "parameter":
                chosen = "fixed"
            object.__setattr__(self, "variability", chosen)
        accepted = ("fixed", "tunable") if self.causality == "parameter" else ("discrete", "continuous")
        if chosen not in accepted or (chosen == "continuous" and self.kind != "real"):
            raise ValueError(f"port {self.name}: a {self.kind} {self.causality} cannot be {chosen!r}")

    def _check_start(self) -> None:
        if self.causality == "output":
            if self.start is not None:
                raise ValueError(f"port {self.name}: an output is calculated and has no start value")
            return
        given = _ZERO[self.kind] if self.start is None else self.start
        if isinstance(given, tuple) and self.size is None:
            raise ValueError(f"port {self.name}: a scalar has one start value, got {given!r}")
        values = given if isinstance(given, tuple) else (given,) * self.length
        if len(values) != self.length:
            raise ValueError(f"port {self.name}: {self.length} start values are needed, got {len(values)}")
        for value in values:
            problem = self.objection(value)
            if problem:
                raise ValueError(f"port {self.name}: start {problem}")
        object.__setattr__(self, "start", values if self.size is not None else values[0])

    @property
    def length(self) -> int:
        """Return the number of scalars."""
        return 1 if self.size is None else self.size

    @property
    def limited(self) -> bool:
        """Return whether a minimum or a maximum is declared."""
        return self.minimum is not None or self.maximum is not None

    @property
    def starts(self) -> tuple[Scalar, ...]:
        """Return one value per scalar: the start value, or zero for an output."""
        if self.start is None:
            return (_ZERO[self.kind],) * self.length
        return self.start if isinstance(self.start, tuple) else (self.start,)

    def objection(self, value: object) -> str | None:
        """Return why a value is refused, or None if it is accepted."""
        if not isinstance(value, _TYPES[self.kind]) or (isinstance(value, bool) and self.kind != "boolean"):
            return f"must be {self.kind}, got {value!r}"
        if isinstance(value, (float, int)) and not math.isfinite(value):
            return f"must be finite, got {value!r}"
        if self.minimum is not None and isinstance(value, (float, int)) and value < self.minimum:
            return f"must be >= {self.minimum!r}, got {value!r}"
        if self.maximum is not None and isinstance(value, (float, int)) and value > self.maximum:
            return f"must be <= {self.maximum!r}, got {value!r}"
        return None

    def scalar_name(self, element: int, naming: Naming = "structured") -> str:
        """Return the FMI name of element `element`, counted from 0: `wheel.torque[1]`, or flat `wheel_torque_1`."""
        if naming == "flat":
            name = self.name.replace(".", "_")
            return name if self.size is None else f"{name}_{element + 1}"
        return self.name if self.size is None else f"{self.name}[{element + 1}]"


@dataclass(frozen=True, slots=True, kw_only=True)
class Variable:
    """One FMI scalar variable of a table.

    Attributes
    ----------
    name : in FMI, in the naming of the table
    element : position in the port, from 0
    place : position among the variables of its kind, from 0
    value_reference : in FMI; no two variables of a component have the same, whatever their kinds
    index : position in the model description, from 1
    """

    name: str
    port: Port
    element: int
    place: int
    value_reference: int
    index: int


class PortTable:
    """Number the scalars of some ports: of each kind inputs first, then outputs, then parameters, each port in a run.

    Value references count on from kind to kind, reals first: a host that sets or reads a variable by the function of
    another type gets an error, and not the value of another variable.

    Inputs and outputs come first because CPython shares the integers up to 256: comparing and making
    references is several times quicker there, and they are what is read and written at every step.
    """

    __slots__ = ("_by_name", "_first", "first_reference", "naming", "ports", "variables")

    def __init__(self, ports: Iterable[Port], naming: Naming = "structured") -> None:
        declared = tuple(ports)
        self.naming: Naming = naming
        self.ports = tuple(port for causality in CAUSALITIES for port in declared if port.causality == causality)
        self._by_name = {port.name: port for port in self.ports}
        if len(self._by_name) != len(self.ports):
            twice = next(port.name for port in self.ports if sum(port.name == other.name for other in self.ports) > 1)
            raise ValueError(f"port {twice} is declared twice")
        self._first: dict[str, Variable] = {}
        variables: list[Variable] = []
        counts = dict.fromkeys(KINDS, 0)
        firsts: dict[Kind, int] = {}
        total = 0
        for kind in KINDS:
            firsts[kind] = total
            total += sum(port.length for port in self.ports if port.kind == kind)
        self.first_reference: Mapping[Kind, int] = MappingProxyType(firsts)
        for port in self.ports:
            for element in range(port.length):
                variable = Variable(
                    name=port.scalar_name(element, naming),
                    port=port,
                    element=element,
                    place=counts[port.kind],
                    value_reference=firsts[port.kind] + counts[port.kind],
                    index=len(variables) + 1,
                )
                counts[port.kind] += 1
                variables.append(variable)
                self._first.setdefault(port.name, variable)
        self.variables = tuple(variables)
        self._check_names()
        for port in self.ports:
            self._check_dependencies(port)

    def _check_names(self) -> None:
        """Refuse two variables of one name; flat names may coincide where structured ones do not."""
        seen: dict[str, Variable] = {}
        for variable in self.variables:
            other = seen.setdefault(variable.name, variable)
            if other is not variable:
                raise ValueError(
                    f"ports {other.port.name} and {variable.port.name} both have a variable {variable.name!r}"
                )

    def _check_dependencies(self, port: Port) -> None:
        for name in port.depends_on:
            if self._dependency(port, name).causality != "input":
                raise ValueError(f"port {port.name}: depends_on names {name!r}, which is not an input")
        for name in port.initial_depends_on or ():
            if self._dependency(port, name).causality == "output":
                raise ValueError(f"port {port.name}: initial_depends_on names {name!r}, which is an output")
        period = port.period_parameter
        if period is not None and (period not in self._by_name or self[period].causality != "parameter"):
            raise ValueError(f"port {port.name}: period_parameter names {period!r}, which is no parameter")

    def _dependency(self, port: Port, name: str) -> Port:
        source = self._by_name.get(name.removesuffix(ELEMENTWISE))
        if source is None:
            known = ", ".join(other.name for other in self.ports if other.causality != "output")
            raise ValueError(f"port {port.name}: depends on {name!r}, which is no port here; there are {known}")
        if name.endswith(ELEMENTWISE) and source.size != port.size:
            raise ValueError(f"port {port.name}: {name!r} needs equal sizes, got {port.size} and {source.size}")
        return source

    def __iter__(self) -> Iterator[Port]:
        return iter(self.ports)

    def __getitem__(self, name: str) -> Port:
        try:
            return self._by_name[name]
        except KeyError:
            raise ValueError(f"{name}: no such port; there are {', '.join(self._by_name)}") from None

    def renamed(self, naming: Naming) -> PortTable:
        """Return the same ports in another naming; value references are the same."""
        return PortTable(self.ports, naming)

    def of_kind(self, kind: Kind) -> tuple[Variable, ...]:
        """Return the variables of a kind, by their places."""
        return tuple(variable for variable in self.variables if variable.port.kind == kind)

    def span(self, name: str) -> slice:
        """Return the places of a port's variables among those of its kind."""
        first = self._first[self[name].name].place
        return slice(first, first + self[name].length)

    def array_reference(self, name: str) -> int:
        """Return the value reference of a port in FMI 3.0: counted from kind to kind from 1 on; 0 is the time."""
        port = self[name]
        ordered = [other.name for kind in KINDS for other in self.ports if other.kind == kind]
        return 1 + ordered.index(port.name)

    def array_dependencies(self, port: Port, *, initial: bool) -> tuple[str, ...]:
        """Return the ports that an output (or its initial value) depends on, by the order of the table."""
        first = self._first[port.name].index
        elements = self.variables[first - 1 : first - 1 + port.length]
        indices = {index for v in elements for index in self.dependencies(v, initial=initial)}
        return tuple(dict.fromkeys(self.variables[index - 1].port.name for index in sorted(indices)))

    def run(self, causality: Causality, kind: Kind = "real") -> slice:
        """Return the places of all inputs, outputs or parameters of a kind: one contiguous run."""
        places = [v.place for v in self.of_kind(kind) if v.port.causality == causality]
        return slice(places[0], places[-1] + 1) if places else slice(0, 0)

    def dependencies(self, variable: Variable, *, initial: bool) -> tuple[int, ...]:
        """Return the model-description indices that an output's value (or initial value) depends on."""
        port = variable.port
        names = port.depends_on
        if initial:
            names = port.initial_depends_on if port.initial_depends_on is not None else self._parameters()
            names += port.depends_on if port.follows_inputs else ()
        indices = set()
        for name in names:
            source = self._dependency(port, name)
            first = self._first[source.name].index
            if name.endswith(ELEMENTWISE):
                indices.add(first + variable.element)
            else:
                indices.update(range(first, first + source.length))
        return tuple(sorted(indices))

    def starts_from(self, port: Port) -> bool:
        """Return whether the start of a run depends on a port: a parameter, or an input of some initial value."""
        if port.causality != "input":
            return port.causality == "parameter"
        return any(
            port.name == name.removesuffix(ELEMENTWISE)
            for output in self.ports
            for name in output.initial_depends_on or ()
        )

    def _parameters(self) -> tuple[str, ...]:
        return tuple(port.name for port in self.ports if port.causality == "parameter")
