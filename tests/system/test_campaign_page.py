"""The page of a campaign in a browser without network: plots, brushing by pointer and keyboard, dark, phone, print."""

import numpy as np
import pyarrow.parquet as pq
import pytest
from numpy.testing import assert_allclose

from browser_pages import CANVAS_FAULTS, FAULTS, PHONE, ink, needs_browser, settle
from campaign_folder import ARCSECOND, write_campaign
from flexbench.report.campaigns import write_campaign_page

INK = ink("alpha > 0")
pytestmark = needs_browser


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Return a campaign of two systems with its page."""
    made = write_campaign(tmp_path_factory.mktemp("campaign"), systems=("distributed", "centralised"), times=2000)
    write_campaign_page(made)
    return made


def cell(page, name):
    return page.locator(f"canvas[data-cell='{name}']")


def selected(page):
    settle(page)
    words = page.locator("#selected").inner_text().split()
    return int(words[0]) if words else None


def test_every_metric_is_drawn_and_the_matrix_has_its_cells(folder, open_page):
    page = open_page(folder / "report.html")

    assert page.title() == "Campaign toy"
    assert page.locator("h2").all_inner_texts() == [
        "Summary", "Requirements", "Metrics", "Worst runs", "Scatter matrix", "Sensitivities",
        "Time histories of all runs", "What was simulated",
    ]  # fmt: skip
    plots = page.locator("#distributions canvas")
    assert [plot.get_attribute("data-runs") for plot in plots.all()] == ["297,297", "294,294", "297,297"]
    table = pq.read_table(folder / "results.parquet").to_pandas()
    most = [float(text) for text in plots.first.get_attribute("data-most").split(",")]
    assert_allclose(most, table.groupby("system", sort=False)["metric.pointing"].max() / ARCSECOND, rtol=1e-9)
    assert all(plot.evaluate(INK) > 1000 for plot in plots.all())
    cells = page.locator("#cells canvas")
    assert cells.count() == 6 * 7 / 2
    assert all(one.evaluate(INK) > 300 for one in cells.all())
    assert page.locator("#cells .pair").count() == 6 * 5 / 2
    before = plots.first.evaluate("canvas => canvas.toDataURL()")
    page.locator("input[value=cumulative]").check()
    assert plots.first.evaluate("canvas => canvas.toDataURL()") != before


def test_a_rectangle_selects_runs_in_all_plots(folder, open_page):
    page = open_page(folder / "report.html")
    target = cell(page, "settling/pointing")
    target.scroll_into_view_if_needed()
    box = target.bounding_box()

    def at(share):
        return box["x"] + 3 + share * (box["width"] - 6)

    # from a quarter to half of the range of pointing, over all that have settled
    page.mouse.move(at(0.25), box["y"] + 1)
    page.mouse.down()
    page.mouse.move(at(0.5), box["y"] + box["height"] - 1, steps=4)
    page.mouse.up()
    table = pq.read_table(folder / "results.parquet").to_pandas()[:300]
    pointing, settling = table["metric.pointing"], table["metric.settling"]
    share = (pointing - pointing.min()) / (pointing.max() - pointing.min())
    inside = (share >= 0.25) & (share <= 0.5) & np.isfinite(settling)
    assert 50 < inside.sum() < 250
    assert abs(selected(page) - inside.sum()) <= 5  # a pixel of each edge
    assert int(cell(page, "frequency/inertia").get_attribute("data-selected")) == selected(page)
    assert int(page.locator("#distributions canvas").first.get_attribute("data-selected")) == selected(page)
    listed = page.locator("#runs-selected tbody tr")
    assert listed.count() == min(20, selected(page))
    numbers = {int(text) for text in page.locator("#runs-selected tbody td:first-child").all_inner_texts()}
    assert len(numbers - set(table["number"][inside])) <= 2
    page.locator("#clear").click()
    assert selected(page) is None
    assert listed.count() == 0


def test_the_keyboard_selects_moves_and_clears(folder, open_page):
    page = open_page(folder / "report.html")
    target = cell(page, "momentum/settling")
    target.focus()
    page.keyboard.press("Enter")
    begun = selected(page)
    assert begun > 0
    for _ in range(6):
        page.keyboard.press("Shift+ArrowUp")
        page.keyboard.press("Shift+ArrowRight")
    assert selected(page) > begun
    page.keyboard.press("ArrowLeft")
    assert selected(page) != begun
    page.keyboard.press("Escape")
    assert selected(page) is None
    reached = page.evaluate("""() => {
      const controls = "#cells canvas:not(.diagonal), #bands-plots canvas, select, input, button, summary";
      return [...document.querySelectorAll(controls)].every((one) => one.hidden || one.tabIndex === 0); }""")
    assert reached


def test_another_system_and_other_columns_lay_the_matrix_anew(folder, open_page):
    page = open_page(folder / "report.html")
    picture = cell(page, "settling/pointing").evaluate("canvas => canvas.toDataURL()")
    page.locator("#system").select_option("1")
    settle(page)
    assert cell(page, "settling/pointing").evaluate("canvas => canvas.toDataURL()") != picture
    page.locator("#variables input[value='input.damping']").uncheck()
    assert page.locator("#cells canvas").count() == 5 * 6 / 2
    cell(page, "settling/pointing").focus()
    page.keyboard.press("Enter")
    assert selected(page) > 0
    numbers = [int(text) for text in page.locator("#runs-selected tbody td:first-child").all_inner_texts()]
    assert all(number > 300 for number in numbers)  # runs of the other system
    page.locator("#variables input[value='input.camera']").check()
    assert cell(page, "camera").evaluate(INK) > 300
    cell(page, "camera/settling").focus()
    page.keyboard.press("Enter")
    settle(page)
    texts = page.locator("#runs-selected tbody td:last-child").all_inner_texts()
    assert set(texts) <= {"narrow", "wide"}
    assert texts


def test_bands_are_drawn_to_their_peak_and_read_by_arrows(folder, open_page):
    page = open_page(folder / "report.html")
    plots = page.locator("#bands-plots canvas")
    assert plots.count() == 2
    most = pq.read_table(folder / "bands.parquet")["largest"].to_numpy().max()
    assert_allclose(float(plots.first.get_attribute("data-most")), most, rtol=1e-6)
    plots.first.focus()
    page.keyboard.press("ArrowRight")
    text = page.locator("#band-readout").inner_text()
    assert text.startswith("0.9 s: least")  # a hundredth of 99.9 s, at the last time kept before it
    page.locator("#signal").select_option("rate error")
    assert page.locator("#bands-plots h3").first.inner_text() == "rate error, distributed"


def test_dark_phone_and_print(folder, open_page, tmp_path):
    dark = open_page(folder / "report.html", scheme="dark")
    assert dark.evaluate("getComputedStyle(document.body).backgroundColor") == "rgb(22, 27, 34)"
    contrast = dark.evaluate("""() => {
      const light = (text) => { const c = text.match(/[0-9.]+/g).slice(0, 3).map((v) => v / 255)
          .map((v) => (v <= 0.03928 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4));
        return 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2]; };
      const behind = (one) => { for (; one; one = one.parentElement) { const c = getComputedStyle(one).backgroundColor;
        if (!c.endsWith(", 0)")) return c; } return "rgb(255, 255, 255)"; };
      return Math.min(...[...document.querySelectorAll("p, td, th, h2, h3, a, label, summary, code, .chip")]
        .filter((one) => one.offsetParent && one.textContent.trim())
        .map((one) => { const [a, b] = [light(getComputedStyle(one).color), light(behind(one))];
          return (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05); })); }""")
    assert contrast >= 4.5  # WCAG 2.1, level AA
    dark.emulate_media(media="print")
    assert dark.evaluate("getComputedStyle(document.body).backgroundColor") == "rgb(255, 255, 255)"

    phone = open_page(folder / "report.html", PHONE)
    assert phone.evaluate("document.documentElement.scrollWidth") <= 400
    assert phone.evaluate(FAULTS) == []
    assert phone.evaluate(CANVAS_FAULTS) == []
    assert all(plot.evaluate(INK) > 500 for plot in phone.locator("#distributions canvas").all())
    phone.pdf(path=tmp_path / "page.pdf", format="A4")
    assert (tmp_path / "page.pdf").stat().st_size > 20_000
