"""The report's section on estimator health."""

from __future__ import annotations

from flexbench.html.document import Block, Heading, Paragraph, Table
from flexbench.runs.run_folder import Run
from flexbench.studies.health.analysis import analyse
from flexbench.studies.health.replay import recorded, replay
from flexbench.studies.health.study import HEADER, table_rows
from lockstep import InputError


def section(run: Run) -> list[Block]:
    """Return NIS, NEES and whiteness of a run, or why there are none."""
    heading = Heading(2, "Estimator health")
    if not recorded(run.signals()):
        text = "The measurements were not recorded; `flexsat health SYSTEM` records them, and judges several seeds."
        return [heading, Paragraph(text)]
    try:
        health = analyse({run.seed: replay(run)}, run.design)
    except InputError as error:
        return [heading, Paragraph(str(error))]
    white = health.whiteness
    text = (
        f"Of seed {run.seed}, from {health.settled_from:g} s on, per degree of freedom. {100 * white.outside:.0f} % of "
        "the autocorrelations of the innovations lie beyond what white noise exceeds at 5 % of the lags."
    )
    return [heading, Paragraph(text), Table(HEADER, table_rows(health), frozenset())]
