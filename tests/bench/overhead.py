"""Measure what a tick costs in the master itself: `python tests/bench/overhead.py`.

The slaves do nothing, so that what is left is the master: gathers, checks, bookkeeping and the recording of
every output each 5 ms. The sizes are those of a large spacecraft: 110, 130 and 20 outputs at 1, 1 and 5 ms.
"""

import tempfile
from itertools import cycle
from pathlib import Path
from time import process_time

from lockstep import Component, Connection, System
from lockstep.fmi.model_description import Variable
from lockstep.plan.bus_layout import Layout
from lockstep.plan.schedule import build_schedule
from lockstep.plan.wiring import Link
from lockstep.results.recorder import Recorder
from lockstep.results.signal_patterns import Signal
from lockstep.run.exchange import Exchange
from lockstep.tick.bound_operations import actions

MS = 1_000_000
TICKS = 20_000
OUTPUTS = {"sensors": 130, "control": 20, "plant": 110}
WIRES = [
    ("plant", "sensors", 110, 1),
    ("sensors", "control", 60, 0),
    ("sensors", "plant", 24, 0),
    ("control", "plant", 12, 0),
]


class Silent:
    """Accept every call at once."""

    @staticmethod
    def do_step(_time, _step, _no_set_state):
        return 0

    def getter(self, _scalar, _references, _buffer):
        return int

    setter = getter


def main():
    parts = [
        Component(name="sensors", source=Path("none"), period=MS, kind="sampled"),
        Component(name="control", source=Path("none"), period=5 * MS, kind="sampled"),
        Component(name="plant", source=Path("none"), period=MS, kind="continuous"),
    ]
    ends = [Connection(from_component=p, output="y", to_component=c, input=p, delay=d) for p, c, _, d in WIRES]
    links = tuple(
        Link(
            producer=producer,
            consumer=consumer,
            delay=delay,
            scalar="Real",
            sources=tuple(range(count)),
            targets=tuple(range(100 * (producer == "control"), 100 * (producer == "control") + count)),
            gains=(1.0,) * count,
            biases=(0.0,) * count,
        )
        for producer, consumer, count, delay in WIRES
    )
    layout = Layout(
        schedule=build_schedule(System(name="s", tick=MS, components=tuple(parts), connections=tuple(ends))),
        links=links,
        recorded={name: tuple(("Real", k) for k in range(count)) for name, count in OUTPUTS.items()},
        record_ticks=5,
    )
    signals = [
        Signal(component=name, variable=Variable(name=f"y[{k + 1}]", reference=k, type="Real", causality="output"))
        for name, count in OUTPUTS.items()
        for k in range(count)
    ]
    for _ in range(3):
        with tempfile.TemporaryDirectory() as folder:
            recorder = Recorder(Path(folder), signals, 200)
            phases = actions(Exchange(layout, {name: Silent() for name in OUTPUTS}, {}).program(recorder.row))
            start = process_time()
            for tick, phase in zip(range(TICKS), cycle(phases), strict=False):
                time = tick * MS / 1e9
                for step in phase:
                    step(time)
            print(f"{(process_time() - start) / TICKS * 1e6:.2f} us a tick")
            recorder.close()


if __name__ == "__main__":
    main()
