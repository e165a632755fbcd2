"""The compressed file is made beside the run where there are unnamed files, and is the same one otherwise."""

import os
from types import SimpleNamespace

import numpy as np
import pyarrow.parquet as pq
import pytest

from lockstep import read_signals
from lockstep.fmi.model_description import Variable
from lockstep.operating_system import name_file, unnamed_file
from lockstep.results import conversion
from lockstep.results.recorder import Recorder
from lockstep.results.signal_patterns import Signal

SIGNALS = [
    Signal(component="c", variable=Variable(name=f"x{k}", reference=k, type=kind, causality="output", native=native))
    for k, (kind, native) in enumerate([("Real", ""), ("String", ""), ("Real", ""), ("Integer", "Int64")])
]
ROWS = 257


@pytest.fixture(autouse=True)
def small_groups(monkeypatch):
    monkeypatch.setattr(conversion, "_GROUP_BYTES", 8 * 5 * 40)  # 40 rows


def record(folder, rows=ROWS):
    folder.mkdir()
    made = Recorder(folder, SIGNALS, 10)
    for row in range(rows):
        for part in made.row(row / 10):
            part[:] = f"row {row}" if part.dtype == object else row
    return made


def whole(folder):
    assert [path.name for path in folder.iterdir()] == ["signals.parquet"]
    signals = read_signals(folder)
    for name in ("c.x0", "c.x2", "c.x3"):
        np.testing.assert_array_equal(signals[name], np.arange(ROWS))
    assert signals["c.x3"].dtype == np.int64
    assert signals["c.x1"].tolist() == [f"row {row}" for row in range(ROWS)]
    return (folder / "signals.parquet").read_bytes()


def at_the_end(folder, monkeypatch):
    """Record where the system has no unnamed files; return the content of the file."""
    with monkeypatch.context() as patch:
        patch.setattr(conversion, "unnamed_file", lambda _: None)
        made = record(folder)
        made.close()
        assert made.size_on_disk() == (folder / "signals.parquet").stat().st_size
    return whole(folder)


def test_groups_are_converted_beside_the_run_into_the_same_file(tmp_path, monkeypatch):
    probe = unnamed_file(tmp_path)
    if probe is None:
        pytest.skip("this file system has no unnamed files")
    os.close(probe)
    made = record(tmp_path / "beside")
    assert [path.name for path in (tmp_path / "beside").iterdir()] == ["signals.arrows"]  # all that a kill leaves
    made.saved()  # waits for what is being written
    made._conversion._end_thread()
    assert made._conversion._file._writer is not None
    assert made._conversion.group.count == 10  # the thread has written the 240 rows before
    made.close()
    assert whole(tmp_path / "beside") == at_the_end(tmp_path / "end", monkeypatch)
    assert pq.ParquetFile(tmp_path / "end/signals.parquet").num_row_groups == 7


@pytest.mark.parametrize("reason", ["no room", "failure"])
def test_a_file_that_cannot_be_made_beside_the_run_is_made_at_its_end(tmp_path, monkeypatch, reason):
    expected = at_the_end(tmp_path / "end", monkeypatch)
    if reason == "no room":
        monkeypatch.setattr(conversion.shutil, "disk_usage", lambda _: SimpleNamespace(free=1000))
    else:
        write, calls = conversion.pq.ParquetWriter.write_table, []

        def once(self, *arguments, **options):
            calls.append(1)
            if len(calls) == 2:
                raise OSError(28, "No space left on device")
            write(self, *arguments, **options)

        monkeypatch.setattr(conversion.pq.ParquetWriter, "write_table", once)
    record(tmp_path / "out").close()
    assert whole(tmp_path / "out") == expected


def test_a_failed_run_ends_the_thread_and_leaves_the_stream(tmp_path, monkeypatch):
    made = record(tmp_path / "out")
    monkeypatch.setattr(conversion.pq.ParquetWriter, "write_table", lambda *_, **__: 1 / 0)
    made.saved()  # waits for what is being written
    made._stream._file.close()  # nothing more can be written
    with pytest.raises(ValueError, match="closed file"):
        made.close()
    assert made._conversion._thread is None
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["signals.arrows"]
    assert len(read_signals(tmp_path / "out").time) == 250


def test_an_unnamed_file_gets_a_name_once(tmp_path):
    file = unnamed_file(tmp_path)
    if file is None:
        pytest.skip("this file system has no unnamed files")
    os.write(file, b"content")
    assert list(tmp_path.iterdir()) == []
    name_file(file, tmp_path / "named")
    with pytest.raises(FileExistsError):
        name_file(file, tmp_path / "named")
    os.close(file)
    assert (tmp_path / "named").read_bytes() == b"content"
