"""The page of a campaign: its numbers are those of the runs, its data small, its folder refused if it is none."""

import base64
import json
import re

import lxml.html
import numpy as np
import pyarrow.parquet as pq
import pytest
from numpy.testing import assert_allclose

from campaign_folder import ARCSECOND, write_campaign
from flexbench.campaign.samples import load_bands, load_samples
from flexbench.campaign.statistics.sensitivities import saltelli_points
from flexbench.report.campaigns import write_campaign_page
from flexbench.report.campaigns.page_data import LOST, bands_data, quantised
from lockstep import InputError


def page_of(folder):
    """Return the page of a campaign, its contents and the bytes of its data elements."""
    (page, _), _ = write_campaign_page(folder)
    root = lxml.html.fromstring(page.read_bytes())
    contents = json.loads(root.get_element_by_id("contents").text)

    def column(name, system=0):
        about = next(one for one in contents["systems"][system]["columns"] if one["name"] == name)
        codes = np.frombuffer(base64.b64decode(root.get_element_by_id(about["id"]).text), dtype="<u2")
        values = about["low"] + (about["high"] - about["low"]) * codes / 65534
        return about, np.where(codes == LOST, np.nan, values)

    return root, contents, column


def test_columns_are_those_of_the_runs_to_16_bits(tmp_path):
    folder = write_campaign(tmp_path, systems=("distributed", "centralised"))
    root, contents, column = page_of(folder)
    table = pq.read_table(folder / "results.parquet").to_pandas()

    for system, name in enumerate(("distributed", "centralised")):
        rows = table[table["system"] == name]
        for metric, scale in (("pointing", ARCSECOND), ("settling", 1.0)):
            about, values = column(metric, system)
            true = rows[f"metric.{metric}"].to_numpy() / scale
            true = np.where(np.isfinite(true), true, np.nan)
            assert_allclose(values, true, atol=0.51 * (about["high"] - about["low"]) / 65534)
        numbers = np.frombuffer(
            base64.b64decode(root.get_element_by_id(contents["systems"][system]["numbers"]).text), "<i4"
        )
        assert numbers.tolist() == rows["number"].tolist()
    verdicts = [row[-1].text for row in root.get_element_by_id("requirements").iterfind(".//tbody/tr")]
    assert verdicts == ["shown", "shown", "not met", "shown"]  # centralised points twice as badly
    about, _ = column("pointing")
    assert_allclose([one["most"] for one in about["limits"]], [0.45])
    assert column("momentum")[0]["worse"] == "low"  # its only requirement limits it from below
    assert [len(one["columns"]) for one in contents["systems"]] == [7, 7]
    for system in (0, 1):
        about, values = column("camera", system)  # texts: each category at its place, spread by less than half a place
        assert about["categories"] == ["narrow", "wide"]
        assert (about["low"], about["high"]) == (-0.5, 1.5)
        rows = table[table["system"] == ("distributed", "centralised")[system]]
        assert [about["categories"][round(value)] for value in values] == rows["input.camera"].tolist()
        assert 0.25 < np.max(np.abs(values - np.rint(values))) < 0.301


def test_tables_have_the_numbers_of_the_runs(tmp_path):
    folder = write_campaign(tmp_path)
    root, _, _ = page_of(folder)
    table = pq.read_table(folder / "results.parquet").to_pandas()
    pointing = table["metric.pointing"].to_numpy() / ARCSECOND

    def rows(anchor, which=0):
        found = root.get_element_by_id(anchor).findall(".//table")[which]
        return [[cell.text_content() for cell in row.findall("td")] for row in found.iterfind(".//tbody/tr")]

    name, unit, mean, deviation, text, worst, lost = rows("metrics")[0]
    assert (name, unit, lost) == ("pointing", "arcsec", "3")
    assert_allclose([float(mean), float(deviation), float(worst)],
                    [np.nanmean(pointing), np.nanstd(pointing, ddof=1), np.nanmax(pointing)], rtol=1e-3)  # fmt: skip
    assert_allclose(float(re.match(r"p95 (\S+)", text)[1]), np.sort(pointing)[284], rtol=0.02)
    requirement = rows("requirements")[0]
    met = int(np.sum(pointing <= 0.45))
    assert requirement[:4] == ["line of sight", "<= 0.45 arcsec", "90.0 %", f"{met} of 300"]
    assert requirement[5] == "shown"
    worst_runs = rows("worst")
    assert [row[0] for row in worst_runs[:3]] == ["7", "107", "207"]
    assert worst_runs[0][1] == "failed: controller: crashed at 12.3 s"
    assert int(worst_runs[3][0]) == int(np.nanargmax(pointing)) + 1
    assert rows("worst", 1)[3][1] == "never"  # a settling time that did not come
    assert [row[1] for row in rows("sensitivities")] == ["frequency", "damping", "inertia"]
    content = json.loads((folder / "statistics.json").read_text())
    assert content["answer"][0] == "300 runs, 3 of them failed."
    assert content["systems"][0]["metrics"][0]["percentiles"][3]["value"] is None  # p99 of 300 is among the lost runs


def test_ten_thousand_runs_take_less_than_15_mb_and_the_inputs_that_matter_stay(tmp_path):
    inputs = tuple(f"input{k}" for k in range(120))
    folder = write_campaign(tmp_path, runs=10_000, systems=("a", "b"), inputs=inputs, times=6000)
    root, contents, _ = page_of(folder)

    assert 5_000_000 < (folder / "report.html").stat().st_size < 15_000_000
    kept = [one["name"] for one in contents["systems"][0]["columns"]]
    assert {"pointing", "settling", "momentum", "input0", "input1", "input2"} <= set(kept)
    assert f"{len(kept) - 3} of 121 inputs found room" in root.get_element_by_id("matrix").text_content()
    assert len(contents["bands"]) == 4


def test_of_very_many_runs_plots_show_a_part_with_the_worst_and_tables_all(tmp_path):
    folder = write_campaign(tmp_path, runs=60_000)
    root, contents, column = page_of(folder)
    _, pointing = column("pointing")
    about = contents["systems"][0]

    assert len(pointing) == about["runs"]
    assert 50_000 <= about["runs"] <= 50_030
    table = pq.read_table(folder / "results.parquet")["metric.pointing"].to_pandas()
    assert_allclose(np.nanmax(pointing), table.max() / ARCSECOND)
    assert "Plots show 50000 runs" in root.get_element_by_id("metrics").text_content()
    assert "60000 runs, 600 of them failed." in root.get_element_by_id("summary").text_content()


def test_bands_keep_their_peaks_on_fewer_points(tmp_path):
    folder = write_campaign(tmp_path, times=6000)
    stored = []
    shown, left_out = bands_data(load_bands(folder), lambda text: (stored.append(text), str(len(stored) - 1))[1])

    assert (len(shown), left_out) == (2, [])
    data = {name: np.frombuffer(base64.b64decode(stored[int(key)]), "<f4") for name, key in shown[0]["data"].items()}
    assert len(data["time"]) <= 1200
    (band, _) = load_bands(folder)
    assert_allclose(data["largest"].max(), band.levels["largest"].max(), rtol=1e-6)
    assert_allclose(data["least"].min(), band.levels["least"].min(), rtol=1e-6)
    assert np.all(data["p05"] <= data["p95"])


def test_quantised_values():
    codes, low, high = quantised(np.array([1.0, np.nan, 3.0, np.inf, 2.0]))
    assert (codes.tolist(), low, high) == ([0, LOST, 65534, LOST, 32767], 1.0, 3.0)
    assert quantised(np.array([np.nan]))[0].tolist() == [LOST]
    assert quantised(np.full(3, 5.0))[0].tolist() == [0, 0, 0]


def test_the_sampling_decides_what_is_said_on_bounds(tmp_path):
    for sampling, words in (("latin-hypercube", "not independent"), ("grid", "not random draws"), ("random", "")):
        root, _, _ = page_of(write_campaign(tmp_path / sampling, sampling=sampling))
        text = root.get_element_by_id("summary").text_content()
        assert words in text
        assert ("drawn" in text or "design" in text) == bool(words)


def test_a_saltelli_design_gets_sobol_indices_or_the_reason_why_not(tmp_path):
    folder = write_campaign(tmp_path, runs=5 * 64, sampling="saltelli")
    root, _, _ = page_of(folder)
    text = root.get_element_by_id("sensitivities").text_content()
    assert "4 inputs are no Saltelli design" in text  # the camera is one more

    content = json.loads((folder / "campaign.json").read_text())
    content["inputs"] = content["inputs"][:3]
    table = pq.read_table(folder / "results.parquet")
    points = saltelli_points(3, 64, seed=1)
    columns = {"metric.momentum": points @ [3.0, 0.0, 4.0]}
    for name, values in columns.items():
        table = table.set_column(table.column_names.index(name), name, [values])
    pq.write_table(table, folder / "results.parquet")
    (folder / "campaign.json").write_text(json.dumps(content))
    root, _, _ = page_of(folder)
    section = root.get_element_by_id("sensitivities")
    assert "pointing: Sobol indices: 4 of 320 runs have no value" in section.text_content()
    rows = [[cell.text for cell in row] for row in section.findall(".//table")[-1].iterfind(".//tbody/tr")]
    assert [row[1] for row in rows] == ["inertia", "frequency", "damping"]
    assert_allclose([float(row[2]) for row in rows], [0.64, 0.36, 0.0], atol=0.05)


def test_what_is_no_campaign_is_refused(tmp_path):
    with pytest.raises(InputError, match="holds no campaign; give the folder of --out"):
        load_samples(tmp_path)
    folder = write_campaign(tmp_path / "one")
    (folder / "results.parquet").write_bytes(b"PAR1")
    with pytest.raises(InputError, match=r"results\.parquet: cannot be read"):
        load_samples(folder)
    (folder / "results.parquet").unlink()
    with pytest.raises(InputError, match="its campaign is not finished"):
        load_samples(folder)
    write_campaign(folder)
    with pytest.raises(InputError, match="is a folder; give a file"):
        write_campaign_page(folder, tmp_path)
    (folder / "bands.parquet").write_bytes(b"nothing")
    with pytest.raises(InputError, match=r"bands\.parquet: cannot be read"):
        write_campaign_page(folder)
    assert not (folder / "report.html").exists()
