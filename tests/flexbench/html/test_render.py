"""Documents as HTML and Markdown: texts are escaped, names between backticks are code, line breaks are kept."""

from __future__ import annotations

import jinja2
import lxml.html
import pytest

from flexbench.html.document import Heading, Listing, Paragraph, Picture, Table, as_markdown
from flexbench.html.render import as_html, template_environment


def test_texts_are_escaped():
    blocks = [Heading(1, "a < b"), Paragraph("x & y"), Table(("p|q",), [["<i>|"]], frozenset())]
    page = as_html(blocks)
    assert "<title>a &lt; b</title>" in page
    assert "x &amp; y" in page
    assert "&lt;i&gt;|" in page
    assert "| <i>\\| |" in as_markdown(blocks)


def test_blocks_become_elements_with_their_texts():
    text = "\n  first\n\n<last>  "
    blocks = [
        Heading(1, "title"),
        Heading(3, "part <1>"),
        Paragraph("set `a<b` and `c`, not ` alone"),
        Listing(text),
        Table(("name", "value"), [["p[1]", "1 & 2"], ["", "<3>"]]),
        Picture('<svg id="drawing"></svg>', "file.svg", "a drawing"),
    ]
    body = lxml.html.fromstring(as_html(blocks)).body

    assert body.find("h3").text == "part <1>"
    paragraph = body.find("p")
    assert [code.text for code in paragraph.findall("code")] == ["a<b", "c"]
    assert paragraph.text_content() == "set a<b and c, not ` alone"
    assert body.find("pre").text == "\n" + text  # a browser drops the first line break
    assert [th.text for th in body.iter("th")] == ["name", "value"]
    assert [
        [(cell.find("code") is not None, cell.text_content()) for cell in row] for row in body.find(".//tbody")
    ] == [
        [(True, "p[1]"), (False, "1 & 2")],
        [(False, ""), (False, "<3>")],  # an empty name is no code
    ]
    assert body.find("svg").get("id") == "drawing"


def test_unknown_name_in_a_template_is_an_error(tmp_path):
    (tmp_path / "bad.html").write_text("{{ nothing }}")
    with pytest.raises(jinja2.UndefinedError, match="nothing"):
        template_environment(tmp_path).get_template("bad.html").render()


@pytest.mark.parametrize(
    ("text", "kept"),
    [("1.44e-3 (5.42e-3)", True), ("+175 ± 64 %", True), ("-0.1", True), ("steady part", False), ("", False),
     ("2 wheels at their limit of torque", False)],
)  # fmt: skip
def test_a_number_does_not_break_over_two_lines(text, kept):
    page = as_html([Heading(1, "t"), Table(("a",), [[text]], code=frozenset())])

    cell = lxml.html.fromstring(page).find(".//td")
    assert (cell.get("class") == "n") is kept
