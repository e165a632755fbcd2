"""Check one FMU: static checks, then dynamic ones, then the comparison with a contract."""

from __future__ import annotations

import platform
from collections.abc import Callable, Sequence
from datetime import UTC, datetime
from pathlib import Path
from time import perf_counter

from lockstep.check.adapted_findings import Behind, adapted_findings
from lockstep.check.contract import Contract
from lockstep.check.contract_findings import contract_findings
from lockstep.check.dynamic_checks import dynamic_checks
from lockstep.check.report.check_report import CheckReport
from lockstep.check.report.finding import Finding
from lockstep.check.static.fmu_archive import FmuArchive, read_archive, unreadable
from lockstep.check.static_checks import static_checks
from lockstep.fmi.model_description import VERSION
from lockstep.fmi.platforms import PLATFORM

_STOPPERS = ("static.archive", "static.kind", "static.platforms")  # errors that leave nothing to run


def check_fmu(
    path: Path,
    *,
    dynamic: bool = True,
    contracts: Sequence[Contract] = (),
    like: str | None = None,
    behind: Behind | None = None,
    others: Sequence[Path] = (),
    report: Callable[[Finding], None] = lambda _: None,
) -> CheckReport:
    """Run all checks of one FMU.

    Parameters
    ----------
    path : the file
    dynamic : also run it, in processes of their own
    contracts : to compare its ports with; the one named `like`, or the one that fits best
    behind : the adapter behind which its ports are compared
    others : FMUs to load in one process with it; none: a copy of itself
    report : called with each finding as it comes

    Raises
    ------
    InputError
        If there is no such file, or no contract of that name. A file that is no FMU is a finding.
    """
    started = perf_counter()
    fmu = read_archive(path)
    findings = static_checks(fmu, report)
    findings += _dynamic(path, findings, report, others) if dynamic else []
    compared = _contract(fmu, contracts, like, behind, dynamic)
    for finding in compared:
        report(finding)
    attributes = {} if fmu.model is None else fmu.model.attributes
    return CheckReport(
        file=str(path),
        sha256=fmu.sha256,
        model=attributes.get("modelName", ""),
        guid=attributes.get("guid") or attributes.get("instantiationToken", ""),
        tool=attributes.get("generationTool", ""),
        checked=datetime.now(UTC).isoformat(timespec="seconds"),
        host=f"{PLATFORM}, Python {platform.python_version()}, FMPy {VERSION}",
        seconds=perf_counter() - started,
        findings=(*findings, *compared),
    )


def _dynamic(
    path: Path, found: Sequence[Finding], report: Callable[[Finding], None], others: Sequence[Path]
) -> list[Finding]:
    """Run the dynamic checks unless a static one found nothing that can run."""
    stopper = next((f for f in found if f.check in _STOPPERS and f.status == "error"), None)
    if stopper is not None:
        skipped = Finding(
            check="dynamic.run",
            group="dynamic",
            title="execution",
            status="skipped",
            message=f"cannot be run: {stopper.message}",
        )
        report(skipped)
        return [skipped]
    faults = [f.check for f in found if f.status == "error"]
    return dynamic_checks(path, report, others=others, faults=faults)


def _contract(
    fmu: FmuArchive, contracts: Sequence[Contract], like: str | None, behind: Behind | None, dynamic: bool
) -> list[Finding]:
    if not contracts or fmu.model is None or unreadable(fmu):
        return []
    if behind is not None:
        return adapted_findings(contracts, fmu.path, like, behind, dynamic=dynamic)
    return contract_findings(contracts, fmu.model, like)
