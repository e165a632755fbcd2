"""The report: one HTML page of a run, or of several side by side, that needs no network."""

from .write import write_report

__all__ = ["write_report"]
