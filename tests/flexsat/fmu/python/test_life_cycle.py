"""The base shell as a Python class, without an FMU."""

from dataclasses import dataclass

import numpy as np
import pytest

from flexsat.fmu.python.life_cycle import ComponentSlave
from flexsat.fmu.python.port_values import Refused
from flexsat.ports.table import Port


@dataclass
class Steps:
    """State of the toy."""

    count: int


class Toy(ComponentSlave):
    """Hold the sum of two inputs; 130 of them, so that references pass 256."""

    description = "toy"
    stop = False
    evaluations = 0
    starts = 0

    def ports(self):
        return (
            Port(name="bias", causality="parameter", unit="m", description="bias", start=1.0),
            Port(name="u", causality="input", unit="m", description="input", size=130),
            Port(name="limited", causality="input", description="input with limits", minimum=0.0, maximum=1.0),
            Port(name="y", causality="output", unit="m", description="output", size=130, depends_on=("u",)),
            Port(name="sum", causality="output", unit="m", description="sum", on_demand=True, depends_on=("u",)),
        )

    def start(self):
        self.starts += 1
        if self.value("bias") > 9.0:
            raise ValueError("bias must be <= 9")
        self.state = Steps(count=0)
        self.view("y")[:] = self.value("bias")

    def advance(self, _time, step):
        if self.stop:
            raise KeyError("model")
        self.state.count += 1
        self.step = step
        self.view("y")[:] = self.view("u") + self.value("bias")

    def evaluate(self):
        self.evaluations += 1
        self.view("sum")[()] = self.view("u").sum()


@pytest.fixture
def toy():
    """An initialised toy."""
    made = Toy(instance_name="toy")
    made.setup_experiment(0.0)
    made.enter_initialization_mode()
    made.exit_initialization_mode()
    assert messages(made) == []
    return made


def messages(shell):
    return [message.msg for message in shell.log_queue]


def references(shell, name):
    span = shell.table.span(name)
    return list(range(span.start, span.stop))


def test_values_pass_in_runs_singly_and_out_of_order(toy):
    u, y = references(toy, "u"), references(toy, "y")
    values = [float(i) for i in range(130)]
    for time in (0.0, 0.1):  # the second time by the plan made in the first
        toy.set_real(u, values)
        assert toy.do_step(time, 0.1) is True
        assert toy.get_real(y) == [value + 1.0 for value in values]
        assert toy.get_real(y[::-1]) == [value + 1.0 for value in values[::-1]]
        assert toy.get_real([y[0], y[2], y[1], y[3]]) == [1.0, 3.0, 2.0, 4.0]
        assert toy.get_real([y[0], y[1], y[2], y[3]]) == [1.0, 2.0, 3.0, 4.0]
        toy.set_real([u[3], u[1]], [30.0, 10.0])
        assert toy.get_real(u[:4]) == [0.0, 10.0, 2.0, 30.0]
    assert toy.get_real([]) == []
    toy.set_real([], [])
    assert messages(toy) == []


def test_large_finite_values_are_accepted_although_their_sum_is_not_finite(toy):
    toy.set_real(references(toy, "u"), [1e308] * 130)
    toy.set_real(references(toy, "u"), [1e308] * 130)

    assert toy.do_step(0.0, 0.1) is True
    assert messages(toy) == []


@pytest.mark.parametrize("value", [float("nan"), float("inf"), -float("inf")])
@pytest.mark.parametrize("warm", [False, True])
def test_a_non_finite_input_is_refused_by_name_also_by_a_kept_plan(toy, value, warm):
    u = references(toy, "u")
    if warm:
        toy.set_real(u, [0.0] * 130)
    toy.set_real(u, [0.0] * 7 + [value] + [0.0] * 122)

    assert messages(toy) == [f"setReal: u[8] must be finite, got {value!r}"]
    assert toy.do_step(0.0, 0.1) is False
    assert toy.state.count == 0
    assert np.isnan(toy.get_real(references(toy, "y"))).all()


@pytest.mark.parametrize(
    ("value", "problem"),
    [
        (1.5, "<= 1.0, got 1.5"),
        (-0.5, ">= 0.0, got -0.5"),
        (float("nan"), "finite, got nan"),
        (float("inf"), "finite, got inf"),
    ],
)
@pytest.mark.parametrize("also", ["", "u"])
def test_limits_are_checked_every_time(toy, value, problem, also):
    both = [*(references(toy, also) if also else []), *references(toy, "limited")]
    for good in (1.0, 0.5):
        toy.set_real(both, [7.0] * (len(both) - 1) + [good])
        assert toy.get_real(both) == [7.0] * (len(both) - 1) + [good]
    toy.set_real(both, [8.0] * (len(both) - 1) + [value])

    assert messages(toy) == [f"setReal: limited must be {problem}"]
    assert toy.get_real(both) == [7.0] * (len(both) - 1) + [0.5]  # nothing of a refused call is written


def test_outputs_on_demand_follow_steps_and_inputs_that_feed_through(toy):
    total, u = references(toy, "sum"), references(toy, "u")
    assert toy.get_real(total) == [0.0]
    toy.get_real(total)
    assert toy.evaluations == 1
    toy.set_real(u, [1.0] * 130)
    assert toy.get_real(total) == [130.0]
    toy.set_real(u, [2.0] * 130)  # by the plan
    assert toy.get_real(total) == [260.0]
    assert toy.evaluations == 3
    toy.do_step(0.0, 0.1)
    toy.get_real(references(toy, "y"))
    assert toy.evaluations == 3


class Lazy(ComponentSlave):
    """Count steps, and show the count on demand."""

    def ports(self):
        return (Port(name="count", causality="output", description="steps done", on_demand=True),)

    def start(self):
        self.state = Steps(count=0)

    def advance(self, _time, _step):
        self.state.count += 1

    def evaluate(self):
        self.view("count")[()] = self.state.count


def test_outputs_on_demand_are_computed_again_after_each_step():
    lazy = Lazy(instance_name="lazy")
    lazy.setup_experiment(0.0)
    lazy.enter_initialization_mode()
    lazy.exit_initialization_mode()
    seen = [lazy.get_real([0])]
    for k in range(3):  # the second time by the plan made in the first
        lazy.do_step(0.1 * k, 0.1)
        seen.append(lazy.get_real([0]))
    saved = lazy._get_fmu_state()
    lazy.do_step(0.3, 0.1)
    lazy._set_fmu_state(saved)

    assert seen == [[0.0], [1.0], [2.0], [3.0]]
    assert lazy.get_real([0]) == [3.0]
    assert messages(lazy) == []


def test_initial_outputs_are_true_during_initialisation():
    toy = Toy(instance_name="toy")
    toy.setup_experiment(0.0)
    toy.enter_initialization_mode()
    y, bias = references(toy, "y"), references(toy, "bias")

    assert toy.get_real(y)[0] == 1.0
    toy.set_real(bias, [2.0])
    assert toy.get_real(y)[0] == 2.0
    toy.exit_initialization_mode()
    assert toy.starts == 2
    assert toy.get_real(y)[0] == 2.0


def test_a_bad_parameter_is_logged_in_one_line_and_stops_the_instance():
    toy = Toy(instance_name="toy")
    toy.set_real(references(toy, "bias"), [10.0])
    toy.setup_experiment(0.0)
    toy.enter_initialization_mode()
    toy.exit_initialization_mode()

    assert messages(toy) == ["exitInitializationMode: bias must be <= 9"]
    assert toy.do_step(0.0, 0.1) is False
    assert np.isnan(toy.get_real(references(toy, "y"))).all()


def test_a_model_error_is_logged_with_its_traceback_and_the_model_is_not_stepped_again(toy):
    toy.stop = True
    assert toy.do_step(0.0, 0.1) is False
    assert messages(toy)[0].startswith("doStep at t = 0.0 s: KeyError: 'model'\nTraceback")
    toy.stop = False
    assert toy.do_step(0.1, 0.1) is False
    assert toy.state.count == 0
    assert messages(toy)[1] == "doStep at t = 0.1 s: refused since: doStep at t = 0.0 s: KeyError: 'model'"


@pytest.mark.parametrize("step", [0.2, 0.0999, 0.0, -0.1, float("nan")])
def test_a_fixed_step_refuses_others_by_name(toy, step):
    toy.fixed_step = 0.1

    assert toy.do_step(0.0, step) is False
    assert messages(toy) == [f"doStep at t = 0.0 s: a step of {step!r} s is not accepted; the step is 0.1 s"]


def test_a_step_rounded_by_the_host_is_the_exact_fixed_step_for_the_model(toy):
    toy.fixed_step = 0.1

    toy._points.restore(1e5, True)
    assert toy.do_step(1e5, 1e5 + 0.1 - 1e5) is True
    assert toy.step == 0.1


@pytest.mark.parametrize("step", [0.0, -0.1, float("nan")])
def test_a_step_that_is_not_positive_is_refused(toy, step):
    assert toy.do_step(0.0, step) is False


def test_a_step_before_initialisation_is_refused():
    toy = Toy(instance_name="toy")

    assert toy.do_step(0.0, 0.1) is False
    assert messages(toy) == ["doStep at t = 0.0 s: not allowed before fmi2EnterInitializationMode"]


def test_a_saved_state_is_a_copy_and_makes_a_failed_instance_usable(toy):
    toy.do_step(0.0, 0.1)
    saved = toy._get_fmu_state()
    toy.set_real(references(toy, "u"), [5.0] * 130)
    toy.do_step(0.1, 0.1)
    toy.stop = True
    toy.do_step(0.2, 0.1)
    toy.stop = False
    toy._set_fmu_state(saved)

    assert toy.state == Steps(count=1)
    assert toy.get_real(references(toy, "y")) == [1.0] * 130
    assert toy.get_real(references(toy, "u")) == [0.0] * 130
    assert toy.do_step(0.1, 0.1) is True


def test_a_state_after_the_start_is_restored_without_a_start_where_the_last_had_its_parameters():
    toy = Toy(instance_name="toy")
    bias, unused = references(toy, "bias"), toy._get_fmu_state()

    def run(value):
        toy._set_fmu_state(unused)
        toy.set_real(bias, [value])
        toy.setup_experiment(0.0)
        toy.enter_initialization_mode()
        toy.exit_initialization_mode()

    def starts_of_restoring(saved):
        before = toy.starts
        toy._set_fmu_state(unused)
        toy._set_fmu_state(saved)
        assert toy.get_real(bias) == [1.0]
        return toy.starts - before

    run(1.0)
    saved = toy._get_fmu_state()
    assert (toy.starts, starts_of_restoring(saved), starts_of_restoring(saved)) == (1, 0, 0)
    toy._set_fmu_state(unused)
    toy.set_real(bias, [2.0])  # and no start
    assert starts_of_restoring(saved) == 0
    run(2.0)
    assert starts_of_restoring(saved) == 1
    run(10.0)  # refused, so that nothing is known to be prepared
    assert (starts_of_restoring(saved), starts_of_restoring(saved)) == (1, 0)
    toy.stop = True
    toy.do_step(0.0, 0.1)  # fails in the model
    assert starts_of_restoring(saved) == 1
    toy.stop = False
    assert toy.do_step(0.0, 0.1) is True
    assert toy.get_real(references(toy, "y")) == [1.0] * 130


def test_messages_are_safe_for_printf_and_for_the_encoding_of_the_wrapper(toy):
    toy._fail("doStep", Refused("50 % of \udc80\0 done"))

    assert messages(toy) == ["doStep: 50 %% of \\udc80 done"]


def test_a_missing_resource_is_named(tmp_path):
    toy = Toy(instance_name="toy", resources=str(tmp_path / "a%20b"))
    (tmp_path / "a b").mkdir()
    with pytest.raises(ValueError, match=r"resource 'model.npz' is missing in .*a b"):
        toy.resource("model.npz")
    (tmp_path / "a b" / "model.npz").touch()
    assert toy.resource("model.npz") == tmp_path / "a b" / "model.npz"


def test_the_date_is_written_only_if_the_environment_gives_one(toy, monkeypatch):
    monkeypatch.delenv("SOURCE_DATE_EPOCH", raising=False)
    assert "generationDateAndTime" not in toy.to_xml().attrib
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "0")
    assert toy.to_xml().attrib["generationDateAndTime"] == "1970-01-01T00:00:00Z"


@pytest.mark.parametrize("value", [float("nan"), float("inf"), -float("inf")])
def test_a_non_finite_output_is_an_error_that_names_it(toy, value):
    toy.advance = lambda *_: toy.view("y").__setitem__(4, value)

    assert toy.do_step(0.0, 0.1) is False
    assert messages(toy) == [f"doStep at t = 0.0 s: output y[5] = {value} is not finite"]
