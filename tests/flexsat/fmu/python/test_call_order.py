"""Calls in every phase of the shell as a Python class, against the table of the standard."""

import pytest

from flexsat.fmu.python.life_cycle import ComponentSlave
from flexsat.ports.table import Port

PHASES = ("instantiated", "initialization", "complete", "terminated", "error")
# FMI 2.0.4, section 4.2.4
ALLOWED = {
    "setup_experiment": {"instantiated"},
    "enter_initialization_mode": {"instantiated"},
    "exit_initialization_mode": {"initialization"},
    "do_step": {"complete"},
    "terminate": {"complete"},
    "get_real": {"initialization", "complete", "terminated", "error"},
    "get_boolean": {"initialization", "complete", "terminated", "error"},
    "set_real": {"instantiated", "initialization", "complete"},
    "set_boolean": {"instantiated", "initialization", "complete"},
}
ARGUMENTS = {
    "setup_experiment": (0.0,), "do_step": (0.0, 0.1), "get_real": ([0],), "set_real": ([0], [1.0]),
    "get_boolean": ([],), "set_boolean": ([], []),
}  # fmt: skip


class Toy(ComponentSlave):
    """Pass an input through."""

    def ports(self):
        return (
            Port(name="u", causality="input", description="input"),
            Port(name="y", causality="output", description="output"),
        )

    def start(self):
        self.steps = 0

    def advance(self, _time, _step):
        self.steps += 1
        self.view("y")[()] = self.view("u")


def in_phase(phase):
    toy = Toy(instance_name="toy")
    toy.setup_experiment(0.0)
    if phase in PHASES[1:]:
        toy.enter_initialization_mode()
    if phase in PHASES[2:]:
        toy.exit_initialization_mode()
    if phase == "terminated":
        toy.terminate()
    if phase == "error":
        toy.do_step(0.0, -1.0)
        toy.log_queue.clear()
    assert toy.log_queue == []
    return toy


@pytest.mark.parametrize("phase", PHASES)
@pytest.mark.parametrize("call", ALLOWED)
def test_each_call_in_each_phase(call, phase):
    toy = in_phase(phase)
    getattr(toy, call)(*ARGUMENTS.get(call, ()))

    if phase in ALLOWED[call]:
        assert toy.log_queue == []
        return
    (message,) = toy.log_queue
    assert "not allowed " in message.msg or ": refused since: doStep at t = 0.0 s: a step of -1.0 s" in message.msg
    assert (message.status, message.category) == (3, "logStatusError")
    assert toy.do_step(0.0, 0.1) is False  # the error lasts
    assert getattr(toy, "steps", 0) == 0


def test_initialisation_needs_an_experiment():
    toy = Toy(instance_name="toy")
    toy.enter_initialization_mode()

    assert toy.log_queue[0].msg == "enterInitializationMode: not allowed before fmi2SetupExperiment"
