"""Parameters that a host may change during a run."""

from dataclasses import dataclass

import pytest

from flexsat.fmu.python.life_cycle import ComponentSlave
from flexsat.ports.table import Port, PortTable


@dataclass
class State:
    """Nothing."""


class Tuned(ComponentSlave):
    """Multiply by a gain that may change, and by one that may not."""

    description = "tuned"
    notes = starts = 0

    def ports(self):
        return (
            Port(name="y", causality="output", description="output"),
            Port(name="fixed_gain", causality="parameter", description="gain", start=2.0),
            Port(name="gain", causality="parameter", description="gain", start=1.0, variability="tunable"),
        )

    def start(self):
        self.starts += 1
        self.state = State()
        self.view("y")[()] = 0.0

    def advance(self, _time, _step):
        self.view("y")[()] = self.value("fixed_gain") * self.value("gain")

    def tuned(self):
        self.notes += 1


@pytest.fixture
def running():
    made = Tuned(instance_name="tuned")
    made.setup_experiment(0.0)
    made.enter_initialization_mode()
    made.set_real([2], [1.5])  # before the run it is a parameter like any other
    made.exit_initialization_mode()
    return made


def test_a_tunable_parameter_may_be_set_in_a_run_and_the_component_is_notified_each_time(running):
    assert running.notes == 0
    seen = []
    for k, gain in enumerate((3.0, 4.0, 4.0)):
        running.set_real([2], [gain])
        running.do_step(k * 1e-3, 1e-3)
        seen += running.get_real([0])

    assert seen == [6.0, 8.0, 8.0]
    assert running.notes == 3


def test_what_was_tuned_since_a_state_was_saved_is_prepared_again_also_after_a_state_before_the_start(running):
    unused, saved = Tuned(instance_name="unused")._get_fmu_state(), running._get_fmu_state()
    running.set_real([2], [3.0])
    running._set_fmu_state(unused)
    running._set_fmu_state(saved)

    assert (running.starts, running.get_real([2])) == (2, [1.5])


def test_fixed_parameters_are_refused_in_a_run(running):
    running.set_real([1], [3.0])

    assert running.log_queue[0].msg == (
        "setReal: fixed_gain is a fixed parameter and cannot be set after initialisation, got 3.0"
    )


def test_the_model_description_marks_tunable_parameters(running):
    variables = running.to_xml().find("ModelVariables")

    assert [v.get("variability") for v in variables] == ["continuous", "fixed", "tunable"]
    assert [v.get("initial") for v in variables] == ["calculated", "exact", "exact"]


def test_only_a_parameter_is_tunable():
    with pytest.raises(ValueError, match="a real input cannot be 'tunable'"):
        PortTable([Port(name="u", causality="input", description="input", variability="tunable")])
