"""Steps of isolated FMUs that C requests: what stops a run leaves the workers at rest."""

import signal

import pytest

from fmus.busy_fmu import busy_fmu
from lockstep import Component, System, simulate

TICK = 1_000_000  # [ns]


def test_ctrl_c_in_a_tick_waits_for_the_steps_under_way_and_frees_the_fmus(tmp_path):
    """Workers that were at work when they are closed would be ended, and their FMUs not freed, which is logged."""
    fmu = busy_fmu(tmp_path)
    parts = tuple(
        Component(name=name, source=fmu, period=TICK, kind="sampled", isolated=True, parameters={"work": 2000.0})
        for name in ("one", "two")
    )
    system = System(name="two", tick=TICK, components=parts, record=("*.y",))

    def interrupt(time, _stop):
        if time > 0.0:
            signal.raise_signal(signal.SIGINT)

    with pytest.raises(KeyboardInterrupt):
        simulate(system, tmp_path / "run", stop_time=100.0, progress=interrupt, tick="c")

    events = (tmp_path / "run" / "events.jsonl").read_text()
    assert '"status": "interrupted"' in events
    assert "isolation" not in events
