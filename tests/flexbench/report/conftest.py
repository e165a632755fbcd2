"""Results folders of a system that is not flexsat's, as the master writes them."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from lockstep.results.run_record import to_toml


@pytest.fixture(scope="session")
def foreign_run() -> Callable[..., Path]:
    """Return a function that writes a results folder: its path, events as text, signal names, more text of run.toml."""

    def write(folder: Path, events: str = "", names: tuple[str, ...] = ("toy.y",), extra: str = "") -> Path:
        folder.mkdir(parents=True)
        time = np.arange(200) * 0.01
        table = pa.table({"time": time, **{name: np.sin(k + time) for k, name in enumerate(names)}})
        pq.write_table(table, folder / "signals.parquet")
        record = {
            "status": "completed", "simulated_time": 2.0, "wall_time": 1.0,
            "system": {"name": "toys", "path": "", "sha256": ""},
            "versions": {"python": "3"}, "component": [{"name": "toy", "model": "toy", "parameters": {}}],
        }  # fmt: skip
        (folder / "run.toml").write_text(to_toml(record) + extra)
        (folder / "events.jsonl").write_text(events)
        return folder

    return write
