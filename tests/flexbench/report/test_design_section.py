"""The report's section on the design: which figures it shows, and how."""

from pathlib import Path
from xml.etree import ElementTree

from matplotlib.figure import Figure

from flexbench.html.document import Heading
from flexbench.report.sections import design
from flexbench.runs.run_folder import Run


def test_section_shows_structure_wheels_and_architecture_of_the_design_of_a_run(monkeypatch):
    drawn = []

    def drawing(name):
        def draw(given):
            drawn.append((name, given))
            figure = Figure()
            figure.text(0.5, 0.5, name)
            return figure

        return draw

    for name in ("structure_layout", "wheel_responses", "architecture"):
        monkeypatch.setattr(design, name, drawing(name))
    run = Run(folder=Path("unread"), configuration="distributed", as_published=False, slew=True, seed=1)

    heading, *pictures = design.section(run)

    assert isinstance(heading, Heading)
    both = run.designs
    assert drawn == [("structure_layout", {"distributed": both.corrected}), ("wheel_responses", both.corrected),
                     ("architecture", both)]  # fmt: skip
    assert [picture.file for picture in pictures] == [
        "structure-distributed.svg",
        "wheel-responses-distributed.svg",
        "architecture-distributed.svg",
    ]
    for picture, (name, _) in zip(pictures, drawn, strict=True):
        assert ElementTree.fromstring(picture.svg).tag.endswith("svg")
        assert f"<!-- {name} -->" in picture.svg
        assert picture.description
