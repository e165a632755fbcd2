"""Damaged signals and events: only what a killed run leaves at the end is forgiven, and nothing is removed."""

import json
import os
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from lockstep import InputError, Unit, read_signals
from lockstep.faults.windows import fault_windows
from lockstep.fmi.model_description import Variable
from lockstep.results import stream
from lockstep.results.conversion import convert
from lockstep.results.read import recorded_rows
from lockstep.results.read_events import read_events
from lockstep.results.recorder import Recorder, SavedRows
from lockstep.results.run_record import Events
from lockstep.results.signal_patterns import Signal

STREAM, PARQUET = "signals.arrows", "signals.parquet"


def signals(kinds):
    return [
        Signal(component="c", variable=Variable(name=f"x{k}", reference=k, type=kind, causality="output",
                                                unit=Unit(name="m"), native="Int64" if kind == "Integer" else ""))
        for k, kind in enumerate(kinds)
    ]  # fmt: skip


def recorded(folder, rows=100, kinds=("Real", "Real")):
    """Record rows in batches of 10, and return the recorder and where each batch on disk begins."""
    made = Recorder(folder, signals(kinds), 10)
    for row in range(rows):
        for part in made.row(row / 10):
            part[:] = f"row {row}" if part.dtype == object else row
    made.saved()  # waits for what is being written
    begins = []
    with pa.OSFile(str(folder / STREAM)) as source:
        reader = pa.ipc.open_stream(source)
        begins.append(source.tell())
        for _ in reader:
            begins.append(source.tell())
    return made, begins


def overwrite(path, position, content):
    with path.open("r+b") as file:
        file.seek(position)
        file.write(content)


DAMAGE = {"marker": (0, bytes(8)), "length": (4, b"\xff\xff\xff\x7f"), "description": (40, b"\x99" * 60)}


@pytest.mark.parametrize("kind", DAMAGE)
@pytest.mark.parametrize("kinds", [("Real", "Real"), ("Integer", "String", "Boolean")])
def test_damage_inside_a_stream_is_no_end_of_it(tmp_path, kind, kinds):
    made, begins = recorded(tmp_path, kinds=kinds)
    made.abandon()
    offset, content = DAMAGE[kind]
    overwrite(tmp_path / STREAM, begins[5] + offset, content)
    whole = (tmp_path / STREAM).read_bytes()

    with pytest.raises(OSError, match=r"signals\.arrows: is damaged after row 50 .*; it is kept"):
        convert(tmp_path, 100)

    assert [path.name for path in tmp_path.iterdir()] == [STREAM]
    assert (tmp_path / STREAM).read_bytes() == whole
    message = rf"is damaged after row 50 .*restore the file, or run again; its first {begins[5]} bytes are the rows"
    for read in (read_signals, lambda folder: recorded_rows(folder, 100)):
        with pytest.raises(InputError, match=message):
            read(tmp_path)
    assert recorded_rows(tmp_path, 50) == 50
    os.truncate(tmp_path / STREAM, begins[5])  # as the message says
    assert read_signals(tmp_path).time.tolist() == [row / 10 for row in range(50)]


def test_texts_that_lie_nowhere_are_damage(tmp_path):
    made, begins = recorded(tmp_path, kinds=("String",))
    made.abandon()
    overwrite(tmp_path / STREAM, begins[6] - 200, b"\x7f" * 190)
    with pytest.raises(OSError, match=r"signals\.arrows: is damaged after row 50 .*; it is kept"):
        convert(tmp_path, 100)


def test_a_stream_that_lost_its_end_is_not_converted(tmp_path):
    """A cut at the end is what a killed run leaves; a run that ends knows how many rows it has written."""
    _, begins = recorded(tmp_path)
    os.truncate(tmp_path / STREAM, begins[7] + 30)

    with pytest.raises(OSError, match=r"signals\.arrows gives back 70 of 100 rows; it is kept"):
        convert(tmp_path, 100)

    assert [path.name for path in tmp_path.iterdir()] == [STREAM]
    assert len(read_signals(tmp_path).time) == 70


def test_a_read_that_the_system_refuses_is_no_end_of_the_stream(tmp_path):
    """/proc/self/mem opens, and reading at its start is an input/output error: EIO, as of a failing disk."""
    (tmp_path / STREAM).symlink_to("/proc/self/mem")
    with pytest.raises(InputError, match=r"signals\.arrows: cannot be read after row 0 \(.*error.*try again"):
        read_signals(tmp_path)


def test_a_stream_that_grows_while_it_is_read_is_not_damaged(tmp_path, monkeypatch):
    made, begins = recorded(tmp_path)
    made._stream.close()
    whole = (tmp_path / STREAM).read_bytes()
    os.truncate(tmp_path / STREAM, begins[4] + 200)  # a batch is half on disk when the reader comes to it
    look = stream._another_follows

    def look_later(*arguments):
        (tmp_path / STREAM).write_bytes(whole)  # meanwhile the run has written on
        return look(*arguments)

    monkeypatch.setattr(stream, "_another_follows", look_later)
    assert read_signals(tmp_path).time.tolist() == [row / 10 for row in range(40)]


def test_a_resumed_run_leaves_the_earlier_rows_when_they_cannot_all_be_copied(tmp_path):
    made, begins = recorded(tmp_path)
    waiting = made.saved().waiting
    made._stream.close()
    os.truncate(tmp_path / STREAM, begins[5])
    with pytest.raises(OSError, match="50 of 80 rows of the earlier part could be read"):
        Recorder(tmp_path, signals(("Real", "Real")), 10, SavedRows(written=80, waiting=waiting))
    assert [path.name for path in tmp_path.iterdir()] == [STREAM]
    assert len(read_signals(tmp_path).time) == 50


def test_no_part_of_a_batch_stays_of_a_failed_write(tmp_path):
    """Its end and the mark of the end of a stream would otherwise be read as one batch."""
    made, begins = recorded(tmp_path, rows=30)  # 20 are on disk

    def full(piece):
        """Write all of a batch but its last value, as a disk that is full and has space again."""
        made._stream._file.write(piece.batch.serialize().to_pybytes()[:-8])
        raise OSError(28, "No space left on device")

    made._stream._append = full
    made.row(3.0)
    with pytest.raises(OSError, match="No space left"):
        made.saved()
    assert (tmp_path / STREAM).stat().st_size == begins[2]
    made.close()
    np.testing.assert_array_equal(read_signals(tmp_path)["c.x1"], np.arange(20))


@pytest.mark.parametrize("where", ["page", "footer"])
def test_a_damaged_file_of_a_run_that_ended_is_refused(tmp_path, where):
    made, _ = recorded(tmp_path, rows=1000)
    made.close()
    file = tmp_path / PARQUET
    column = pq.ParquetFile(file).metadata.row_group(0).column(1)
    position = (
        column.data_page_offset + column.total_compressed_size // 2 if where == "page" else file.stat().st_size - 8
    )
    overwrite(file, position, bytes(8))
    for read in (read_signals, lambda folder: recorded_rows(folder, 1000)):
        with pytest.raises(InputError, match=r"signals\.parquet: cannot be read \(.*; restore the file, or run again"):
            read(tmp_path)


def write_events(folder, *lines):
    (folder / "events.jsonl").write_bytes(b"\n".join(lines))


WHOLE = b'{"time": 0.0, "event": "start"}'


def test_events_end_with_half_a_line_only(tmp_path):
    write_events(tmp_path, WHOLE, b'{"time": 1.0, "event": "log", "message": "a\xe2\x80\xa8b"}', b'{"time": 2.0, "ev')
    assert [event["event"] for event in read_events(tmp_path)] == ["start", "log"]
    assert read_events(tmp_path)[1]["message"] == "a\u2028b"  # no end of a line
    assert read_events(Path(tmp_path, "none")) == []


@pytest.mark.parametrize(
    ("line", "message"),
    [
        (b'{"time": 1.0, "ev', "is no JSON"),
        (b"\xff\xfe", "is no JSON"),
        (b"[" * 100_000, "is nested too deeply to be read"),
        (b"[1]", "is no event"),
        (b'{"time": "x", "event": "log"}', "time = 'x' must be a number of seconds"),
    ],
)
def test_a_damaged_event_before_the_end_is_refused_by_its_line(tmp_path, line, message):
    write_events(tmp_path, WHOLE, line, WHOLE, b"")
    for read in (read_events, fault_windows):
        with pytest.raises(InputError, match=rf"events\.jsonl: line 2: {message}.*; restore the file, or remove that"):
            read(tmp_path)


def test_an_event_is_written_wholly_or_not_at_all(tmp_path, monkeypatch):
    events = Events()
    events.open(tmp_path)
    events.add("start")
    write, left = os.write, [10]

    def nearly_full(file, data):
        if not left[0]:
            raise OSError(28, "No space left on device")
        written, left[0] = write(file, data[: left[0]]), 0
        return written

    with monkeypatch.context() as patch:
        patch.setattr(os, "write", nearly_full)
        with pytest.raises(OSError, match="No space left"):
            events.add("log", message="lost")
    events.add("end")
    events.close()
    assert [json.loads(line)["event"] for line in (tmp_path / "events.jsonl").read_text().splitlines()] == [
        "start",
        "end",
    ]
