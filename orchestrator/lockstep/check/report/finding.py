"""The result of one check of one FMU, which all checks return and all reports print."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal, get_args

Status = Literal["pass", "info", "warning", "error", "skipped"]
Group = Literal["static", "dynamic", "contract"]

STATUSES: tuple[Status, ...] = get_args(Status)
GROUPS: tuple[Group, ...] = get_args(Group)


@dataclass(frozen=True, slots=True, kw_only=True)
class Finding:
    """The outcome of one check.

    `error` violates FMI or makes the FMU unusable, `warning` may cause trouble for users, `info` is worth knowing,
    `skipped` was not checked, with the reason.
    """

    check: str  # a stable dotted id, such as static.schema: reports of two versions are compared by it
    group: Group
    title: str  # what was checked, in words
    status: Status
    message: str = ""  # one line
    details: tuple[str, ...] = ()  # one line each
    numbers: Mapping[str, float] = field(default_factory=dict)  # measured values; the name carries the unit

    def __post_init__(self) -> None:
        if self.status not in STATUSES:
            raise ValueError(f"{self.check}: no status {self.status!r}; one of {', '.join(STATUSES)}")
        if self.group not in GROUPS or not self.check.startswith(f"{self.group}."):
            raise ValueError(f"check {self.check!r} must begin with its group, one of {', '.join(GROUPS)}")
