"""README and docs: links lead somewhere, every page can be reached, and the README stays one page."""

import re
from pathlib import Path

import pytest

import flexbench
import lockstep
from flexbench.campaign import campaign_file
from flexbench.loop import mission_file
from lockstep.adapter import read as adapter_file

ROOT = Path(__file__).parents[1]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
LINK = re.compile(r"\]\(([^)#\s]+)?(?:#([^)\s]+))?\)")


def outside_code(text):
    """Return a page without its blocks of code."""
    return re.sub(r"^```.*?^```", "", text, flags=re.DOTALL | re.MULTILINE)


def links_of(page):
    """Return the links of a page to files, and the headings that they name."""
    found = LINK.findall(outside_code(page.read_text(encoding="utf-8")))
    return [(target, anchor) for target, anchor in found if not target.startswith(("http://", "https://"))]


def anchors_of(page):
    """Return what links into a page may name: its headings, as GitHub spells them."""
    headings = re.findall(r"^#+ (.*)$", outside_code(page.read_text(encoding="utf-8")), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_lead_to_files_and_headings(page):
    for target, anchor in links_of(page):
        linked = page.parent / target if target else page
        assert linked.exists(), target
        assert not anchor or anchor in anchors_of(linked), f"{target}#{anchor}"


def test_every_page_is_linked_from_the_readme():
    linked = {(ROOT / target).resolve() for target, _ in links_of(ROOT / "README.md") if target}

    assert [page.name for page in PAGES[1:] if page not in linked] == []


def test_the_readme_has_at_most_150_lines():
    assert len((ROOT / "README.md").read_text(encoding="utf-8").splitlines()) <= 150


@pytest.mark.parametrize("package", [lockstep, flexbench])
def test_the_python_interface_has_every_public_name(package):
    page = (ROOT / "docs" / "python.md").read_text(encoding="utf-8")
    assert [name for name in package.__all__ if f":: {package.__name__}.{name}\n" not in page] == []


@pytest.mark.parametrize(
    ("page", "tables"),
    [
        ("campaigns", campaign_file.FILE_KEYS),
        ("foreign_controllers", adapter_file.FILE_KEYS),
        ("missions", mission_file.FILE_KEYS),
    ],
)
def test_a_guide_names_every_key_of_its_file(page, tables):
    text = (ROOT / "docs" / f"{page}.md").read_text(encoding="utf-8")
    keys = {key for keys in tables.values() for key in keys if "=" not in key and key != "component.parameter"}
    assert {key for key in keys if not re.search(rf"(?<![\w-]){re.escape(key)}(?![\w-])", text)} == set()
