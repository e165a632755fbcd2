"""Keep the readers and writers of lists of references, for the calls that a host repeats at every step."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from ...ports.table import Kind

FlagKey = tuple[str | int, ...]  # kind, then the references
Admits = Callable[[Sequence[float]], bool]


class AccessPlans:
    """Plans of calls that need no further check during a run.

    Plans of reals are found by first reference and length, and hold the list to compare with; those of booleans are
    found by the whole list.
    """

    __slots__ = ("flag_reads", "flag_writes", "reads", "writes")

    def __init__(self) -> None:
        self.reads: dict[tuple[int, int], tuple[list[int], Callable[[], list[float]], bool]] = {}
        self.writes: dict[tuple[int, int], tuple[list[int], Callable[..., None], Admits]] = {}
        self.flag_reads: dict[FlagKey, Callable[[], list[Any]]] = {}
        self.flag_writes: dict[FlagKey, Callable[..., None]] = {}

    def clear(self) -> None:
        """Forget all plans."""
        for plans in (self.reads, self.writes, self.flag_reads, self.flag_writes):
            plans.clear()

    def keep_read(self, kind: Kind, vrs: list[int], reader: Callable[[], list[Any]], on_demand: bool) -> None:
        """Keep a reader, if its values may be read without a check; `on_demand`: some must be computed first."""
        if kind == "real":
            self.reads[vrs[0], len(vrs)] = (vrs, reader, on_demand)
        elif kind == "boolean" and not on_demand:
            self.flag_reads[kind, *vrs] = reader

    def keep_write(
        self, kind: Kind, vrs: list[int], writer: Callable[..., None], admits: Admits, feeds_on_demand: bool
    ) -> None:
        """Keep a writer; `admits` says at each call whether reals can be written without a further check."""
        if kind == "real":
            self.writes[vrs[0], len(vrs)] = (vrs, writer, admits)
        elif kind == "boolean" and not feeds_on_demand:
            self.flag_writes[kind, *vrs] = writer
