"""Hold sums of signals as frozen values: components without an FMU, computed by the master."""

from collections.abc import Mapping
from dataclasses import dataclass

from lockstep.errors import InputError


@dataclass(frozen=True, slots=True, kw_only=True)
class Sums:
    """Each output is the sum of its inputs, added in their order; all sums have the same number of inputs.

    Outputs have the value references 0, 1, ...; inputs follow, those of the first output first.
    """

    inputs: Mapping[str, tuple[str, ...]]  # by output

    def __post_init__(self) -> None:
        sizes = {len(names) for names in self.inputs.values()}
        if len(sizes) != 1 or 0 in sizes:
            raise InputError(f"sums of {sorted(sizes)} inputs: give each the same number of them, at least one")

    @property
    def terms(self) -> int:
        """How many inputs each output has."""
        return len(next(iter(self.inputs.values())))
