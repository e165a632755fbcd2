"""The initialisation calls that each slave receives, and in which order."""

from dataclasses import replace

import numpy as np
import pytest

from lockstep.interrupt import Interrupt
from lockstep.plan.plan import Plan
from lockstep.run.exchange import Exchange
from lockstep.run.initialise import initialise

MS = 1_000_000  # [ns]


class Slave:
    """Note every call, with the name of the component."""

    def __init__(self, name, calls):
        self.name, self.calls = name, calls

    def set_start(self, values, scalar):
        self.calls.append((self.name, "set_start", scalar, values))
        return 0

    def setup_experiment(self, start, stop):
        self.calls.append((self.name, "setup_experiment", start, stop))
        return 0

    def enter_initialization(self):
        self.calls.append((self.name, "enter"))
        return 0

    def exit_initialization(self):
        self.calls.append((self.name, "exit"))
        return 0

    def getter(self, _scalar, references, buffer):
        def get():
            buffer[:] = np.zeros(len(references))
            return 0

        return get

    def setter(self, _scalar, _references, _buffer):
        return lambda: 0


def initialised(system, stop_time, **options):
    """Initialise slaves that only note their calls, and return those."""
    plan = Plan(system, stop_time, {}, options.pop("record", []), None)
    calls = []
    slaves = {component.name: Slave(component.name, calls) for component in system.components}
    restore = options.pop("restore", False)
    if restore:
        options["restore"] = lambda: calls.append(("", "restore"))
    initialise(plan, slaves, Exchange(plan.layout, slaves, plan.names), Interrupt(), **options)
    return calls


@pytest.mark.parametrize(("stop", "echo"), [("0.01", 0.01), ("0.011", 0.015), ("0.014", 0.015), ("0.015", 0.015)])
def test_the_announced_stop_time_is_the_end_of_the_last_step(loop, stop, echo):
    """The echo steps every 5 ms: its last step may end after the stop time, and never after the announced one."""
    spans = {call[0]: call[2:] for call in initialised(loop, stop) if call[1] == "setup_experiment"}

    assert spans == {"counter": (0.0, float(stop)), "echo": (0.0, echo), "plant": (0.0, float(stop))}


def test_a_sample_for_the_row_at_the_stop_time_lies_before_the_announced_end(loop):
    spans = {c[0]: c[2:] for c in initialised(loop, "0.01", record="all") if c[1] == "setup_experiment"}

    assert spans == {"counter": (0.0, 0.011), "echo": (0.0, 0.015), "plant": (0.0, 0.01)}


def test_the_announced_times_are_absolute(loop):
    spans = {c[0]: c[2:] for c in initialised(loop.with_start_time(2000 * MS), "2.01") if c[1] == "setup_experiment"}

    assert spans == {"counter": (2.0, 2.01), "echo": (2.0, 2.01), "plant": (2.0, 2.01)}


def test_the_announced_start_is_the_offset(loop):
    echo = replace(loop.component("echo"), offset=3 * MS)
    shifted = replace(loop, components=(loop.components[0], echo, loop.components[2]))
    spans = {call[0]: call[2:] for call in initialised(shifted, "0.012") if call[1] == "setup_experiment"}

    assert spans["echo"] == (0.003, 0.013)


def test_continuous_components_leave_initialisation_first(loop):
    order = [(name, call) for name, call, *_ in initialised(loop, "0.01") if call in ("enter", "exit")]

    names = ("plant", "counter", "echo")
    assert order == [*((name, "enter") for name in names), *((name, "exit") for name in names)]


def test_late_components_are_initialised_after_the_others_are_restored(loop):
    calls = initialised(loop, "0.02", restore=True, first=8, late=("echo",))

    names = [call[0] for call in calls]
    assert names.index("") > max(k for k, name in enumerate(names) if name in ("counter", "plant"))
    assert names.index("") < names.index("echo")
    assert [call[2:] for call in calls if call[:2] == ("echo", "setup_experiment")] == [(0.01, 0.02)]
