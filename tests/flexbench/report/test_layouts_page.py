"""The comparison of layouts on a page: its answer first, its table, the runs of one seed, and its figure."""

import lxml.html
import pytest

from flexbench.figures.drawing import save_figure
from flexbench.figures.layouts import layouts_figure
from flexbench.html.document import Table
from flexbench.report.layouts_page import layouts_blocks
from flexbench.report.results import load_results
from flexbench.report.write import write_report
from flexbench.studies.layouts.result_file import write_result
from flexbench.studies.layouts.tables import compare
from lockstep import InputError

SEEDS = range(1, 14)  # with both layouts and scenarios more runs than a page takes


@pytest.fixture
def study(tmp_path, compare_made, foreign_run):
    """Return the folder of a comparison; seed 1 is lost, so that seed 2 is shown."""
    comparison = compare_made([1.0 + seed for seed in SEEDS], lost={("centralised", 1): "diverged"})
    folder = tmp_path / "layouts"
    for name in ("centralised", "distributed"):
        for scenario in ("fine-pointing", "slew"):
            for seed in (1, 2):
                foreign_run(folder / f"{name}-{scenario}-seed{seed}")
    write_result(comparison, folder)
    save_figure(layouts_figure(comparison, compare(comparison)), folder / "figures", "layouts")
    return folder


def test_a_folder_of_a_comparison_stands_for_the_runs_of_one_seed(study):
    names = [result.name for result in load_results([study])[0]]
    assert names == [f"{name}-{scenario}-seed2" for name in ("centralised", "distributed")
                     for scenario in ("fine-pointing", "slew")]  # fmt: skip


def test_the_page_begins_with_the_answer_and_has_table_verdicts_and_figure(study):
    (path,) = write_report([study], study / "report.html")
    root = lxml.html.fromstring(path.read_bytes())
    section = root.get_element_by_id("layouts")

    assert section.findtext(".//h2") == "Does distributing the wheels pay?"
    text = section.text_content()
    assert "In 9 of 9 quantities; in none is it shown to be worse." in text
    assert "by a factor of 2 (95 %: 2 to 2)" in text
    assert "centralised, slew, seed 1: diverged" in text
    assert "torque after the slew: lower with distributed wheels" in text
    assert [image.get("alt") for image in root.iterfind(".//section[@id='figures']//img")] == ["layouts"]


def test_blocks_show_the_stored_table_and_a_damaged_file_is_refused(study, tmp_path):
    tables = [block for block in layouts_blocks(study) if isinstance(block, Table)]
    assert len(tables) == 1  # no wheels were read
    assert tables[0].header[4] == "distributed / centralised"
    assert tables[0].rows[0][4:] == ["0.5 (0.5 to 0.5)", "12"]
    assert layouts_blocks(tmp_path) == []
    (study / "layouts.json").write_text('{"answer": 3}')
    with pytest.raises(InputError, match=r"layouts\.json: .*delete it, or write it again"):
        layouts_blocks(study)
