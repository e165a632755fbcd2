"""Read the stream of a run batch by batch. Only an unfinished batch at its end is forgiven: a killed run leaves it."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pyarrow as pa

from lockstep.errors import InputError

STREAM = "signals.arrows"  # of a run that goes on or was killed
_HEAD = 8  # bytes with which every message of a stream begins: a marker, and the length of its description
_CHUNK = 1 << 20  # bytes searched at once


@contextmanager
def read_batches(path: Path) -> Iterator[tuple[pa.Schema, Iterator[pa.RecordBatch]]]:
    """Open a stream; its batches end where a killed run left it.

    Raises
    ------
    InputError
        If the file was cut off before its first row, cannot be read, or is damaged before its end.
    """
    try:
        file = pa.OSFile(str(path), "rb")
    except OSError as error:
        raise InputError(f"{path}: cannot be opened ({error.strerror or error})") from None
    with file as source:
        size = source.size()  # a run that goes on appends to it
        try:
            reader = pa.ipc.open_stream(source)
        except (pa.ArrowException, OSError) as error:
            _refuse_failed_read(path, 0, error)
            if source.tell() < size:
                raise InputError(f"{path}: is damaged before its first row ({error}); restore the file") from None
            raise InputError(f"{path}: was cut off before its first row") from None
        yield reader.schema, _batches(path, source, reader, size)


def _batches(
    path: Path, source: pa.NativeFile, reader: pa.RecordBatchStreamReader, size: int
) -> Iterator[pa.RecordBatch]:
    rows = 0
    while True:
        begin = source.tell()
        try:
            batch = reader.read_next_batch()
            batch.validate(full=True)  # texts lie where their positions say
        except StopIteration:
            reason = "an end where rows follow"
        except (pa.ArrowException, OSError) as error:
            _refuse_failed_read(path, rows, error)
            reason = str(error)
        else:
            rows += len(batch)
            yield batch
            continue
        if _another_follows(path, begin, size, reader.schema):
            remedy = f"restore the file, or run again; its first {begin} bytes are the rows before"
            raise InputError(f"{path}: is damaged after row {rows} ({reason}); {remedy}")
        return


def _refuse_failed_read(path: Path, rows: int, error: Exception) -> None:
    """Raise InputError if the operating system refused to read: the data may be whole."""
    if isinstance(error, OSError) and error.errno:  # a batch that is not whole has none
        raise InputError(f"{path}: cannot be read after row {rows} ({error}); try again, or restore the file") from None


def _another_follows(path: Path, begin: int, size: int, schema: pa.Schema) -> bool:
    """Return whether a batch begins behind this position, so that the failure here is no end of a killed run.

    All batches of a stream begin with the same bytes. What was appended since the file was opened, beyond `size`, is
    not looked at.
    """
    row = pa.RecordBatch.from_arrays([pa.nulls(1, field.type) for field in schema], names=schema.names)
    head = row.serialize().to_pybytes()[:_HEAD]
    with path.open("rb") as file:
        file.seek(begin + 1)
        left, before = size - begin - 1, b""
        while left > 0 and (chunk := file.read(min(left, _CHUNK))):
            if head in before + chunk:
                return True
            left, before = left - len(chunk), chunk[1 - _HEAD :]
    return False
