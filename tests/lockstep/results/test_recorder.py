"""Streams, their conversion, and reading what was cut off."""

from time import monotonic, sleep

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from lockstep import InputError, Unit, read_signals
from lockstep.fmi.model_description import Variable
from lockstep.results import conversion
from lockstep.results.monitor import Observed
from lockstep.results.recorder import Recorder
from lockstep.results.signal_patterns import Signal


def signal(name, kind="Real", unit=None):
    variable = Variable(
        name=name, reference=0, type=kind, causality="output", unit=unit and Unit(name=unit), description=f"the {name}"
    )
    return Signal(component="c", variable=variable)


SIGNALS = [signal("n", "Integer"), signal("x[1]", unit="m/s"), signal("ok", "Boolean"), signal("x[2]", unit="m/s")]


def record(folder, rows, rows_per_second=10, close=True, **more):
    made = Recorder(folder, SIGNALS, rows_per_second, **more)
    for row in range(rows):
        reals, integers, booleans, *_ = made.row(row / 10)
        reals[:] = row, -row
        integers[:] = np.int32(2 * row)
        booleans[:] = row % 2
    if close:
        made.close()
    return made


@pytest.mark.parametrize("rows", [0, 1, 9, 10, 11, 257])
def test_rows_come_back_by_name_in_the_order_given(tmp_path, rows):
    record(tmp_path, rows)
    assert [path.name for path in tmp_path.iterdir()] == ["signals.parquet"]
    signals = read_signals(tmp_path)
    assert list(signals.columns) == ["c.n", "c.x[1]", "c.ok", "c.x[2]"]
    row = np.arange(rows)
    np.testing.assert_array_equal(signals.time, row / 10)
    np.testing.assert_array_equal(signals["c.x"], np.column_stack([row, -row]))
    np.testing.assert_array_equal(signals["c.n"], 2 * row)
    np.testing.assert_array_equal(signals["c.ok"], row % 2)
    assert signals["c.ok"].dtype == np.float64


@pytest.mark.parametrize("rows", [0, 1, 499, 500, 501, 5003])
def test_a_scratch_run_stays_a_stream_whose_monitor_sees_each_row_once(tmp_path, monkeypatch, rows):
    monkeypatch.setattr(conversion, "_GROUP_BYTES", 120_000)  # of 3,000 rows
    monkeypatch.setattr(conversion, "_ParquetFile", None)  # there is none to write to
    seen = []

    class Everything:
        def rows(self, time, columns):
            seen.extend(zip(time.tolist(), columns["c.n"].tolist(), strict=True))
            return []

    record(tmp_path, rows, observed=Observed(Everything(), lambda *_, **__: None), scratch=True)

    assert [path.name for path in tmp_path.iterdir()] == ["signals.arrows"]
    signals = read_signals(tmp_path)
    row = np.arange(rows)
    np.testing.assert_array_equal(signals.time, row / 10)
    np.testing.assert_array_equal(signals["c.x"], np.column_stack([row, -row]))
    assert seen == [(k / 10, 2 * k) for k in range(rows)]


def test_units_and_descriptions_are_in_the_metadata(tmp_path):
    record(tmp_path, 3)
    field = pq.read_schema(tmp_path / "signals.parquet").field("c.x[1]")
    assert field.metadata == {b"unit": b"m/s", b"description": b"the x[1]", b"type": b"Real"}
    assert read_signals(tmp_path).units["c.x[1]"] == "m/s"


def test_a_batch_is_on_disk_as_soon_as_it_is_full(tmp_path):
    made = record(tmp_path, 31, close=False)
    end = monotonic() + 60.0
    while len(read_signals(tmp_path).time) < 30 and monotonic() < end:  # nobody waits for the thread that writes
        sleep(0.001)
    assert read_signals(tmp_path).time.tolist() == [k / 10 for k in range(30)]  # read beside the writer
    made.close()
    assert len(read_signals(tmp_path).time) == 31


def test_a_full_block_is_written_as_arrow_writes_it(tmp_path):
    """Types alternate, so that neighbours in the file are none in a block; the last block is not full."""
    made = record(tmp_path, 35, close=False)
    made.abandon()
    with (tmp_path / "signals.arrows").open("rb") as file, pa.ipc.open_stream(file) as stream:
        batches = list(stream)
    assert [len(batch) for batch in batches] == [10, 10, 10]
    expected = pa.BufferOutputStream()
    with pa.ipc.new_stream(expected, made.schema) as writer:
        for batch in batches:
            writer.write_batch(batch)
    assert (tmp_path / "signals.arrows").read_bytes() == expected.getvalue().to_pybytes()
    row = np.arange(30)
    written = pa.Table.from_batches(batches)
    for name, values in (("time", row / 10), ("c.n", 2 * row), ("c.x[1]", row), ("c.ok", row % 2), ("c.x[2]", -row)):
        np.testing.assert_array_equal(written.column(name).to_numpy(), values)


def test_a_stream_cut_off_at_any_length_is_readable(tmp_path):
    made = record(tmp_path, 31, close=False)  # a full batch is written when the next row comes
    made.saved()  # waits for that
    whole = (tmp_path / "signals.arrows").read_bytes()
    made.close()
    (tmp_path / "signals.parquet").unlink()
    lengths = []
    for size in range(len(whole), 0, -97):
        (tmp_path / "signals.arrows").write_bytes(whole[:size])
        try:
            rows = len(read_signals(tmp_path, ["c.n"]).time)
        except InputError as error:
            assert "cut off before its first row" in str(error)  # noqa: PT017 (either outcome is right)
            rows = 0
        lengths.append(rows)
    assert lengths == sorted(lengths, reverse=True)
    assert set(lengths) == {0, 10, 20, 30}


def test_a_conversion_of_many_groups_is_the_same_table(tmp_path, monkeypatch):
    monkeypatch.setattr(conversion, "_GROUP_BYTES", 8 * 5 * 40)
    record(tmp_path, 257)
    assert pq.ParquetFile(tmp_path / "signals.parquet").num_row_groups == 7
    np.testing.assert_array_equal(read_signals(tmp_path)["c.n"], 2 * np.arange(257))


def test_a_failed_conversion_keeps_the_stream(tmp_path, monkeypatch):
    def full(*_, **__):
        raise OSError(28, "No space left on device")

    made = record(tmp_path, 20, close=False)
    monkeypatch.setattr(conversion.pq.ParquetWriter, "write_table", full)
    with pytest.raises(OSError, match="No space left"):
        made.close()
    assert [path.name for path in tmp_path.iterdir()] == ["signals.arrows"]
    assert len(read_signals(tmp_path).time) == 20


class Full:
    """Fails to append the third batch to a stream, as a disk that is full for a moment."""

    def __init__(self, stream):
        self.append, self.lengths = stream._append, []
        stream._append = self

    def __call__(self, piece):
        self.lengths.append(len(piece.batch))
        if len(self.lengths) == 3:
            raise OSError(28, "No space left on device")
        self.append(piece)


def test_a_batch_whose_write_failed_is_not_written_again(tmp_path):
    """What fits after the failure must not follow half a batch: the stream would end there for its readers."""
    made = Recorder(tmp_path, SIGNALS, 10)
    writer = Full(made._stream)
    for row in range(40):
        made.row(row / 10)[1][:] = row
    with pytest.raises(OSError, match="No space left"):
        made.row(4.0)  # the fourth batch is full, and the third was not written
    made.close()
    assert writer.lengths == [10, 10, 10]
    np.testing.assert_array_equal(read_signals(tmp_path)["c.n"], np.arange(20))


@pytest.mark.parametrize("rows", [30, 31, 39])
@pytest.mark.parametrize("end", ["close", "saved"])
def test_a_write_that_fails_beside_the_last_rows_is_reported_at_the_end(tmp_path, rows, end):
    made = Recorder(tmp_path, SIGNALS, 10)
    writer = Full(made._stream)
    for row in range(rows):
        made.row(row / 10)[1][:] = row
    if end == "saved" and rows == 30:
        made.next_block()
    with pytest.raises(OSError, match="No space left"):
        getattr(made, end)()
    if end == "saved":
        made.close()
    assert writer.lengths == [10, 10, 10]
    np.testing.assert_array_equal(read_signals(tmp_path)["c.n"], np.arange(20))


def test_a_block_is_not_filled_while_it_is_written(tmp_path):
    """The next rows come while a slow disk still has those before: no row of the file is one of a later block."""

    made = Recorder(tmp_path, SIGNALS, 10)
    append = made._stream._append

    def slow(piece):
        sleep(0.002)
        append(piece)

    made._stream._append = slow
    for row in range(205):
        made.row(row / 10)[1][:] = row
    made.close()
    np.testing.assert_array_equal(read_signals(tmp_path)["c.n"], np.arange(205))


def test_a_signal_that_was_not_recorded_is_refused_by_name(tmp_path):
    record(tmp_path, 3)
    with pytest.raises(InputError, match=r"c\.y: not recorded; there are c\.n, c\.x\[1\], c\.ok, c\.x\[2\]"):
        read_signals(tmp_path, ["c.y"])
    with pytest.raises(InputError, match=r"c\.y: not recorded"):
        read_signals(tmp_path)["c.y"]
    assert "c.x" in read_signals(tmp_path, ["c.x"])
    assert "c.n" not in read_signals(tmp_path, ["c.x"])
    (tmp_path / "empty").mkdir()
    with pytest.raises(InputError, match=r"empty: holds no signals\.parquet and no signals\.arrows"):
        read_signals(tmp_path / "empty")
