"""The report on a phone, on a dark screen and for a screen reader: no finding, no overlap, within its limits."""

import pytest

from browser_pages import CANVAS_FAULTS, FAULTS, PHONE, WIDE, needs_browser, settle
from flexbench.report import study_sections, write_report

SIZES = {"desktop": WIDE, "phone": PHONE}
LARGEST = 15_000_000  # bytes of a page
REACHED = (
    """() => { const one = document.activeElement; return one === document.body ? "" : `${one.tagName} ${one.id}`; }"""
)
# what a page may do until it can be used. A run of 300 s: 2.4 million letters, 1,500 elements, 3,800 points; six such
# runs: .8 million, 2,400 and 10,900. Their scripts took .35 and .5 s in Chromium, on a machine with a load of 25
DECODED, ELEMENTS, POINTS = 4_000_000, 8_000, 60_000  # letters of base64, elements, points drawn

pytestmark = needs_browser
axe = pytest.importorskip("axe_playwright_python.sync_playwright", reason="axe-playwright-python is not installed")


@pytest.fixture(scope="module")
def page_files(slews, tmp_path_factory):
    """Return the report of one run with all sections, and one of two runs without those of studies."""
    both = tmp_path_factory.mktemp("both") / "both.html"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(study_sections, "SECTIONS", ())
        write_report([slews / "distributed-slew", slews / "centralised-slew"], both)
    return {"one run": slews / "distributed-slew" / "report.html", "two runs": both}


@pytest.fixture
def opened(open_page, page_files):
    """Return a function that opens the page of one run or of two."""
    return lambda size, scheme="light", of="one run": open_page(page_files[of], SIZES[size], scheme)


@pytest.mark.parametrize(
    ("of", "size", "scheme"),
    [  # each pair of page, size and scheme: contrast is a matter of the scheme alone, and overlap of the size
        ("one run", "desktop", "light"),
        ("one run", "phone", "dark"),
        ("two runs", "desktop", "dark"),
        ("two runs", "phone", "light"),
    ],
)
def test_axe_has_no_finding_and_no_text_is_cut_off_or_overlaps(opened, size, scheme, of):
    """Contrast, names of controls, order of headings and the like, by the rules of axe-core; WCAG 2 A and AA."""
    page = opened(size, scheme, of)
    if of == "two runs":
        page.locator("#runs .chip").last.click()  # a run that is hidden is still named
    page.locator("#signals input[value='plant.wheel.speed']").check()
    settle(page)

    findings = [(one["id"], one["impact"], [node["target"] for node in one["nodes"]][:3])
                for one in axe.Axe().run(page).response["violations"]]  # fmt: skip
    assert findings == []
    assert page.evaluate(FAULTS) == []
    assert page.evaluate(CANVAS_FAULTS) == []
    assert page.evaluate("document.documentElement.scrollWidth") <= SIZES[size]["width"]


def test_a_dark_screen_draws_in_light_ink_and_paper_in_dark(opened):
    page = opened("desktop", "dark")
    ink = "colour => getComputedStyle(document.body).getPropertyValue('--ink').trim()"

    assert page.evaluate(ink) == "#e3e8ee"
    page.emulate_media(media="print")
    assert page.evaluate(ink) == "#1d2530"
    assert page.evaluate(FAULTS) == []


HALOS = """() => new Promise((done) => {
  const pen = CanvasRenderingContext2D.prototype, { strokeText } = pen, found = new Set();
  pen.strokeText = function (...given) { found.add(this.strokeStyle); return strokeText.apply(this, given); };
  window.dispatchEvent(new Event("resize"));
  requestAnimationFrame(() => requestAnimationFrame(() => { pen.strokeText = strokeText; done([...found]); }));
})"""


@pytest.mark.parametrize(("scheme", "paper"), [("light", "rgba(255, 255, 255, 0."), ("dark", "rgba(22, 27, 34, 0.")])
def test_marks_of_plots_stand_on_the_colour_of_the_page(opened, scheme, paper):
    page = opened("desktop", scheme)

    (halo,) = page.evaluate(HALOS)
    assert halo.startswith(paper)


def test_the_keyboard_reaches_every_control(opened):
    page = opened("desktop")
    wanted = page.evaluate("""() => [...document.querySelectorAll("button, select, input, a[href], canvas[tabindex]")]
      .filter((one) => one.offsetParent && !one.disabled).length""")
    reached = 0
    page.locator("body").focus()
    for _ in range(4 * wanted):
        page.keyboard.press("Tab")
        where = page.evaluate(REACHED)
        if not where:
            break
        reached += where.split()[0] in ("BUTTON", "SELECT", "INPUT", "A", "CANVAS")
    assert reached >= wanted


def test_the_keyboard_turns_and_plays_the_structure(opened):
    page = opened("desktop")
    scene = page.locator("#scene")
    scene.focus()
    pictures = [scene.evaluate("canvas => canvas.toDataURL()")]
    for key in ("ArrowLeft", "ArrowUp", "+"):
        page.keyboard.press(key)
        settle(page)
        pictures.append(scene.evaluate("canvas => canvas.toDataURL()"))
    assert len(set(pictures)) == 4


def test_a_table_keeps_its_header_and_no_two_tables_differ_without_their_windows(opened):
    page = opened("desktop")

    header = page.locator("#numbers thead").first
    assert header.is_visible()
    assert "slew: RMS" in header.inner_text()
    text = page.locator("#numbers").inner_text()
    assert "slew, 4.85 to" in text
    assert "Windows follow each run" in text
    assert page.locator("#numbers table").count() == 1


@pytest.mark.parametrize("of", ["one run", "two runs"])
def test_a_page_is_small_and_does_little_before_it_can_be_used(opened, page_files, of):
    assert page_files[of].stat().st_size < LARGEST
    page = opened("desktop", of=of)
    points = page.locator("canvas.plot").evaluate_all("all => all.reduce((sum, one) => sum + +one.dataset.points, 0)")

    assert page.locator("figcaption").count() > 1
    assert page.evaluate("document.querySelectorAll('*').length") < ELEMENTS
    assert page.evaluate("window.decoded") < DECODED  # a history is decoded when it is first drawn
    assert points < POINTS
