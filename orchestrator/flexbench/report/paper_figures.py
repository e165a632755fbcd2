"""Where each figure of the paper, and each that its public release draws, has its place, or why it has none.

Source: P, Cachim et al., IEEE Aerospace 2025 (arXiv 2410.07376); C, RoboticExplorationLab/distributed-flexible-control,
whose scripts name the files of their plots.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from flexbench.html.document import Block, Paragraph, Table

_NOTE = (
    "Every figure of the paper and of the plots that its public release draws, and where this page has it. Not in the"
    " paper: "
)
_MORE = (
    "loop shapes and the trade-off of the robust design, which `flexsat figures --robust-design` draws, and"
    " margins measured through the FMUs."
)
_OF_LOOPS = (("bandwidth", "controller bandwidth over the wheel responses"), ("nichols|sensitivity", "margins"),
             ("spillover", "spillover"))  # fmt: skip
FINE, SLEW = r"fine-pointing(-as-published)?-seed\d+", r"slew(-as-published)?-seed\d+"


@dataclass(frozen=True, slots=True, kw_only=True)
class PaperFigure:
    """A figure of the paper and its place: a figure with its panel, a time history, or none for a reason."""

    subject: str
    release: tuple[str, ...] = ()  # its files in C, without ending
    figure: str = ""  # pattern of the name of the figure that has it
    panels: tuple[str, ...] = ()  # titles of the panels in that figure
    history: str = ""  # group of the time histories that has it
    reason: str = ""  # why it has no place


PAPER_FIGURES = (
    PaperFigure(
        subject="Concepts of missions with large apertures (its Fig. 1)",
        reason="pictures of other projects, no results",
    ),
    PaperFigure(
        subject="Structure, wheels and sensors", release=("MeshActSens", "MeshActSens2DPlate"), figure="structure"
    ),
    PaperFigure(subject="Shapes of the vibration modes", release=("VibModesSC",), figure="mode-shapes"),
    PaperFigure(subject="Campbell diagram", release=("CampDiag",), figure="campbell"),
    PaperFigure(
        subject="Response to the imbalance of one wheel, and its speeds",
        release=("PSDSYSRW",),
        figure="wheel-responses-centralised",
    ),
    PaperFigure(
        subject="The same for all wheels", release=("PSDSYSRWAll",), figure="wheel-responses-(centralised|distributed)"
    ),
    PaperFigure(subject="Control action of a slew", release=("RWTNorm",), figure=SLEW, panels=("Wheel torque",)),
    PaperFigure(
        subject="Its integral over time", release=("RWTIntNorm",), figure=SLEW, panels=("Wheel torque, over time",)
    ),
    PaperFigure(
        subject="Cost, total and control",
        release=("LQRIntNorm",),
        figure=SLEW,
        panels=("LQR cost; thin: control part",),
    ),
    PaperFigure(
        subject="Wheel speeds about x with their band",
        release=("WRWSep", "WRWAll", "RWSpeeds"),
        figure=SLEW,
        panels=("Wheels about x",),
    ),
    PaperFigure(
        subject="Torque of single wheels and its limit",
        release=("RWTorques", "RWTorquesSpeed"),
        figure=SLEW,
        panels=("One wheel about x; dotted: its limit",),
    ),
    PaperFigure(subject="Rotation about x", release=("Attitude",), figure=SLEW, panels=("Rotation about x",)),
    PaperFigure(subject="Pointing error of a slew", release=("AttitudeErr",), figure=SLEW, panels=("Pointing error",)),
    PaperFigure(subject="Angular rate error", release=("AngVelErr",), figure=SLEW, panels=("Angular rate error",)),
    PaperFigure(subject="Deformation of a slew", release=("RMSDefDistvsCent",), figure=SLEW, panels=("Deformation",)),
    PaperFigure(
        subject="A bending mode during a slew",
        release=("scndbendmode",),
        figure=SLEW,
        panels=("Bending mode about x",),
    ),
    PaperFigure(
        subject="Pointing error in fine pointing", release=("AttitudeErr",), figure=FINE, panels=("Pointing error",)
    ),
    PaperFigure(
        subject="Deformation in fine pointing, loop open and closed",
        release=("RMSDefOLvsCL",),
        figure=FINE,
        panels=("Deformation",),
    ),
    PaperFigure(subject="Control action in fine pointing", release=("RWTNorm",), history="torque, sum over wheels"),
    PaperFigure(
        subject="Single modes, loop open and closed",
        release=("ModesOLvsCLposter2",),
        history="plant.modal.displacement",
    ),
    PaperFigure(subject="Body rate", release=("AngVel",), history="plant.rate"),
    PaperFigure(
        subject="Measurements and their residuals",
        release=("TrueMeas", "MeasErr"),
        reason="switched off in the release; `flexsat health` records and judges them",
    ),
)


def paper_figures(names: Sequence[str]) -> list[Block]:
    """Return the list of the paper's figures with the place of each among the named figures of a page, in order."""
    rows = [[one.subject, ", ".join(one.release), _place(one, names)] for one in PAPER_FIGURES]
    return [
        Paragraph(_NOTE + _beyond_the_paper(names) + _MORE),
        Table(("figure of the paper", "plot of the release", "here"), rows, code=frozenset({1})),
    ]


def _beyond_the_paper(names: Sequence[str]) -> str:
    """Return which figures of the loops a page has, or what draws them."""
    found = []
    for pattern, subject in _OF_LOOPS:
        numbers = [str(k + 1) for k, name in enumerate(names) if re.fullmatch(rf"({pattern})-[\w-]+", name)]
        if numbers:
            found.append(f"{subject} (Figure {', '.join(numbers)})")
    if not found:
        return "controller bandwidth, margins and spillover, which `flexsat paper --margins` adds; "
    return f"{'; '.join(found)}; "


def _place(one: PaperFigure, names: Sequence[str]) -> str:
    if one.reason:
        return f"none: {one.reason.replace('`', '')}"
    if one.history:
        return f"Time histories: {one.history}"
    numbers = [str(k + 1) for k, name in enumerate(names) if re.fullmatch(one.figure, name)]
    if not numbers:
        return "not drawn for this page; flexsat figures draws it"
    panels = f", {', '.join(f'“{panel}”' for panel in one.panels)}" if one.panels else ""
    return f"Figure {', '.join(numbers)}{panels}"
