"""Draft the adapter of a foreign FMU for one of flexsat's components."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from lockstep.adapter.draft import draft_adapter
from lockstep.check.adapted_findings import variables_of
from lockstep.check.contract import named

from .attitude_words import SYNONYMS
from .contracts import contracts

CONTROLLER = "controller"
# An FMU has no output that is surely a reference: which attitude it holds, or where it goes?
_REFERENCE = """
# reference.*: left out, so that errors are counted from the commanded attitude. If the FMU outputs the attitude that it
# steers to at each moment, its name goes here:
# [[output]]
# port = "reference.mrp"
# variable = "..."
# attitude = "quaternion"
"""


def draft_for(fmu: Path, like: str) -> tuple[str, Sequence[str]]:
    """Return a first adapter of an FMU for a component, and what remains undecided."""
    drafts = []
    for contract in named(contracts(like), like):
        needed = [port.name for port in contract.ports if port.needed]
        drafts.append(draft_adapter(fmu, variables_of(contract), needed, contract.name, SYNONYMS))
    text, doubts = min(drafts, key=lambda draft: len(draft[1]))
    return text + _REFERENCE if like.startswith(CONTROLLER) else text, doubts
