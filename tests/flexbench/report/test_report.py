"""What goes onto the page: nothing lost, nothing larger than it may be."""

import base64
import json
from pathlib import Path
from types import SimpleNamespace

import lxml.html
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from flexbench.figures import drawing
from flexbench.html.document import Heading, Paragraph, Picture, Table
from flexbench.html.render import template_environment
from flexbench.report import study_sections as of_studies
from flexbench.report.compose import PAGE_FOLDER, compose_page
from flexbench.report.figure_images import Image, image_of, split_by_size, stored_images
from flexbench.report.history_data import (
    FLOAT,
    LEAST_INTERVALS,
    History,
    extremes,
    histories_within,
    history_data,
    stride_for,
    time_base,
)
from flexbench.report.motion_data import motion_data
from flexbench.report.results import MOST_RUNS, load_results
from flexbench.report.run_data import is_fault, read_run_data
from flexbench.report.sections import SECTIONS
from flexbench.report.study_table import study_table
from flexbench.report.write import write_report
from flexbench.runs.run_folder import Run
from flexsat.parameters import configuration
from flexsat.structure.mesh import record_mesh
from flexsat.structure.modes import build_structure
from lockstep import InputError, Signals
from lockstep.results.run_record import to_toml

TIME = np.arange(10_000) * 0.005


def history(name, values, group=""):
    return History(name=name, group=group or name, element="", unit="m", description="", values=values)


def floats(text, width=1):
    values = np.frombuffer(base64.b64decode(text), dtype="<f4").astype(float)
    return values.reshape(-1, width) if width > 1 else values


def foreign_run(folder, events="", names=("toy.y",), extra=""):
    """Leave a results folder of a system that is not ours, as the master would."""
    folder.mkdir(parents=True)
    time = np.arange(200) * 0.01
    table = pa.table({"time": time, **{name: np.sin(k + time) for k, name in enumerate(names)}})
    pq.write_table(table, folder / "signals.parquet")
    manifest = {
        "status": "completed", "simulated_time": 2.0, "wall_time": 1.0,
        "system": {"name": "toys", "path": "", "sha256": ""},
        "versions": {"python": "3"}, "component": [{"name": "toy", "model": "toy", "parameters": {}}],
    }  # fmt: skip
    (folder / "run.toml").write_text(to_toml(manifest) + extra)
    (folder / "events.jsonl").write_text(events)
    return folder


@pytest.mark.parametrize("stride", [2, 7, 10_000, 20_000])
def test_no_sample_lies_outside_its_interval(stride):
    values = np.random.default_rng(1).normal(size=len(TIME)) * 1e-7
    values[4321], values[17] = 3e-5, -2e-5

    low, high = extremes(values, stride).astype(float).T

    owner = np.arange(len(values)) // stride
    assert np.all((low[owner] <= values) & (values <= high[owner]))
    assert_allclose((low.min(), high.max()), (-2e-5, 3e-5), rtol=2e-7)  # single precision, outwards


def test_a_short_history_is_kept_sample_by_sample():
    values = np.sin(TIME)
    told, data = history_data(history("y", values), stride=1)

    assert told["kind"] == "samples"
    assert_allclose(floats(data), values, rtol=1e-7, atol=1e-9)


def test_what_never_changes_takes_no_room():
    assert history_data(history("y", np.full(5, 2.5)), stride=1) == (
        {"name": "y", "group": "y", "element": "", "unit": "m", "description": "", "constant": 2.5},
        "",
    )


@pytest.mark.parametrize(
    ("rows", "changing", "budget"), [(60_000, 226, 3_800_000), (60_000, 7, 2_000_000), (10, 1, 100)]
)
def test_data_stay_within_their_budget(rows, changing, budget):
    stride = stride_for(rows, changing, budget)
    size = rows * FLOAT if stride == 1 else 2 * FLOAT * -(-rows // stride)
    assert size * changing <= budget * 1.01


def test_what_finds_no_room_is_named():
    histories = [history(f"y[{k}]", np.sin(TIME + k), group="y") for k in range(30)]
    histories += [history(f"z[{k}]", np.sin(TIME + k), group="z") for k in range(30)]
    budget = 30 * 2 * FLOAT * LEAST_INTERVALS

    packed = histories_within(TIME, histories, budget)

    assert packed["left_out"] == ["z"]
    assert {told["group"] for told in packed["histories"]} == {"y"}
    assert sum(len(base64.b64decode(text)) for text in packed["data"]) <= 1.05 * budget


def test_times_are_told_by_step_or_one_by_one():
    assert time_base(TIME, 4) == {
        "count": 2500, "end": pytest.approx(49.995), "stride": 4, "start": 0.0, "step": pytest.approx(0.02),
    }  # fmt: skip
    uneven = np.array([0.0, 0.1, 0.4, 0.5, 2.0])
    told = time_base(uneven, 2)
    assert_array_equal(np.frombuffer(base64.b64decode(told["times"])), [0.0, 0.4, 2.0])


def test_the_motion_gives_back_the_deflections():
    config = configuration("distributed")
    shape = build_structure(record_mesh(config.aperture), config.plate).shape[::3]
    modal = np.random.default_rng(5).normal(size=(len(TIME), 25)) * np.logspace(-4, -7, 25)
    torque = np.sin(TIME[:, None] + np.arange(33))
    columns = {f"plant.modal.displacement[{k + 1}]": modal[:, k] for k in range(25)}
    columns |= {f"controller.wheel.torque[{k + 1}]": torque[:, k] for k in range(33)}
    signals = Signals(time=TIME, columns=columns, units={}, descriptions={})
    run = Run(folder=Path(), configuration="distributed", as_published=False, slew=False, seed=1)

    told = motion_data(signals, run, budget=95 * 1000)

    frames = told["frames"]
    rows = np.arange(frames) * round(told["step"] / 0.005)
    assert 900 <= frames <= 1000
    read = np.frombuffer(base64.b64decode(told["modal"]), dtype="<i2").reshape(frames, 25) * told["scale"]
    room = np.abs(shape) @ np.abs(modal).max(axis=0) / 65534.0  # half a step of each mode
    assert np.all(np.abs((read - modal[rows]) @ shape.T) <= room + 1e-15)
    read = np.frombuffer(base64.b64decode(told["torque"]), dtype="i1").reshape(frames, 33) / 127.0
    assert_allclose(read * told["largest_torque"], torque[rows], atol=0.5 / 127.0 + 1e-9)
    assert "error" not in told


def test_folders_of_runs_stand_for_their_runs(tmp_path):
    for path in ("study/a", "study/b", "other/a"):
        foreign_run(tmp_path / path)

    assert [r.name for r in load_results([tmp_path / "study"])] == ["a", "b"]
    assert [r.name for r in load_results([tmp_path / "study", tmp_path / "other" / "a"])] == ["study/a", "b", "other/a"]


def test_too_many_runs_are_refused(tmp_path):
    for k in range(MOST_RUNS + 1):
        foreign_run(tmp_path / f"r{k}")
    with pytest.raises(InputError, match=f"a page takes {MOST_RUNS} at most"):
        load_results([tmp_path])


def text_of(page, identifier):
    """Return what a parser finds in the script element of that id: it ends at the first closing tag."""
    root = lxml.html.fromstring(page.encode(), parser=lxml.html.HTMLParser(encoding="utf-8"))
    return root.get_element_by_id(identifier).text


def test_no_name_unit_or_event_can_break_out_of_the_page(tmp_path):
    hostile = "</script><script>alert(1)</script><!-- &amp; \"'"
    event = {"time": 1.0, "event": hostile, "message": f"</table>{hostile}"}
    fault = {"time": 1.5, "event": "fault", "name": hostile, "state": "begin"}
    run = foreign_run(
        tmp_path / "<b>run & ", f"{json.dumps(event)}\n{json.dumps(fault)}\n", [f"toy.{hostile}"], f"# {hostile}"
    )
    table = pq.read_table(run / "signals.parquet")
    field = table.schema.field(1).with_metadata({"unit": hostile, "description": hostile})
    pq.write_table(table.cast(table.schema.set(1, field)), run / "signals.parquet")

    page = compose_page(load_results([run]))

    root = lxml.html.fromstring(page.encode(), parser=lxml.html.HTMLParser(encoding="utf-8"))
    kinds = [script.get("type") for script in root.iter("script")]
    assert kinds == ["application/json", "text/plain", None]  # contents, one history, the page's own script
    assert root.find(".//h1/b") is None
    assert root.find(".//title").text == "<b>run & "
    assert hostile in root.xpath("string(//section[@id='versions']//pre)")
    assert "<script>alert" not in page
    (run_of_page,) = json.loads(text_of(page, "contents"))["runs"]
    (history_of_page,) = run_of_page["parts"][0]["histories"]
    assert (history_of_page["name"], history_of_page["unit"]) == (f"toy.{hostile}", hostile)
    assert [mark["text"] for mark in run_of_page["marks"]] == [hostile[:24]] * 2


def test_a_page_that_cannot_be_written_leaves_nothing(tmp_path):
    run = foreign_run(tmp_path / "run")
    (tmp_path / "file").write_text("in the way")
    with pytest.raises(InputError, match="cannot be written"):
        write_report([run], tmp_path / "file" / "x.html")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["file", "run"]


def test_a_run_without_rows_is_refused(tmp_path):
    run = foreign_run(tmp_path / "run")
    pq.write_table(pq.read_table(run / "signals.parquet").slice(0, 0), run / "signals.parquet")
    with pytest.raises(InputError, match="no row of signals yet"):
        write_report([run])


def test_a_window_is_kept_row_by_row(tmp_path):
    (result,) = load_results([foreign_run(tmp_path / "run")])

    (part,) = read_run_data(result, runs=1, window=(0.5, 0.75)).for_script["parts"]

    assert_allclose((part["time"]["start"], part["time"]["end"], part["time"]["count"]), (0.5, 0.75, 26))
    assert_allclose(floats(part["data"][0]), np.sin(np.arange(50, 76) * 0.01), rtol=1e-6)
    with pytest.raises(
        InputError, match=r"--time-range 5 6: holds less than two rows; the record goes from 0 to 1\.99 s"
    ):
        read_run_data(result, runs=1, window=(5.0, 6.0))


def test_a_folder_that_is_no_toml_is_refused(tmp_path):
    run = foreign_run(tmp_path / "run", extra="[[[")
    with pytest.raises(InputError, match=r"run\.toml: is no TOML"):
        write_report([run])


def test_faults_are_told_from_other_events():
    assert is_fault({"event": "fault", "name": "stuck"})
    assert is_fault({"event": "begin", "kind": "fault"})
    assert not is_fault({"event": "start"})


def test_figures_of_a_folder_come_in_their_smaller_format_and_within_room(tmp_path):
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
    taken, left = split_by_size(images, room=60)
    assert ([image.title for image in taken], [image.title for image in left]) == (["slew"], ["modes"])


def test_a_picture_of_a_section_is_an_image_of_its_own():
    image = image_of(Picture('<svg id="a"/>', "a.svg", 'a "b" <c>'))
    assert isinstance(image, Image)

    parts = template_environment(PAGE_FOLDER).get_template("parts.html")
    html = parts.make_module({"image_of": image_of}).figure(image)

    assert 'id="a"' not in html
    assert 'alt="a &#34;b&#34; &lt;c&gt;"' in html
    assert base64.b64encode(b'<svg id="a"/>').decode() in html


def test_sections_of_studies_are_composed_and_may_be_absent(monkeypatch):
    run = Run(folder=Path(), configuration="distributed", as_published=False, slew=False, seed=1)

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


def test_the_table_of_a_study_stands_beside_the_published_one(tmp_path):
    row = {"row": "slew: settling", "unit": "s", "configuration": "distributed", "published": 30.0,
           "standard_deviation": 5.4}  # fmt: skip
    content = {
        "seeds": [1, 2], "duration": 300.0, "remarks": ["so it is"],
        "rows": [row | {"variant": "as_published", "mean": 33.5, "met": True},
                 row | {"variant": "corrected", "mean": 2.0, "met": False, "standard_deviation": None}],
    }  # fmt: skip
    (tmp_path / "table.json").write_text(json.dumps(content))

    (table,) = [block for block in study_table(tmp_path) if isinstance(block, Table)]

    assert table.header[2:] == ("published", "ours, as published", "ours, corrected")
    assert table.rows == [["slew: settling", "s", "30", "33.5 ± 5.4", "2 (differs from our reference)"]]


def test_figures_and_page_use_the_same_colours():
    script = Path(drawing.__file__).parents[1] / "report" / "page" / "data.js"
    text = script.read_text()
    assert all(look.colour.lower() in text for look in drawing.LOOKS.values())
