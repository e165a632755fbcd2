"""Report a comparison with a contract: ports served directly, by an adapter, or not at all; unfed inputs."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from lockstep.array_names import array_of
from lockstep.check.contract import ALL_NAMES, Contract, ContractMatch, ContractPort, Served, choose, compare
from lockstep.check.report.finding import Finding, Status
from lockstep.check.static.model import Model
from lockstep.errors import compact


def contract_findings(contracts: Sequence[Contract], model: Model, like: str | None) -> list[Finding]:
    """Compare with the contract asked for, or with the one that fits best; no finding without contracts.

    An output that the system needs and the FMU lacks is an error if the contract was asked for, else a warning.
    """
    if not contracts:
        return []
    comparison = choose(contracts, model, like)
    if comparison is None:
        best = max((compare(contract, model) for contract in contracts), key=lambda c: c.likeness)
        closest = (
            f"the closest is {best.contract.name} with {len(best.served)} of {len(best.contract.ports)} ports; "
            if best.served
            else "none has a port like one of the FMU's; "
        )
        message = f"matches no contract; {closest}choose one with --like"
        return [_finding("contract.direct", "contract ports that it can serve", "skipped", message)]
    return [_direct(comparison), _adapter(comparison), _missing(comparison, bool(like)), _unfed(comparison)]


def _finding(
    check: str,
    title: str,
    status: Status,
    message: str,
    details: Iterable[str] = (),
    numbers: dict[str, float] | None = None,
) -> Finding:
    return Finding(
        check=check,
        group="contract",
        title=title,
        status=status,
        message=message,
        details=tuple(details),
        numbers=numbers or {},
    )


def _direct(comparison: ContractMatch) -> Finding:
    contract, direct = comparison.contract, comparison.served_directly
    details = [
        f"{causality}s: {compact([s.port.name for s in direct if s.port.causality == causality], ALL_NAMES)}"
        for causality in ("output", "input", "parameter")
        if any(s.port.causality == causality for s in direct)
    ]
    total = len(contract.ports)
    return _finding(
        "contract.direct",
        "contract ports served directly",
        "pass" if direct else "info",
        f"{contract.name}: {len(direct)} of {total} ports",
        details,
        {"ports": total, "direct": len(direct), "adapter": len(comparison.adapted), "missing": len(comparison.missing)},
    )


def _adapter(comparison: ContractMatch) -> Finding:
    adapted, title = comparison.adapted, "contract ports served through an adapter"
    if not adapted:
        return _finding("contract.adapter", title, "pass", "none needs an adapter")
    groups: dict[tuple[str, ...], list[Served]] = {}
    for served in adapted:
        groups.setdefault((array_of(served.port.name), *served.work), []).append(served)
    details = []
    for (_, *work), group in groups.items():
        variables = group[0].variable.name
        if len(group) > 1:
            variables += f" to {group[-1].variable.name}"
        details.append(f"{compact(s.port.name for s in group)} is {variables}: {'; '.join(work)}")
    message = f"{len(adapted)} ports need an adapter; {_draft(comparison)}"
    return _finding("contract.adapter", title, "warning", message, details)


def _draft(comparison: ContractMatch) -> str:
    """Return how to make an adapter."""
    return f"draft one with `adapt`, --like {comparison.contract.name}, and give it to this check as --adapter FILE"


def _missing(comparison: ContractMatch, asked: bool) -> Finding:
    title = "contract ports that the FMU does not have"
    if not comparison.missing:
        return _finding("contract.missing", title, "pass", "none")
    needed = [(port, why) for port, why in comparison.missing if port.needed]
    details = [f"needed: {line}" for line in _lines(needed)]
    details += [f"{name}: matches {hint} of the FMU in number and unit" for name, hint in comparison.hints.items()]
    for causality, meaning in (("output", "optional"), ("input", "available, not used"), ("parameter", "optional")):
        rest = [(p, why) for p, why in comparison.missing if p.causality == causality and not p.needed]
        details += [f"{causality}, {meaning}: {line}" for line in _lines(rest)]
    count = f"{len(comparison.missing)} ports, {len(needed)} of them outputs that the system needs"
    if needed and not comparison.adapted:  # under other names, perhaps
        count += f"; {_draft(comparison)}"
    status: Status = ("error" if asked else "warning") if needed else "info"
    return _finding("contract.missing", title, status, count, details)


def _lines(missing: Sequence[tuple[ContractPort, str]]) -> list[str]:
    """Fold the ports that are missing for the same reason into one line."""
    groups: dict[str, list[str]] = {}
    for port, why in missing:
        groups.setdefault(why, []).append(port.name)
    return [compact(names, ALL_NAMES) + (f": {why}" if why else "") for why, names in groups.items()]


def _unfed(comparison: ContractMatch) -> Finding:
    title = "inputs of the FMU without a source in the system"
    if not comparison.unfed:
        return _finding("contract.unfed", title, "pass", "none")
    names = [v.name for v in comparison.unfed]
    message = f"{len(names)} inputs keep their start values"
    details = [
        f"{name}: matches {offer} of the contract in number and unit" for name, offer in comparison.offers.items()
    ]
    return _finding("contract.unfed", title, "warning", message, [compact(names, ALL_NAMES), *details])
