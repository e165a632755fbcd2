"""The report's section on the design: which figures it shows, and how."""

from xml.etree import ElementTree

from matplotlib.figure import Figure

from flexbench.html.document import Heading
from flexbench.report.sections import design
from flexbench.runs.flown_design import flown_part, write_flown
from flexbench.runs.run_folder import Run


def test_section_shows_structure_wheels_and_architecture_of_the_design_of_a_run(monkeypatch, designs, tmp_path):
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
    run = Run(folder=tmp_path, configuration="distributed", slew=True, seed=1)

    write_flown(tmp_path, flown_part(designs["distributed"]))

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
