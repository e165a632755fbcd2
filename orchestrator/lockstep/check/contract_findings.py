"""Say what a comparison with a contract found: served as it is, with an adapter, not at all; inputs nobody feeds."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from lockstep.array_names import array_of
from lockstep.check.contract import Comparison, Contract, ContractPort, Served, choose, compare
from lockstep.check.report.finding import Finding, Status
from lockstep.check.static.model import Model
from lockstep.errors import compact

_ALL = 10_000  # names are folded, not cut: this is the list that an integrator works through


def contract_findings(contracts: Sequence[Contract], model: Model, like: str | None) -> list[Finding]:
    """Compare with the contract asked for, or with the one that fits best; no finding without contracts.

    An output that the loop needs and the FMU lacks is an error if the contract was asked for, else a warning.
    """
    if not contracts:
        return []
    comparison = choose(contracts, model, like)
    if comparison is None:
        best = max((compare(contract, model) for contract in contracts), key=lambda c: c.likeness)
        message = (
            f"it resembles none of our components; nearest is {best.contract.name} with {len(best.served)} of "
            f"{len(best.contract.ports)} ports; name one with --like"
        )
        return [_finding("contract.direct", "ports of ours that it can serve", "skipped", message)]
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


def _direct(comparison: Comparison) -> Finding:
    contract, direct = comparison.contract, comparison.direct
    details = [
        f"{causality}s: {compact([s.port.name for s in direct if s.port.causality == causality], _ALL)}"
        for causality in ("output", "input", "parameter")
        if any(s.port.causality == causality for s in direct)
    ]
    total = len(contract.ports)
    return _finding(
        "contract.direct",
        "ports of ours that it serves as it is",
        "pass" if direct else "info",
        f"{contract.name}: {len(direct)} of {total} ports",
        details,
        {"ports": total, "direct": len(direct), "adapter": len(comparison.adapted), "missing": len(comparison.missing)},
    )


def _adapter(comparison: Comparison) -> Finding:
    adapted, title = comparison.adapted, "ports of ours that it serves through an adapter"
    if not adapted:
        return _finding("contract.adapter", title, "pass", "none needs one")
    groups: dict[tuple[str, ...], list[Served]] = {}
    for served in adapted:
        groups.setdefault((array_of(served.port.name), *served.work), []).append(served)
    details = []
    for (_, *work), group in groups.items():
        theirs = group[0].variable.name
        if len(group) > 1:
            theirs += f" to {group[-1].variable.name}"
        details.append(f"{compact(s.port.name for s in group)} is {theirs}: {'; '.join(work)}")
    return _finding("contract.adapter", title, "warning", f"{len(adapted)} ports need one", details)


def _missing(comparison: Comparison, asked: bool) -> Finding:
    title = "ports of ours that it does not have"
    if not comparison.missing:
        return _finding("contract.missing", title, "pass", "none")
    needed = [(port, why) for port, why in comparison.missing if port.needed]
    details = [f"needed: {line}" for line in _lines(needed)]
    details += [f"{name}: of equal number and fitting unit is {hint}" for name, hint in comparison.hints.items()]
    for causality, meaning in (("output", "optional"), ("input", "offered, not taken"), ("parameter", "optional")):
        rest = [(p, why) for p, why in comparison.missing if p.causality == causality and not p.needed]
        details += [f"{causality}, {meaning}: {line}" for line in _lines(rest)]
    count = f"{len(comparison.missing)} ports, {len(needed)} of them outputs that our loop needs"
    status: Status = ("error" if asked else "warning") if needed else "info"
    return _finding("contract.missing", title, status, count, details)


def _lines(missing: Sequence[tuple[ContractPort, str]]) -> list[str]:
    """Fold the ports that are missing for the same reason into one line."""
    groups: dict[str, list[str]] = {}
    for port, why in missing:
        groups.setdefault(why, []).append(port.name)
    return [compact(names, _ALL) + (f": {why}" if why else "") for why, names in groups.items()]


def _unfed(comparison: Comparison) -> Finding:
    title = "inputs of it that nothing in our loop feeds"
    if not comparison.unfed:
        return _finding("contract.unfed", title, "pass", "none")
    names = [v.name for v in comparison.unfed]
    message = f"{len(names)} inputs would keep their start values"
    details = [f"{name}: of equal number and fitting unit is our {offer}" for name, offer in comparison.offers.items()]
    return _finding("contract.unfed", title, "warning", message, [compact(names, _ALL), *details])
