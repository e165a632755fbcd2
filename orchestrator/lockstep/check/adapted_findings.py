"""Judge an FMU behind its adapter: the ports of a contract that both serve together, and their conventions."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from lockstep.adapter.bind import Binding, bind
from lockstep.check.contract import ALL_NAMES, Contract, named
from lockstep.check.report.finding import Finding, Status
from lockstep.errors import InputError, RunError, compact
from lockstep.fmi.model_description import Variable, read_description
from lockstep.system.adapter_file import Adapter
from lockstep.system.component import Component

# Runs an FMU behind its adapter as a component of a contract, by name: whether its conventions are right, and lines.
Judge = Callable[[Path, Adapter, str], tuple[bool, Sequence[str]]]


@dataclass(frozen=True, slots=True, kw_only=True)
class Behind:
    """An adapter, and how its conventions are judged; None if nothing can judge them."""

    adapter: Adapter
    judge: Judge | None = None


def adapted_findings(
    contracts: Sequence[Contract], fmu: Path, like: str | None, behind: Behind, *, dynamic: bool
) -> list[Finding]:
    """Compare what an FMU and its adapter have together with the contract asked for, or that the adapter fits."""
    where, asked = behind.adapter.path.name, named(contracts, like) if like else contracts
    title = f"contract ports served behind {where}"
    fits: list[tuple[Contract, Binding]] = []
    reasons: list[str] = []
    name = "checked"
    try:
        variables = read_description(Component(name=name, source=fmu.absolute(), period=1)).variables
    except InputError as error:
        message = f"its ports cannot be read: {str(error).removeprefix(f'{name}: ')}"
        return [_finding("contract.adapter", title, "error", message)]
    for contract in asked:
        try:
            fits.append((contract, bind(behind.adapter, variables_of(contract), variables)))
        except InputError as error:
            reasons.append(f"{contract.name}: {error}")
    if not fits:
        message = f"{where} does not fit: {reasons[0]}"
        return [_finding("contract.adapter", title, "error", message, reasons[1:])]
    contract, binding = min(fits, key=lambda fit: len(_lacking(*fit)))
    found = [_served(contract, binding, title), _missing(contract, binding)]
    if behind.judge is not None and dynamic and found[-1].status != "error":
        found += _conventions(fmu, behind, contract)
    return found


def variables_of(contract: Contract) -> Mapping[str, Variable]:
    """Return the ports of a contract as variables of an FMU."""
    return {
        port.name: Variable(name=port.name, reference=number, type=port.type, causality=port.causality, unit=port.unit)
        for number, port in enumerate(contract.ports)
    }


def _lacking(contract: Contract, binding: Binding) -> list[str]:
    return [port.name for port in contract.ports if port.needed and port.name not in binding.shown]


def _served(contract: Contract, binding: Binding, title: str) -> Finding:
    details = []
    for bound in (*binding.inputs, *binding.outputs):
        ports, variables = (compact((v.name for v in group), ALL_NAMES) for group in (bound.ports, bound.variables))
        details.append(f"{bound.entry.direction} {ports} is {variables}")
    if binding.substitutes:
        details.append(f"constant: {compact(binding.substitutes, ALL_NAMES)}")
    count = sum(port.name in binding.shown for port in contract.ports)
    message = f"{contract.name}: {count} of {len(contract.ports)} ports"
    return _finding("contract.adapter", title, "pass", message, details)


def _missing(contract: Contract, binding: Binding) -> Finding:
    title = "contract ports that neither the FMU nor its adapter has"
    lacking = _lacking(contract, binding)
    if lacking:
        message = f"the system needs {compact(lacking, ALL_NAMES)}; add an [[output]], or [substitutes]"
        return _finding("contract.missing", title, "error", message)
    absent = [p.name for p in contract.ports if p.name not in binding.shown]
    details = [f"optional, or not used: {compact(absent, ALL_NAMES)}"] if absent else []
    return _finding("contract.missing", title, "info" if absent else "pass", "no output that the system needs", details)


def _conventions(fmu: Path, behind: Behind, contract: Contract) -> list[Finding]:
    """Return what the judge finds; nothing for a component that it does not know."""
    assert behind.judge is not None
    title = "signs, axes, units and directions of attitudes behind the adapter"
    try:
        right, lines = behind.judge(fmu, behind.adapter, contract.name)
    except InputError:
        return []
    except RunError as error:
        return [_finding("contract.conventions", title, "error", f"cannot be run: {error}")]
    return [_finding("contract.conventions", title, "pass" if right else "error", lines[-1], lines[:-1])]


def _finding(check: str, title: str, status: Status, message: str, details: Sequence[str] = ()) -> Finding:
    return Finding(check=check, group="contract", title=title, status=status, message=message, details=tuple(details))
