"""Write zip archives whose bytes depend on their content alone."""

from __future__ import annotations

import io
import secrets
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

_EPOCH = (1980, 1, 1, 0, 0, 0)  # the earliest time that a zip can hold
_MODE = 0o100644 << 16  # a plain file, readable by all


def zip_bytes(entries: Mapping[str, bytes], *, compress: bool = True) -> bytes:
    """Pack files, sorted by name, with fixed time stamps and permissions."""
    memory = io.BytesIO()
    with zipfile.ZipFile(memory, "w") as archive:
        for name in sorted(entries):
            info = zipfile.ZipInfo(name, _EPOCH)
            info.external_attr = _MODE
            info.create_system = 3  # Unix, wherever it is built
            info.compress_type = zipfile.ZIP_DEFLATED if compress else zipfile.ZIP_STORED
            archive.writestr(info, entries[name])
    return memory.getvalue()


def npz_bytes(arrays: Mapping[str, np.ndarray[Any, Any]]) -> bytes:
    """Pack arrays as an .npz file: like `numpy.savez`, but the same arrays give the same bytes."""
    entries = {}
    for name, array in arrays.items():
        memory = io.BytesIO()
        np.lib.format.write_array(memory, np.asanyarray(array), allow_pickle=False)
        entries[f"{name}.npy"] = memory.getvalue()
    return zip_bytes(entries, compress=False)


def write_atomically(path: Path, content: bytes) -> None:
    """Write a file so that a reader sees the old one or the new one, never a part; or raise OSError with its path."""
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = path.with_name(f".{path.name}.{secrets.token_hex(4)}")
    try:
        with temporary.open("xb") as file:  # with the permissions that the umask leaves
            file.write(content)
        temporary.replace(path)
    except OSError as error:
        temporary.unlink(missing_ok=True)
        raise OSError(error.errno, error.strerror or str(error), str(path)) from None
    except BaseException:
        temporary.unlink(missing_ok=True)
        raise
