"""Time over the number of recorded signals: linear where it was quadratic."""

import gc
from pathlib import Path
from time import process_time

from lockstep.fmi.model_description import Description, Variable
from lockstep.plan.bus_layout import Layout
from lockstep.plan.schedule import build_schedule
from lockstep.results.read import read_signals
from lockstep.results.recorder import Recorder
from lockstep.results.signal_patterns import select
from lockstep.system.component import Component
from lockstep.system.system import System

FEW, MANY = 500, 4000


def _spent(folder: Path, count: int) -> dict[str, float]:
    """Return the processor time [s] of each part for so many signals, each recorded by its name, at two rates."""
    parts, before = {}, process_time()

    def mark(part: str) -> None:
        nonlocal before
        parts[part], before = process_time() - before, process_time()

    components = [
        Component(name=name, source=Path("none.fmu"), period=period) for name, period in (("a", 1), ("b", 50))
    ]
    system = System(name="wide", tick=1, components=tuple(components))
    variables = [
        Variable(name=f"y[{k}]" if k % 2 else f"z{k}", reference=k, type="Real", causality="output")
        for k in range(count)
    ]
    description = Description(
        model="", guid="", identifier="", once_per_process=False, saves_state=False, sha256="",
        variables={variable.name: variable for variable in variables},
    )  # fmt: skip
    descriptions = {"a": description, "b": description}
    before = process_time()
    names = [f"a.{variable.name}" for variable in variables]
    signals = select(system, descriptions, names)
    assert [signal.name for signal in signals] == names
    mark("patterns")
    recorded = {name: tuple(("Real", variable.reference) for variable in variables) for name in ("a", "b")}
    layout = Layout(schedule=build_schedule(system), links=(), recorded=recorded, record_ticks=1)
    assert layout.bus_size("Real") >= 2 * count
    mark("layout")
    folder.mkdir()
    recorder = Recorder(folder, signals, 1)
    recorder.row(0.0)
    mark("recorder")
    recorder.close()
    mark("conversion")
    run = read_signals(folder, names)
    assert run["a.y"].shape == (1, count // 2)
    assert all(name in run for name in names)
    mark("reading")
    return parts


def _least(folder: Path, count: int) -> dict[str, float]:
    """Return the least time of each part in three attempts."""
    attempts = [_spent(folder / f"{count}-{attempt}", count) for attempt in range(3)]
    return {part: min(attempt[part] for attempt in attempts) for part in attempts[0]}


def test_start_and_reading_are_linear_in_the_signals(tmp_path):
    gc.collect()
    gc.disable()  # what tests before have left would be searched in the middle of a part
    try:
        few, many = (_least(tmp_path, count) for count in (FEW, MANY))
    finally:
        gc.enable()
    # linear is 8, quadratic 64; 20 leaves room for the noise of a busy machine, 10 ms for its clock
    slow = {part: (few[part], many[part]) for part in few if many[part] > 20.0 * max(few[part], 0.010)}
    assert not slow
