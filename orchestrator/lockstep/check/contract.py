"""Compare an FMU with a contract: the ports that a component of a system must have. Contracts are plain data."""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from lockstep.array_names import array_of
from lockstep.check.static.model import Model, ScalarVariable
from lockstep.errors import InputError
from lockstep.system.units import Unit, conversion, without_radian

ALL_NAMES = 10_000  # for `compact`: names are folded, not cut, in the lists that an integrator works through
_FEW = 3
_NUMERIC = ("Real", "Integer", "Boolean", "Enumeration")


@dataclass(frozen=True, slots=True, kw_only=True)
class ContractPort:
    """One scalar of a contract."""

    name: str  # as FMI variable, such as wheel.torque[1]
    type: str
    causality: str  # as seen from the component: input, output or parameter
    unit: Unit | None = None
    needed: bool = False  # an output that some other component of the system reads


@dataclass(frozen=True, slots=True, kw_only=True)
class Contract:
    """The ports of one component in one variant of a system."""

    component: str
    variant: str
    ports: tuple[ContractPort, ...]

    @property
    def name(self) -> str:
        """Return the name that selects it on the command line."""
        return f"{self.component}:{self.variant}"


@dataclass(frozen=True, slots=True, kw_only=True)
class Served:
    """A port that a variable of the FMU serves, and what an adapter has to do; nothing if none is needed."""

    port: ContractPort
    variable: ScalarVariable
    work: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class ContractMatch:
    """How an FMU serves a contract."""

    contract: Contract
    served: tuple[Served, ...]
    missing: tuple[tuple[ContractPort, str], ...]  # and why, if there is something of that name
    unfed: tuple[ScalarVariable, ...]  # inputs of the FMU that the contract has no port for
    hints: Mapping[str, str]  # missing output: unused outputs of the FMU that agree in number and unit
    offers: Mapping[str, str]  # unfed input of the FMU: missing inputs of the contract that agree in number and unit

    @property
    def served_directly(self) -> tuple[Served, ...]:
        """Ports served without an adapter."""
        return tuple(served for served in self.served if not served.work)

    @property
    def adapted(self) -> tuple[Served, ...]:
        """Ports that need an adapter."""
        return tuple(served for served in self.served if served.work)

    @property
    def likeness(self) -> tuple[float, int, int]:
        """Order contracts by how well an FMU fits: share of the ports that matter, ports served, hints."""
        matter = [port for port in self.contract.ports if port.needed or port.causality == "input"]
        served = sum(s.port.needed or s.port.causality == "input" for s in self.served)
        return served / max(len(matter), 1), len(self.served), len(self.hints)


def compare(contract: Contract, model: Model) -> ContractMatch:
    """Find the variable for every port of a contract: by its name, then by one that is spelt or counted differently."""
    by_name = {variable.name: variable for variable in model.variables}
    spelt = _Spellings(model.variables)
    served, missing = [], []
    for port in contract.ports:
        work: tuple[str, ...] = ()
        # in an array counted from 0 an equal name is another element
        variable = None if spelt.from_zero(port) else by_name.get(port.name)
        if variable is None:
            variable, work = spelt.find(port)
        if variable is None:
            missing.append((port, ""))
            continue
        reason, more = _fit(port, variable, model)
        if reason:
            called = "" if variable.name == port.name else f" (there {re.sub(r'[0-9]+', '*', variable.name)})"
            missing.append((port, reason + called))
        else:
            served.append(Served(port=port, variable=variable, work=(*work, *more)))
    used = {s.variable.name for s in served}
    return ContractMatch(
        contract=contract,
        served=tuple(served),
        missing=tuple(missing),
        unfed=tuple(v for v in model.variables if v.causality == "input" and v.name not in used),
        hints=_few(_alike("output", [port for port, _ in missing if port.needed], model, used)),
        offers=_few((group, array) for array, group in _alike("input", [port for port, _ in missing], model, used)),
    )


def split_name(name: str) -> tuple[str, int | None]:
    """Return a name without case and separators, and its index: `TauCmd_1` is `taucmd`, 1."""
    match = re.fullmatch(r"(.*?)[\[\(_.]*(\d+)[\]\)]?", name)
    base, index = (match[1], int(match[2])) if match and match[1] else (name, None)
    return re.sub(r"[^a-z0-9]", "", base.lower()), index


class _Spellings:
    """Find variables by names in which case, separators and the first index do not count."""

    def __init__(self, variables: Iterable[ScalarVariable]) -> None:
        self._groups: dict[tuple[str, str], dict[int | None, ScalarVariable]] = defaultdict(dict)
        for variable in variables:
            base, index = split_name(variable.name)
            self._groups[base, variable.causality].setdefault(index, variable)

    def from_zero(self, port: ContractPort) -> bool:
        """Return whether the FMU counts the array that a port belongs to from 0."""
        base, index = split_name(port.name)
        return index is not None and 0 in self._groups.get((base, port.causality), {})

    def find(self, port: ContractPort) -> tuple[ScalarVariable | None, tuple[str, ...]]:
        """Return the variable, and how its name differs."""
        base, index = split_name(port.name)
        group = self._groups.get((base, port.causality), {})
        if index is not None and self.from_zero(port):
            found, how = group.get(index - 1), "counted from 0"
        else:
            found, how = group.get(index), "named differently"
        return found, () if found is None else (how,)


def _fit(port: ContractPort, variable: ScalarVariable, model: Model) -> tuple[str, tuple[str, ...]]:
    """Return why a variable cannot serve a port, or what an adapter has to do."""
    if variable.causality != port.causality:
        return f"is {_article(variable.causality)}, not {_article(port.causality)}", ()
    work = []
    if variable.type != port.type:
        if not {variable.type, port.type} <= set(_NUMERIC):
            return f"is of type {variable.type}, not {port.type}", ()
        work.append(f"type {variable.type} instead of {port.type}")
    reason, more = _unit_work(port, model.unit_named(variable.unit))
    return reason, (*work, *more)


def _article(word: str) -> str:
    return f"{'an' if word[0] in 'aeiou' else 'a'} {word}"


def _unit_work(port: ContractPort, unit: Unit | None) -> tuple[str, tuple[str, ...]]:
    """Compare the unit of a variable with the port's, in the same terms as `_fit`."""
    wanted = port.unit
    if wanted is None or port.type != "Real":
        return "", ()
    if unit is None:
        dimensionless = wanted.exponents is not None and not any(wanted.exponents) and wanted.factor == 1.0
        return ("", ()) if dimensionless else ("", (f"no unit declared; the contract has {wanted.name}",))
    try:
        gain, bias = conversion(unit, wanted)
    except ValueError as error:
        if unit.exponents is not None and without_radian(unit).exponents == without_radian(wanted).exponents:
            gain = unit.factor / wanted.factor
            return "", (f"unit {unit.name}, whose base units leave out the radian, factor {gain:.9g}",)
        return f"does not fit: {error}", ()
    if (gain, bias) == (1.0, 0.0):
        return "", ()
    offset = f" and offset {bias:.9g}" if bias else ""
    return "", (f"unit {unit.name} instead of {wanted.name}, factor {gain:.9g}{offset}",)


def _alike(causality: str, missing: Sequence[ContractPort], model: Model, used: set[str]) -> list[tuple[str, str]]:
    """Return pairs of a missing array of the contract and an unused one of the FMU that agree in number and unit."""
    unused: dict[str, list[ScalarVariable]] = defaultdict(list)
    for variable in model.variables:
        if variable.causality == causality and variable.name not in used:
            unused[split_name(variable.name)[0]].append(variable)
    arrays: dict[str, list[ContractPort]] = defaultdict(list)
    for port in missing:
        if port.causality == causality:
            arrays[array_of(port.name)].append(port)
    return [
        (name, f"{group[0].name} to {group[-1].name}" if len(group) > 1 else group[0].name)
        for name, ports in arrays.items()
        for group in unused.values()
        if len(group) == len(ports)
        and group[0].type == ports[0].type
        and not _unit_work(ports[0], model.unit_named(group[0].unit))[0]
    ]


def _few(pairs: Iterable[tuple[str, str]]) -> dict[str, str]:
    """Group pairs by their first; drop those with many partners, which are no hint."""
    groups: dict[str, list[str]] = defaultdict(list)
    for one, other in pairs:
        groups[one].append(other)
    return {one: " or ".join(others) for one, others in groups.items() if len(others) <= _FEW}


def choose(contracts: Sequence[Contract], model: Model, like: str | None) -> ContractMatch | None:
    """Return the comparison with the contract that was asked for, or that fits best; None if no contract fits.

    Of several variants of a component, the one that fits best is taken. Without `like`, a contract fits if at
    least half of its inputs and needed outputs are served.

    Raises
    ------
    InputError
        If there is no contract of the name asked for.
    """
    asked = named(contracts, like) if like else contracts
    comparisons = [compare(contract, model) for contract in asked]
    best = max(comparisons, key=lambda c: c.likeness, default=None)
    return best if best is not None and (like or best.likeness[0] >= 0.5) else None


def named(contracts: Sequence[Contract], like: str) -> list[Contract]:
    """Return the contracts of a name, `component` or `component:variant`; raise InputError if there is none."""
    found = [contract for contract in contracts if like in (contract.component, contract.name)]
    if not found:
        names = dict.fromkeys([*(c.component for c in contracts), *(c.name for c in contracts)])
        raise InputError(f"--like {like}: no such contract; there are {', '.join(names) or 'none'}")
    return found
