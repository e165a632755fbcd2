"""All static checks, in the order of the report."""

from __future__ import annotations

from collections.abc import Callable

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
    description.fmpy,
    units,
    unknowns,
    description.names,
    description.variables,
    description.descriptions,
    description.aliases,
    description.experiment,
    binary.platforms,
    binary.functions,
    binary.dependencies,
    binary.instances,
    archive.documentation,
    archive.licence,
)


def static_checks(fmu: FmuArchive, report: Callable[[Finding], None] = lambda _: None) -> list[Finding]:
    """Run every static check; `report` is called with each finding as it comes."""
    findings = []
    for run in CHECKS:
        findings.append(run(fmu))
        report(findings[-1])
    return findings
