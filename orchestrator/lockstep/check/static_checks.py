"""All static checks, in the order of the report."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from lockstep.check.report.finding import Finding
from lockstep.check.static import archive_checks as archive
from lockstep.check.static import binary_checks as binary
from lockstep.check.static import description_checks as description
from lockstep.check.static.fmu_archive import FmuArchive
from lockstep.check.static.structure_checks import unknowns
from lockstep.check.static.unit_checks import units

CHECKS = (
    archive.archive,
    archive.hygiene,
    description.kind,
    description.schema,
    units,
    unknowns,
    description.names,
    description.variables,
    description.descriptions,
    description.aliases,
    description.experiment,
    description.fmpy,
    binary.platforms,
    binary.functions,
    binary.dependencies,
    binary.instances,
    archive.documentation,
    archive.licence,
)
# what FMPy looks at too: an offence is one error
_DESCRIPTION = ("static.kind", "static.schema", "static.units", "static.unknowns", "static.names", "static.variables")


def static_checks(fmu: FmuArchive, report: Callable[[Finding], None] = lambda _: None) -> list[Finding]:
    """Run every static check; `report` is called with each finding as it comes."""
    findings: list[Finding] = []
    for run in CHECKS:
        findings.append(_once(run(fmu), findings))
        report(findings[-1])
    return findings


def _once(finding: Finding, before: Sequence[Finding]) -> Finding:
    """Return FMPy's objections as a note where a check of the description has found the same file in error."""
    if finding.check != "static.fmpy" or finding.status != "error":
        return finding
    by = [f.check for f in before if f.status == "error" and f.check in _DESCRIPTION]
    return replace(finding, status="info", message=f"as {', '.join(by)}: {finding.message}") if by else finding
