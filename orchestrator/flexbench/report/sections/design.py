"""The report's section on the design of a run's spacecraft."""

from __future__ import annotations

from flexbench.figures.drawing import svg_text
from flexbench.figures.figure_lists import architecture
from flexbench.figures.structure import structure_layout
from flexbench.figures.wheels import wheel_responses
from flexbench.html.document import Block, Heading, Picture
from flexbench.runs.run_folder import Run


def section(run: Run) -> list[Block]:
    """Return structure, chosen wheel speeds and architecture of the design that was simulated."""
    designs = run.designs
    name = run.configuration
    pictures = {
        f"structure-{name}": ("Structure, wheels and sensors", structure_layout({name: designs.corrected})),
        f"wheel-responses-{name}": ("Response of each wheel, and its chosen speed", wheel_responses(designs.corrected)),
        f"architecture-{name}": ("Architecture and schedule", architecture(designs)),
    }
    return [
        Heading(2, "Design"),
        *(
            Picture(svg=svg_text(figure, stem), file=f"{stem}.svg", description=description)
            for stem, (description, figure) in pictures.items()
        ),
    ]
