"""The report on a phone, on a dark screen and for a screen reader: no finding, no overlap, within its limits."""

import os
import shutil

import pytest

CHROMIUM = shutil.which("chromium") or shutil.which("google-chrome")
SIZES = {"desktop": {"width": 1400, "height": 900}, "phone": {"width": 400, "height": 800}}
LARGEST = 15_000_000  # bytes of a page
# boxes of texts within one panel or table cell that lie on each other by more than two pixels
OVERLAPS = """() => {
  const found = [];
  for (const box of document.querySelectorAll(".panel header, nav, .controls")) {
    const boxes = [...box.querySelectorAll("h3, select, button, label, a")].filter((one) => one.offsetParent)
      .map((one) => [one, one.getBoundingClientRect()]);
    for (const [a, p] of boxes) for (const [b, q] of boxes) {
      if (a === b || a.contains(b) || b.contains(a)) continue;
      const wide = Math.min(p.right, q.right) - Math.max(p.left, q.left);
      const high = Math.min(p.bottom, q.bottom) - Math.max(p.top, q.top);
      if (wide > 2 && high > 2) found.push(`${a.textContent} / ${b.textContent}`);
    }
  }
  return found;
}"""
REACHED = (
    """() => { const one = document.activeElement; return one === document.body ? "" : `${one.tagName} ${one.id}`; }"""
)

pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="no chromium here; `apt-get install chromium` on Debian")
axe = pytest.importorskip("axe_playwright_python.sync_playwright", reason="axe-playwright-python is not installed")


@pytest.fixture(scope="module")
def page_file(tmp_path_factory, fmus, flexsat):
    """Return the report of a run of 12 s, with all sections that it has room for."""
    folder = tmp_path_factory.mktemp("results") / "run"
    for words in (("run", fmus / "distributed" / "fine_pointing.ssd", "--native", "--stop-time", "12", "--out", folder),
                  ("report", folder)):  # fmt: skip
        done = flexsat(*words, timeout=300.0)
        assert done.returncode == 0, done.stderr
    return folder / "report.html"


@pytest.fixture(scope="module")
def browser():
    """Start Debian's Chromium."""
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        options = ["--no-sandbox"] if os.geteuid() == 0 else []
        started = playwright.chromium.launch(executable_path=CHROMIUM, args=options)
        yield started
        started.close()


@pytest.fixture
def opened(browser, page_file):
    """Return a function that opens the page."""
    pages = []

    def open_(size, scheme):
        page = browser.new_page(viewport=SIZES[size], color_scheme=scheme)
        pages.append(page)
        page.goto(page_file.resolve().as_uri())
        page.wait_for_selector("html[data-ready]", state="attached")
        return page

    yield open_
    for page in pages:
        page.close()


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("size", SIZES)
def test_axe_has_no_finding_and_nothing_overlaps(opened, size, scheme):
    """Contrast, names of controls, order of headings and the like, by the rules of axe-core; WCAG 2 A and AA."""
    page = opened(size, scheme)

    findings = [(one["id"], one["impact"], [node["target"] for node in one["nodes"]][:3])
                for one in axe.Axe().run(page).response["violations"]]  # fmt: skip
    assert findings == []
    assert page.evaluate(OVERLAPS) == []
    assert page.evaluate("document.documentElement.scrollWidth") <= SIZES[size]["width"]


def test_a_dark_screen_draws_in_light_ink_and_paper_in_dark(opened):
    page = opened("desktop", "dark")
    ink = "colour => getComputedStyle(document.body).getPropertyValue('--ink').trim()"

    assert page.evaluate(ink) == "#e3e8ee"
    page.emulate_media(media="print")
    assert page.evaluate(ink) == "#1d2530"


def test_the_keyboard_reaches_every_control(opened):
    page = opened("desktop", "light")
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


def test_a_table_keeps_its_header_and_the_file_its_size(opened, page_file):
    page = opened("desktop", "light")

    assert page.locator("#numbers thead").first.is_visible()
    assert "steady part: RMS" in page.locator("#numbers thead").first.inner_text()
    assert page.locator("figcaption").count() > 1
    assert page_file.stat().st_size < LARGEST
