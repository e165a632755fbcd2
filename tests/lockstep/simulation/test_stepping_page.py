"""The examples of docs/stepping.md run as they stand there, one after another."""

import re
import shutil
from pathlib import Path

import pytest

from lockstep import Component, Connection, System, write_ssd

PAGE = Path(__file__).parents[3] / "docs" / "stepping.md"
EXAMPLES = re.findall(r"^```python\n(.*?)^```", PAGE.read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE)


def test_the_examples_of_the_page_run(fmus, tmp_path, monkeypatch):
    part = {"source": fmus["good"], "period": 1_000_000, "isolated": False}
    system = System(
        name="loop", tick=1_000_000,
        components=(Component(name="plant", **part), Component(name="controller", **part, kind="sampled")),
        connections=(Connection(from_component="plant", output="y", to_component="controller", input="u", delay=1),
                     Connection(from_component="controller", output="y", to_component="plant", input="u")),
    )  # fmt: skip
    write_ssd(system, tmp_path / "loop.ssd")
    for name in ("plant", "controller"):
        shutil.copy(fmus["good"], tmp_path / f"{name}.fmu")
    monkeypatch.chdir(tmp_path)
    found = {}
    for example in EXAMPLES:
        exec(compile(example, str(PAGE), "exec"), found)

    assert len(EXAMPLES) == 3
    assert len(found["run"].signals.time) == 601
    assert list(found["result"]) == [f"{part}.{name}" for part in ("plant", "controller")
                                     for name in ("y", "began", "steps", "odd")]  # fmt: skip
    assert len(set(found["final"].values())) == 3
    assert found["run"].time == pytest.approx(0.6, abs=0.0)
