"""Stability margins of the loop broken at the plant input: of the design, and measured through the FMUs."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from flexbench.html.document import Block
    from flexbench.runs.run_folder import Run


def section(run: Run) -> list[Block]:
    """Return the report's section on margins."""
    from .sections import section as told  # the command line reads the options of this package at each start

    return told(run)
