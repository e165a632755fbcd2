"""The acceptance report of FMUs as a value, and as JSON and JUnit XML."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Element, SubElement, indent, tostring

from lockstep.check.report.finding import STATUSES, Finding, Status
from lockstep.data_text import check_shape, parse_json
from lockstep.errors import InputError
from lockstep.whole_file import write_whole

_FIELDS = ("file", "sha256", "model", "guid", "tool", "checked", "host", "seconds")
FORMAT = 1  # of the JSON file; raised when a reader of the old one would fail
_SEVERITY: dict[Status, int] = {"pass": 0, "skipped": 0, "info": 1, "warning": 2, "error": 3}
_ILLEGAL = re.compile("[^\t\n\r\u0020-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")  # in XML 1.0


@dataclass(frozen=True, slots=True, kw_only=True)
class CheckReport:
    """The findings about one FMU."""

    file: str  # as given on the command line
    sha256: str
    model: str
    guid: str
    tool: str
    checked: str  # when: ISO 8601, UTC
    host: str  # platform and versions that checked
    seconds: float  # that the checks took
    findings: tuple[Finding, ...]

    @property
    def worst(self) -> Status:
        """Return the worst status of all findings; a check that was skipped is not bad."""
        return max((f.status for f in self.findings), key=_SEVERITY.__getitem__, default="pass")

    def counts(self) -> dict[Status, int]:
        """Return how many findings have each status."""
        return {status: sum(f.status == status for f in self.findings) for status in STATUSES}


def fails(reports: Sequence[CheckReport], strict: bool) -> bool:
    """Return whether an FMU is refused: by an error, or with `strict` by a warning."""
    limit = _SEVERITY["warning" if strict else "error"]
    return any(_SEVERITY[report.worst] >= limit for report in reports)


def summary(report: CheckReport) -> str:
    """Count the findings in words: `1 error, 2 warnings, 14 passed`."""
    counts = report.counts()
    words = []
    for status, one, more in (
        ("error", "error", "errors"),
        ("warning", "warning", "warnings"),
        ("info", "note", "notes"),
        ("skipped", "skipped", "skipped"),
        ("pass", "passed", "passed"),
    ):
        if count := counts[status]:  # type: ignore[index]
            words.append(f"{count} {one if count == 1 else more}")
    return ", ".join(words) or "nothing checked"


def as_json(reports: Sequence[CheckReport]) -> str:
    """Write reports; `from_json` reads them back."""
    content = {"format": FORMAT, "fmus": [_as_dict(report) for report in reports]}
    return json.dumps(content, indent=1, allow_nan=False) + "\n"


def _as_dict(report: CheckReport) -> dict[str, Any]:
    fields = {name: getattr(report, name) for name in _FIELDS}
    return fields | {
        "worst": report.worst,
        "counts": report.counts(),
        "findings": [
            {
                "check": f.check,
                "group": f.group,
                "title": f.title,
                "status": f.status,
                "message": f.message,
                "details": list(f.details),
                # JSON knows no NaN and no infinity
                "numbers": {k: float(v) if math.isfinite(v) else None for k, v in f.numbers.items()},
            }
            for f in report.findings
        ],
    }


_SHAPE = {
    "fmus": [
        dict.fromkeys(_FIELDS, "text")
        | {
            "seconds": "number",
            "findings": [
                {
                    "check": "text", "group": "text", "title": "text", "status": "text", "message": "text",
                    "details": ["text"], "numbers": {"*": "number?"},
                }
            ]
        }
    ]
}  # fmt: skip


def from_json(text: str) -> tuple[CheckReport, ...]:
    """Read what `as_json` wrote; raise InputError for another format."""
    content = parse_json(text, "report")
    check_shape(content, {"?format": "number"}, "report")
    if content.get("format") != FORMAT:
        raise InputError(f"format {content.get('format')!r} of the report is not {FORMAT}")
    check_shape(content, _SHAPE, "report")
    reports = []
    for fmu in content["fmus"]:
        findings = tuple(
            Finding(
                **f | {"details": tuple(f["details"])},
                numbers={k: math.nan if v is None else v for k, v in numbers.items()},
            )
            for f in fmu["findings"]
            if (numbers := f.pop("numbers")) is not None
        )
        reports.append(CheckReport(**{name: fmu[name] for name in _FIELDS}, findings=findings))
    return tuple(reports)


def as_junit(reports: Sequence[CheckReport], strict: bool = False) -> str:
    """Write JUnit XML: a test suite an FMU, a test case a finding; warnings fail if `strict`."""
    failing = ("error", "warning") if strict else ("error",)
    root = Element("testsuites", {"name": "flexsat check"})
    for report in reports:
        counts = report.counts()
        suite = SubElement(
            root,
            "testsuite",
            {
                "name": _xml(report.file),
                "tests": str(len(report.findings)),
                "failures": str(sum(f.status in failing for f in report.findings)),
                "errors": "0",
                "skipped": str(counts["skipped"]),
                "time": f"{report.seconds:.3f}",
            },
        )
        for finding in report.findings:
            _add_case(suite, finding, failing)
    indent(root, " ")
    return tostring(root, encoding="unicode", xml_declaration=True) + "\n"


def _add_case(suite: Element, finding: Finding, failing: tuple[str, ...]) -> None:
    case = SubElement(suite, "testcase", {"classname": finding.check, "name": _xml(finding.title), "time": "0"})
    text = _xml("\n".join([finding.message, *finding.details, *number_lines(finding)]))
    if finding.status in failing:
        failure = SubElement(case, "failure", {"type": finding.status, "message": _xml(finding.message)})
        failure.text = text
    elif finding.status == "skipped":
        SubElement(case, "skipped", {"message": _xml(finding.message)})
    elif text:
        SubElement(case, "system-out").text = f"{finding.status}: {text}"


def number_lines(finding: Finding) -> list[str]:
    """Return the measured values as text."""
    return [f"{name} = {_number(value)}" for name, value in finding.numbers.items()]


def _number(value: float) -> str:
    return f"{value:,.0f}" if float(value).is_integer() and abs(value) < 1e15 else f"{value:.6g}"


def _xml(text: str) -> str:
    """Replace the characters that XML cannot hold; names in a bad FMU may have any."""
    return _ILLEGAL.sub("\ufffd", text)


def write_text(path: Path, text: str) -> None:
    """Write a file completely or not at all."""
    write_whole(path, text.encode("utf-8", "replace"))
