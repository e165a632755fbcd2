"""Make a static check: its notes, its outcome, and the finding that the report shows."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import wraps

from lockstep.check.report.finding import Finding, Status
from lockstep.check.static.fmu_archive import FmuArchive, unreadable
from lockstep.check.static.model import Model

KEPT = 500  # details a finding, at most: a broken file may have one for each of 100,000 variables


@dataclass(frozen=True, slots=True, kw_only=True)
class CheckOutcome:
    """What a check found: the rest of the finding stands with the check."""

    status: Status
    message: str
    details: tuple[str, ...] = ()
    numbers: tuple[tuple[str, float], ...] = ()


class Notes:
    """Collect the notes of one check; the worst of them is its status."""

    def __init__(self) -> None:
        self._kept: dict[Status, list[str]] = {"error": [], "warning": [], "info": []}

    def error(self, text: str) -> None:
        """Note a violation of FMI, or what makes the FMU unusable."""
        self._kept["error"].append(text)

    def warning(self, text: str) -> None:
        """Note what will cause trouble for users."""
        self._kept["warning"].append(text)

    def info(self, text: str) -> None:
        """Note what is worth knowing."""
        self._kept["info"].append(text)

    def outcome(self, passed: str, numbers: Iterable[tuple[str, float]] = ()) -> CheckOutcome:
        """Return all of it, the worst first; `passed` is the message when there is nothing else."""
        noted = [(status, text) for status, texts in self._kept.items() for text in texts]
        if not noted:
            return CheckOutcome(status="pass", message=passed, numbers=tuple(numbers))
        worst: Status = noted[0][0]
        if len(noted) == 1:
            return CheckOutcome(status=worst, message=noted[0][1], numbers=tuple(numbers))
        words: dict[Status, str] = {"error": "error", "warning": "warning", "info": "note"}
        counts = [f"{len(texts)} {words[s]}{'s' * (len(texts) > 1)}" for s, texts in self._kept.items() if texts]
        lines = [text if status == worst else f"{status}: {text}" for status, text in noted]
        if len(lines) > KEPT:
            lines = [*lines[: KEPT - 1], f"and {len(lines) - KEPT + 1} more"]
        return CheckOutcome(
            status=worst,
            message=f"{', '.join(counts)}: {noted[0][1]}",
            details=tuple(lines[1:]),
            numbers=tuple(numbers),
        )


Check = Callable[[FmuArchive], Finding]


def check(name: str, title: str) -> Callable[[Callable[[FmuArchive], CheckOutcome]], Check]:
    """Make a static check of a function of the fmu."""

    def decorate(function: Callable[[FmuArchive], CheckOutcome]) -> Check:
        @wraps(function)
        def run(fmu: FmuArchive) -> Finding:
            try:
                outcome = function(fmu)
            except ValueError as error:  # a member that cannot be unpacked
                outcome = CheckOutcome(status="error", message=str(error))
            return Finding(
                check=f"static.{name}",
                group="static",
                title=title,
                status=outcome.status,
                message=outcome.message,
                details=outcome.details,
                numbers=dict(outcome.numbers),
            )

        return run

    return decorate


def model_check(name: str, title: str) -> Callable[[Callable[[Model], CheckOutcome]], Check]:
    """Make a static check of a function of the model description; skipped without a readable one of FMI 2.0."""

    def decorate(function: Callable[[Model], CheckOutcome]) -> Check:
        @check(name, title)
        @wraps(function)
        def run(fmu: FmuArchive) -> CheckOutcome:
            reason = unreadable(fmu)
            return CheckOutcome(status="skipped", message=reason) if reason else function(_model(fmu))

        return run

    return decorate


def _model(fmu: FmuArchive) -> Model:
    assert fmu.model is not None  # unreadable() has excluded it
    return fmu.model
