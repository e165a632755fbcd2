"""The page: escaped texts, figures, sections of studies, the table of a study, colours."""

import base64
import io
import json
from pathlib import Path
from types import SimpleNamespace

import lxml.html
import numpy as np
import PIL.Image
import pyarrow.parquet as pq
import pytest

from flexbench.figures import drawing
from flexbench.html.document import Heading, Paragraph, Picture, Table
from flexbench.html.page_parts import PAGE_FOLDER, Image, image_of
from flexbench.html.render import template_environment
from flexbench.report import study_sections as of_studies
from flexbench.report.compose import compose_page
from flexbench.report.figure_images import WIDTHS, fitted_images, slim, stored_images
from flexbench.report.results import load_results
from flexbench.report.sections import SECTIONS
from flexbench.report.study_table import study_table
from flexbench.report.write import write_report
from flexbench.runs.run_folder import Run
from lockstep import InputError


def test_names_units_and_events_are_escaped(tmp_path, foreign_run):
    hostile = "</script><script>alert(1)</script><!-- &amp; \"'"
    event = {"time": 1.0, "event": hostile, "message": f"</table>{hostile}"}
    fault = {"time": 1.5, "event": "fault", "name": hostile, "state": "begin"}
    run = foreign_run(
        tmp_path / "<b>run & ", f"{json.dumps(event)}\n{json.dumps(fault)}\n", [f"toy.{hostile}"], f"# {hostile}"
    )
    table = pq.read_table(run / "signals.parquet")
    field = table.schema.field(1).with_metadata({"unit": hostile, "description": hostile})
    pq.write_table(table.cast(table.schema.set(1, field)), run / "signals.parquet")

    page = compose_page(load_results([run])[0])

    root = lxml.html.fromstring(page.encode(), parser=lxml.html.HTMLParser(encoding="utf-8"))
    kinds = [script.get("type") for script in root.iter("script")]
    assert kinds == ["application/json", "text/plain", None]  # contents, one history, the page's own script
    assert root.find(".//h1/b") is None
    assert root.find(".//title").text == "<b>run & "
    assert hostile in root.xpath("string(//section[@id='versions']//pre)")
    assert "<script>alert" not in page
    contents = json.loads(root.get_element_by_id("contents").text)
    (run_of_page,) = contents["runs"]
    (history_of_page,) = run_of_page["parts"][0]["histories"]
    assert history_of_page["group"] == f"toy.{hostile}"
    assert contents["groups"] == {f"toy.{hostile}": {"unit": hostile, "description": hostile}}
    assert [mark["text"] for mark in run_of_page["marks"]] == [hostile[:24]] * 2


def test_page_that_cannot_be_written_leaves_no_file(tmp_path, foreign_run):
    run = foreign_run(tmp_path / "run")
    (tmp_path / "file").write_text("in the way")
    with pytest.raises(InputError, match="cannot be written"):
        write_report([run], tmp_path / "file" / "x.html")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["file", "run"]


def test_stored_figures_are_read_in_the_smaller_format_and_limited_in_size(tmp_path):
    folder = tmp_path / "figures"
    folder.mkdir()
    (folder / "slew.png").write_bytes(b"p" * 50)
    (folder / "slew.svg").write_bytes(b"s" * 80)
    (folder / "modes.svg").write_bytes(b"s" * 70)
    (folder / "notes.txt").write_bytes(b"no figure")

    images = stored_images(tmp_path)

    assert [(image.title, image.type, len(image.data)) for image in images] == [
        ("modes", "image/svg+xml", 70),
        ("slew", "image/png", 50),
    ]
    taken, left = fitted_images(images[:1], room=60)  # no PNG to reduce
    assert ([image.name for image in taken], [image.name for image in left]) == ([], ["modes"])
    assert fitted_images(images, room=120) == (images, [])


def test_figures_that_are_too_large_together_are_reduced_and_all_there(tmp_path):
    folder = tmp_path / "figures"
    folder.mkdir()
    noise = np.random.default_rng(2).integers(0, 255, size=(100, 2000, 3), dtype=np.uint8)
    PIL.Image.fromarray(noise).save(folder / "campbell.png")
    (folder / "campbell.svg").write_bytes(b"s" * 3_000_000)
    (folder / "slew-seed1.svg").write_bytes(b"s" * 1000)

    taken, left = fitted_images(stored_images(tmp_path), room=200_000)

    assert ([image.name for image in taken], left) == (["slew-seed1", "campbell"], [])
    assert sum(len(image.data) for image in taken) <= 200_000
    with PIL.Image.open(io.BytesIO(taken[1].data)) as reduced:
        assert reduced.width in WIDTHS
        assert reduced.height == pytest.approx(reduced.width / 20, abs=1)


def test_places_in_a_figure_have_two_decimals_and_scales_all():
    path = b'<path id="line-1.2345" d="M 1.23456 -0.98765e-3 L 10 2.5" transform="scale(0.015625)"/><use x="3.14159"/>'

    kept = b'<path id="line-1.2345" d="M 1.23 -0.98e-3 L 10 2.5" transform="scale(0.015625)"/><use x="3.14"/>'
    assert slim(path) == kept


def test_picture_of_a_section_is_an_image_with_escaped_title():
    image = image_of(Picture('<svg id="a"/>', "a.svg", 'a "b" <c>'))
    assert isinstance(image, Image)

    parts = template_environment(PAGE_FOLDER).get_template("parts.html")
    html = parts.make_module({"image_of": image_of}).figure(image)

    assert 'id="a"' not in html
    assert 'alt="a &#34;b&#34; &lt;c&gt;"' in html
    assert base64.b64encode(b'<svg id="a"/>').decode() in html


def test_sections_of_studies_are_composed_and_may_be_absent(monkeypatch):
    run = Run(folder=Path(), configuration="distributed", slew=False, seed=1)

    def too_short(_):
        raise InputError("too short")

    listed = (
        ("Good", lambda _: [Heading(2, "Good"), Paragraph("fine")]),
        ("Short", too_short),
        ("Empty", lambda _: []),
    )
    monkeypatch.setattr(of_studies, "SECTIONS", listed)
    result = SimpleNamespace(name="r", run=run)

    assert of_studies.study_sections([result]) == [
        ("Good", [Paragraph("fine")]),
        ("Short", [Paragraph("Not for this run: too short")]),
    ]
    result.run = None
    assert of_studies.study_sections([result]) == []


def test_every_study_has_its_section():
    titles = [title for title, _ in SECTIONS]

    assert titles == ["Pointing budget", "Spectra", "Shadow controller", "Margins", "Estimator health", "Design"]
    assert all(callable(section) for _, section in SECTIONS)


def test_study_table_shows_published_and_simulated_values(tmp_path):
    row = {"row": "slew: settling", "unit": "s", "configuration": "distributed", "published": 30.0,
           "standard_deviation": 5.4, "definition": "how long"}  # fmt: skip
    content = {
        "seeds": [1, 2], "duration": 300.0, "remarks": ["so it is"],
        "published_design_lost_at": {"centralised": [0.03, 0.031], "distributed": [None, 0.015]},
        "rows": [row | {"variant": "as_published", "mean": 33.5, "deviation": "+12 ± 5 %"},
                 row | {"variant": "corrected", "mean": 2.0, "deviation": None, "standard_deviation": None}],
    }  # fmt: skip
    (tmp_path / "table.json").write_text(json.dumps(content))

    blocks = study_table(tmp_path)
    (table,) = [block for block in blocks if isinstance(block, Table)]

    assert table.header[2:] == (
        "published", "flown as published", "deviation", "flown corrected, robust", "definition"
    )  # fmt: skip
    assert table.rows == [["slew: settling", "s", "30", "33.5 ± 5.4", "+12 ± 5 %", "2", "how long"]]
    lost = "centralised: lost at 0.03 to 0.031 s; distributed: lost in 1 of 2"
    assert Paragraph(f"Published design on the full plant, fine pointing: {lost}.") in blocks


def test_figures_and_page_use_the_same_colours():
    script = PAGE_FOLDER / "colours.js"
    text = script.read_text()
    assert all(look.colour.lower() in text for look in drawing.LOOKS.values())
