"""The report page in a browser without network, on a wide screen and on a phone."""

import json
import shutil
import subprocess
import sys
from itertools import pairwise
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from numpy.testing import assert_allclose

import flexbench
from browser_pages import PHONE, WIDE, ink, needs_browser, settle
from flexbench.report import compose, study_sections, write_report
from flexbench.runs.histories import pointing_error
from flexsat.description.built_in import configuration
from flexsat.parameters import ARCSECOND
from flexsat.spacecraft.flexible import structure_of
from lockstep import Component, System, read_signals, write_ssd

ROOT = Path(__file__).parents[2]
MODES = 198  # of the plant: the quantity with the most lines
INK = ink("alpha > 0 && blue - red > 60")  # blue, the colour of the first line


@pytest.fixture(scope="module")
def runs(slews):
    """Return the folder of two runs of 8 s."""
    return slews


@pytest.fixture(scope="module")
def page_file(slews):
    """Return the report of one run."""
    return slews / "distributed-slew" / "report.html"


@pytest.fixture
def report(monkeypatch):
    """Return a function that writes a page without what takes seconds and other pages have.

    These are the sections of other studies and the figures, which pages of `test_report_access.py` show for two runs.
    """
    monkeypatch.setattr(study_sections, "SECTIONS", ())
    monkeypatch.setattr(compose, "drawn_images", lambda _: [])
    return write_report


def plots(page):
    return page.locator("canvas.plot")


def shown(page):
    """Return the time that the plots show [s]."""
    return [float(word) for word in page.locator("#shown").inner_text().replace("s", "").split(" to ")]


def drawn(page, what):
    return [float(canvas.get_attribute(f"data-{what}")) for canvas in plots(page).all()]


@needs_browser
def test_the_page_opens_with_its_plots(page_file, open_page):
    page = open_page(page_file, WIDE)

    assert page.title() == "distributed-slew"
    headings = page.locator("h2").all_inner_texts()
    assert headings[0] == "In short"  # what was flown and the answer; the bookkeeping is last
    assert headings[-3:] == ["Records of the runs", "System", "Versions and hashes"]
    assert {"Time histories", "The structure in motion", "Figures"} <= set(headings)
    assert "arcsec RMS" in page.locator("#answer").inner_text()
    assert plots(page).count() == 4
    assert all(canvas.evaluate(INK) > 100 for canvas in plots(page).all())
    assert all(page.locator("figure img").evaluate_all("images => images.map(i => i.complete && i.naturalWidth > 100)"))
    keep = ROOT / "results" / "report"
    keep.mkdir(parents=True, exist_ok=True)
    page.screenshot(path=keep / "wide.png", full_page=True)


@needs_browser
def test_slider_shows_the_recorded_deflection(page_file, open_page, runs):
    page = open_page(page_file, WIDE)
    signals = read_signals(runs / "distributed-slew", ["plant.modal.displacement"])
    config = configuration("distributed")
    shape = structure_of(config).deflection[:, 2]
    scene, slider = page.locator("#scene"), page.locator("#frame")
    frames = int(slider.get_attribute("max")) + 1
    assert frames == len(signals.time)
    assert "Every recorded row" in page.locator("#sampling").inner_text()
    pictures = set()

    for frame in (0, frames // 2, frames - 1):
        slider.evaluate("(slider, k) => { slider.value = k; slider.dispatchEvent(new Event('input')); }", frame)
        settle(page)
        pictures.add(scene.evaluate("canvas => canvas.toDataURL()"))
        largest = np.abs(shape @ signals["plant.modal.displacement"][frame]).max()
        # 16 bits of the largest of each mode
        room = 1e-4 * np.abs(shape @ np.abs(signals["plant.modal.displacement"]).max(axis=0)).max()
        assert_allclose(float(scene.get_attribute("data-largest")), largest, atol=room)
        result = float(page.locator("#moment").inner_text().split()[2])
        assert abs(result - signals.time[frame]) < 0.006  # printed to 10 ms
    assert len(pictures) == 3


@needs_browser
def test_the_structure_can_be_played_turned_and_exaggerated(page_file, open_page):
    page = open_page(page_file, WIDE)
    scene = page.locator("#scene")

    def picture():
        settle(page)
        return scene.evaluate("canvas => canvas.toDataURL()")

    first = picture()
    page.locator("#exaggeration").evaluate("s => { s.value = +s.value + 0.5; s.dispatchEvent(new Event('input')); }")
    exaggerated = picture()
    page.locator("#turned").check()
    tilted = picture()
    page.locator("#fit").click()
    scene.scroll_into_view_if_needed()
    box = scene.bounding_box()
    page.mouse.move(box["x"] + 300, box["y"] + 200)
    page.mouse.down()
    page.mouse.move(box["x"] + 420, box["y"] + 240)
    page.mouse.up()
    turned = picture()
    assert len({first, exaggerated, tilted, turned}) == 4

    page.locator("#frame").evaluate("s => { s.value = 0; s.dispatchEvent(new Event('input')); }")
    page.locator("#play").click()
    page.wait_for_function("() => Number(document.getElementById('scene').dataset.frame) > 3")
    page.locator("#play").click()
    settle(page)
    stopped = scene.get_attribute("data-frame")
    page.wait_for_timeout(150)
    assert scene.get_attribute("data-frame") == stopped


@needs_browser
def test_plots_show_every_peak_with_few_points(page_file, open_page, runs):
    page = open_page(page_file, WIDE)
    signals = read_signals(runs / "distributed-slew")
    error = pointing_error(signals) / ARCSECOND
    wheels = [signals.columns[f"plant.wheel.speed[{k}]"] for k in range(1, 34)]
    page.locator("#signals input[value='plant.wheel.speed']").check()
    settle(page)

    most, points = drawn(page, "most"), drawn(page, "points")
    assert_allclose(most[0], error.max(), rtol=1e-6)  # single precision
    assert_allclose(most[2], signals["plant.rms_deformation"].max() * 1e6, rtol=1e-6)
    assert_allclose(most[4], np.max(wheels), rtol=1e-6)
    width = plots(page).first.bounding_box()["width"]
    lines = [1, 1, 1, 1, 33]
    assert all(count <= 2 * 1.6 * width * many + 10 * many for count, many in zip(points, lines, strict=True))


@needs_browser
def test_zoom_by_dragging_and_back(page_file, open_page):
    page = open_page(page_file, WIDE)
    whole = shown(page)
    plots(page).first.scroll_into_view_if_needed()
    box = plots(page).first.bounding_box()
    left, width = box["x"] + 62, box["width"] - 72  # the margins of a plot

    page.mouse.move(left + 0.5 * width, box["y"] + 80)
    page.mouse.down()
    page.mouse.move(left + 0.6 * width, box["y"] + 80, steps=3)
    page.mouse.up()
    settle(page)
    assert_allclose(shown(page), [whole[1] * 0.5, whole[1] * 0.6], atol=0.01 * whole[1])
    plots(page).first.press("ArrowRight")
    assert shown(page)[0] > whole[1] * 0.51
    page.locator("[data-act=in]").click()
    assert shown(page)[1] - shown(page)[0] < 0.06 * whole[1]
    plots(page).first.dblclick()
    assert shown(page) == whole


@needs_browser
def test_click_in_a_plot_shows_the_structure_at_that_time(page_file, open_page):
    page = open_page(page_file, WIDE)
    box = plots(page).first.bounding_box()

    plots(page).first.click(position={"x": 62 + 0.25 * (box["width"] - 72), "y": 60})
    settle(page)
    result = page.locator("#moment").inner_text()
    assert abs(float(result.split()[2]) - 0.25 * 8.0) < 0.05


@needs_browser
def test_signals_are_picked_filtered_and_hidden(page_file, open_page):
    page = open_page(page_file, WIDE)
    page.locator("#filter").fill("reference attitude")
    (found,) = page.locator("#signals label:visible").all_inner_texts()
    assert found.split() == ["controller.reference.mrp", "3", "\u00d7", "[1]"]
    page.locator("#signals label:visible input").check()
    panel = page.locator(".panel").last
    before = drawn(page, "points")[-1]

    panel.locator(".chip").first.click()
    settle(page)
    assert 0.5 * before < drawn(page, "points")[-1] < 0.8 * before  # two of three, one of which may be constant
    panel.locator("select").select_option("plant.attitude.mrp")  # over it: the same unit
    settle(page)
    assert drawn(page, "points")[-1] > before
    panel.locator("button[aria-label='remove this plot']").click()
    assert plots(page).count() == 4
    assert not page.locator("#signals input[value='controller.reference.mrp']").is_checked()


@needs_browser
def test_on_a_phone(page_file, open_page):
    page = open_page(page_file, PHONE)

    assert page.evaluate("document.documentElement.scrollWidth") <= 400
    assert all(canvas.evaluate(INK) > 100 for canvas in plots(page).all())
    before = page.locator("#scene").evaluate("canvas => canvas.toDataURL()")
    page.locator("#frame").evaluate("s => { s.value = 5; s.dispatchEvent(new Event('input')); }")
    settle(page)
    assert page.locator("#scene").evaluate("canvas => canvas.toDataURL()") != before
    keep = ROOT / "results" / "report"
    keep.mkdir(parents=True, exist_ok=True)
    page.screenshot(path=keep / "phone.png", full_page=True)


@needs_browser
def test_two_runs_are_compared(runs, report, open_page, tmp_path):
    report([runs / "distributed-slew", runs / "centralised-slew"], tmp_path / "both.html")
    page = open_page(tmp_path / "both.html", WIDE)

    assert page.title() == "2 runs compared"
    assert page.locator("#runs .chip").all_inner_texts() == ["distributed-slew", "centralised-slew"]
    both = drawn(page, "points")
    page.locator("#runs .chip").first.click()
    settle(page)
    assert all(0.4 * two < one < 0.6 * two for one, two in zip(drawn(page, "points"), both, strict=True))
    discs = page.locator("#scene").evaluate("canvas => canvas.toDataURL()")
    page.locator("#which").select_option("1")
    assert page.locator("#scene").evaluate("canvas => canvas.toDataURL()") != discs
    assert page.evaluate("document.documentElement.scrollWidth") <= WIDE["width"]


@needs_browser
def test_faults_are_listed_and_marked(runs, report, open_page, tmp_path):
    folder = tmp_path / "faulty"
    shutil.copytree(runs / "centralised-slew", folder)
    fault = {"time": 4.0, "event": "fault", "state": "begin", "name": "wheel 3 stuck", "kind": "stuck"}
    fault |= {"component": "plant", "variables": ["wheel.torque[3]"], "values": {}}
    with (folder / "events.jsonl").open("a") as events:
        events.write(json.dumps(fault) + '\n{"time": 9.0, "eve')  # and half a line, as a killed run leaves it
    report([folder])
    page = open_page(folder / "report.html", WIDE)

    assert "1 fault events." in page.locator("#events").inner_text()
    assert "wheel 3 stuck" in page.locator("#events").inner_text()
    assert plots(page).first.evaluate(ink("red > 150 && green < 60 && blue < 90")) > 20


@needs_browser
def test_another_system_gets_a_report_without_spacecraft_sections(tmp_path, flexsat, open_page):
    slaves = ROOT / "tests" / "lockstep" / "slaves" / "build.py"
    subprocess.run([sys.executable, str(slaves), str(tmp_path)], check=True, capture_output=True)
    counter = Component(name="counter", source=tmp_path / "toy_counter.fmu", period=1_000_000, kind="sampled")
    write_ssd(System(name="foreign", tick=1_000_000, stop_time=500_000_000, components=(counter,), connections=(),
                     record=("all",)), tmp_path / "foreign.ssd")  # fmt: skip
    ran = subprocess.run(
        [sys.executable, "-m", "lockstep", "run", str(tmp_path / "foreign.ssd"), "--out", str(tmp_path / "run")],
        check=False, capture_output=True, text=True,
    )  # fmt: skip
    assert ran.returncode == 0, ran.stderr
    done = flexsat("report", tmp_path / "run")
    assert done.returncode == 0, done.stderr
    page = open_page(tmp_path / "run" / "report.html", WIDE)

    headings = page.locator("h2").all_inner_texts()
    assert headings[0] == "Summary"
    assert {"Time histories", "System"} <= set(headings)
    assert not {"The structure in motion", "Pointing budget"} & set(headings)
    assert plots(page).count() >= 1
    assert plots(page).first.evaluate(INK) > 50


def repeat(short, folder, times):
    """Leave a run of 300 s: one of 8 s again and again, never quite the same, with a single peak in each signal."""
    folder.mkdir()
    table = pq.read_table(short / "signals.parquet")
    rng = np.random.default_rng(1)
    rows = table.num_rows * times
    columns = [np.arange(rows) * 0.005]
    for name in table.column_names[1:]:
        column = np.tile(table[name].to_numpy(), times) * (1.0 + 0.1 * rng.random(rows))
        column[rng.integers(rows)] += 3.0 * np.abs(column).max()
        columns.append(column)
    pq.write_table(pa.table(columns, schema=table.schema), folder / "signals.parquet")
    text = (short / "run.toml").read_text()
    (folder / "run.toml").write_text(text.replace("simulated_time = 8.0", "simulated_time = 300.0"))


def see_every_row_at_the_end(page, signals):
    """Look at the wheels' torque, of which the page has extremes of intervals, in the last window with every row."""
    box = page.locator("#signals input[value='controller.wheel.torque']")
    box.check()
    settle(page)
    assert "extremes of intervals" in page.locator("#rate").inner_text()
    page.locator("#windows button", has_text="end of the run").click()
    settle(page)
    assert "every recorded row" in page.locator("#rate").inner_text()
    last = signals["controller.wheel.torque"][signals.time >= signals.time[-1] - 2.0]
    assert drawn(page, "points")[4] == last.size
    assert_allclose(drawn(page, "most")[4], np.float32(last.max()), rtol=1e-7)
    page.locator("[data-act=all]").click()
    box.uncheck()


@pytest.mark.slow
@needs_browser
def test_page_of_a_long_run_is_small_and_keeps_every_peak(tmp_path, runs, report, open_page):
    """`test_paper.py` does it with all sections."""
    folder = tmp_path / "long"
    repeat(runs / "distributed-slew", folder, times=38)
    report([folder])
    assert (folder / "report.html").stat().st_size < 15_000_000
    page = open_page(folder / "report.html", WIDE)
    signals = flexbench.load(folder)
    see_every_row_at_the_end(page, signals)
    names = ("plant.rate", "plant.modal.velocity", "controller.wheel.torque")  # kept as extremes of intervals
    for name in names:
        page.locator(f"#signals input[value='{name}']").check()
    settle(page)

    for k, name in enumerate(names):
        # rounded outwards to single precision
        assert_allclose(drawn(page, "most")[4 + k], float(signals[name].max()), rtol=2e-7)
    assert_allclose(drawn(page, "most")[0], float(pointing_error(read_signals(folder)).max()) / ARCSECOND, rtol=1e-6)
    width = plots(page).first.bounding_box()["width"]
    assert max(drawn(page, "points")) <= MODES * (2 * 1.6 * width + 10)
    for a, b in pairwise(("in", "in", "in")):
        page.locator(f"[data-act={a}]").click()
        page.locator(f"[data-act={b}]").click()
    settle(page)
    assert max(drawn(page, "points")) <= MODES * (2 * 1.6 * width + 10)
