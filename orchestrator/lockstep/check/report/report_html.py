"""Write the acceptance report as one HTML page that loads nothing else: no network, no script, no font."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from lockstep.check.report.check_report import CheckReport, number_lines, summary

_HEADINGS = {"static": "The file", "dynamic": "Execution", "contract": "Ports against the contract"}  # by group
_OPEN = 8  # details that are shown unfolded


def as_html(reports: Sequence[CheckReport]) -> str:
    """Return the page: a table of all FMUs, then each one's findings by group."""
    environment = Environment(
        loader=FileSystemLoader(Path(__file__).parent),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    template = environment.get_template("report.html.jinja")
    return template.render(
        reports=reports, headings=_HEADINGS, open=_OPEN, about=_about, summary=summary, number_lines=number_lines
    )


def _about(report: CheckReport) -> list[tuple[str, str]]:
    """Return what identifies an FMU and its check; values may be empty."""
    return [
        ("model", report.model),
        ("made by", report.tool),
        ("GUID", report.guid),
        ("SHA-256", report.sha256),
        ("checked", f"{report.checked} on {report.host}, in {report.seconds:.1f} s"),
    ]
