"""Read and write a checkpoint: a zip of a header, the arrays of the master, and the states of the components.

`header.json` describes the run and its progress; `arrays.npz` holds the bus and the rows that were not yet on disk;
`states/COMPONENT/FILE` is the saved state of each component. The checksums of the zip reveal a damaged file.
"""

from __future__ import annotations

import io
import json
import os
import re
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lockstep.checkpoint.check_content import check_arrays, check_header
from lockstep.data_text import parse_json
from lockstep.errors import InputError
from lockstep.fmi.safe_zip import open_zip
from lockstep.system.clock import Time, nanoseconds, read_nanoseconds, seconds_text
from lockstep.whole_file import file_digest

FOLDER = "checkpoints"  # in a results folder
FORMAT, VERSION = "lockstep checkpoint", 1
_HEADER, _ARRAYS, _STATES = "header.json", "arrays.npz", "states"
_NAME = re.compile(r"t=(-?\d+(?:\.\d+|_\d+)?)\.ckpt")  # 1_60 is 1/60

Arrays = Mapping[str, NDArray[Any]]
States = Mapping[str, Mapping[str, bytes]]  # by component and file


@dataclass(frozen=True, slots=True, kw_only=True)
class Checkpoint:
    """A saved run. `header` is what `write_checkpoint` was given."""

    path: Path
    sha256: str  # of the file
    header: Mapping[str, Any]
    arrays: Arrays
    states: States

    @property
    def tick(self) -> int:
        """Number of completed ticks, which is the next one to run."""
        return int(self.header["tick"])

    @property
    def time(self) -> Time:
        """Simulated time [ns]."""
        return read_nanoseconds(self.header["time"], f"{self.path}: time")

    @property
    def run(self) -> Mapping[str, Any]:
        """The content of run.toml when the checkpoint was saved."""
        run: Mapping[str, Any] = self.header["run"]
        return run


def checkpoint_name(time: Time) -> str:
    """Return the name of the file for a simulated time [ns]."""
    return f"t={seconds_text(time).replace('/', '_')}.ckpt"


def newest_checkpoint(results: Path) -> Path | None:
    """Return the newest checkpoint in a results folder, or None."""
    found = [(match[1], path) for path in (results / FOLDER).glob("*") if (match := _NAME.fullmatch(path.name))]
    return max(found, key=lambda entry: nanoseconds(entry[0].replace("_", "/"), "checkpoint"))[1] if found else None


def write_checkpoint(path: Path, header: Mapping[str, Any], arrays: Arrays, states: States) -> None:
    """Write the whole file or none, also when the power fails. Raises OSError."""
    path.parent.mkdir(exist_ok=True)
    partial = path.with_name(f".{path.name}.partial")
    packed = io.BytesIO()
    np.savez(packed, allow_pickle=False, **arrays)
    try:
        with partial.open("wb") as stream:
            with zipfile.ZipFile(stream, "w") as archive:
                content = json.dumps({"format": FORMAT, "version": VERSION, **header})
                archive.writestr(_HEADER, content, zipfile.ZIP_DEFLATED)
                archive.writestr(_ARRAYS, packed.getvalue())
                for component, files in states.items():
                    for name, state in files.items():
                        archive.writestr(f"{_STATES}/{component}/{name}", state)
            stream.flush()
            os.fsync(stream.fileno())
        partial.replace(path)
    except BaseException:
        partial.unlink(missing_ok=True)
        raise


def read_checkpoint(path: Path | str) -> Checkpoint:
    """Read a checkpoint; raise InputError if the file is none, is damaged, or has another version."""
    path = Path(path)
    if not path.is_file():
        near = newest_checkpoint(path) or newest_checkpoint(path.parent.parent)
        raise InputError(f"{path}: no such checkpoint; " + (f"there is {near}" if near else "give a .ckpt file"))
    no_checkpoint = f"{path}: is no checkpoint, or was cut off; give a .ckpt file that a run with --checkpoint left"
    with open_zip(path, f"checkpoint {path}") as archive:
        members = archive.namelist()
        if _HEADER not in members or _ARRAYS not in members:
            raise InputError(no_checkpoint)
        try:
            header = parse_json(archive.read(_HEADER), f"{path}: {_HEADER}", "use another one")
            if not isinstance(header, dict) or header.get("format") != FORMAT:
                raise InputError(no_checkpoint)
            if header.get("version") != VERSION:
                remedy = f"this lockstep reads version {VERSION}; make the checkpoint anew"
                raise InputError(f"{path}: is a checkpoint of version {header.get('version')!r}; {remedy}")
            check_header(header, f"{path}: is a damaged checkpoint")
            with np.load(io.BytesIO(archive.read(_ARRAYS)), allow_pickle=False) as arrays:
                values = {name: arrays[name] for name in arrays.files}
            states: dict[str, dict[str, bytes]] = {}
            for member in members:
                parts = member.split("/")
                if parts[0] == _STATES and len(parts) == 3:
                    states.setdefault(parts[1], {})[parts[2]] = archive.read(member)
            check_arrays(header, values, f"{path}: is a damaged checkpoint")
        except InputError:
            raise
        except (ValueError, KeyError, EOFError) as error:
            raise InputError(f"{path}: is a damaged checkpoint ({error}); use another one") from None
    return Checkpoint(path=path.absolute(), sha256=file_digest(path), header=header, arrays=values, states=states)
