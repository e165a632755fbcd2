"""The acceptance report as one HTML page that needs nothing else: no network, no script, no font."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

from lockstep.check.report.check_report import CheckReport, number_lines, summary
from lockstep.check.report.finding import GROUPS, Finding

_HEADINGS = {"static": "The file", "dynamic": "Running it", "contract": "Against our contract"}
_OPEN = 8  # details that are shown without asking
_STYLE = """
:root { color-scheme: light dark; }
body { font: 15px/1.45 system-ui, sans-serif; max-width: 70rem; margin: 2rem auto; padding: 0 1rem; }
h1 { font-size: 1.5rem; } h2 { font-size: 1.2rem; margin-top: 2.5rem; overflow-wrap: anywhere; }
h3 { font-size: 1rem; margin: 1.2rem 0 .3rem; }
table { border-collapse: collapse; width: 100%; }
th, td { text-align: left; vertical-align: top; padding: .3rem .6rem; border-bottom: 1px solid #8884; }
.findings td:nth-child(1) { width: 5.5rem; }
.findings td:nth-child(2) { width: 12rem; font-family: ui-monospace, monospace; font-size: .85em; }
td { overflow-wrap: anywhere; }
.title, .numbers, .meta { opacity: .7; font-size: .9em; } ul { margin: .2rem 0; padding-left: 1.2rem; }
summary { cursor: pointer; opacity: .7; font-size: .9em; }
.status { font-weight: 600; }
.pass { color: #1a7f37; } .info { color: #0969da; } .warning { color: #b26a00; } .error { color: #d1242f; }
.skipped { opacity: .6; }
@media print { body { margin: 0; max-width: none; }
 h2 { break-before: page; } h2:first-of-type { break-before: auto; } }
"""


def as_html(reports: Sequence[CheckReport]) -> str:
    """Return the page: a table of all FMUs, then each one's findings by group."""
    rows = "".join(
        f'<tr><td class="status {r.worst}">{r.worst}</td><td><a href="#fmu{i}">{escape(r.file)}</a></td>'
        f"<td>{escape(summary(r))}</td></tr>\n"
        for i, r in enumerate(reports, start=1)
    )
    parts = "".join(_part(report, number) for number, report in enumerate(reports, start=1))
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>FMU acceptance report</title>\n<style>{_STYLE}</style>\n</head>\n<body>\n"
        "<h1>FMU acceptance report</h1>\n"
        f"<table>\n<tr><th>worst</th><th>file</th><th>findings</th></tr>\n{rows}</table>\n{parts}</body>\n</html>\n"
    )


def _part(report: CheckReport, number: int) -> str:
    about = [
        ("model", report.model),
        ("made by", report.tool),
        ("GUID", report.guid),
        ("SHA-256", report.sha256),
        ("checked", f"{report.checked} on {report.host}, in {report.seconds:.1f} s"),
    ]
    told = "<br>\n".join(f"{name}: {escape(value)}" for name, value in about if value)
    text = f'<h2 id="fmu{number}">{escape(report.file)}</h2>\n<p class="meta">{told}<br>\n'
    text += f"{escape(summary(report))}</p>\n"
    for group in GROUPS:
        findings = [finding for finding in report.findings if finding.group == group]
        if findings:
            rows = "".join(_row(finding) for finding in findings)
            text += f'<h3>{_HEADINGS[group]}</h3>\n<table class="findings">\n{rows}</table>\n'
    return text


def _row(finding: Finding) -> str:
    body = f'<div class="title">{escape(finding.title)}</div>'
    if finding.message:
        body += f"<div>{escape(finding.message)}</div>"
    if finding.details:
        lines = "<ul>" + "".join(f"<li>{escape(line)}</li>" for line in finding.details) + "</ul>"
        folded = f"<details><summary>{len(finding.details)} lines</summary>{lines}</details>"
        body += folded if len(finding.details) > _OPEN else lines
    if finding.numbers:
        body += f'<div class="numbers">{escape(", ".join(number_lines(finding)))}</div>'
    status = f'<td class="status {finding.status}">{finding.status}</td>'
    return f"<tr>{status}<td>{escape(finding.check)}</td><td>{body}</td></tr>\n"
