"""Every parameter has limits, and at them the components give finite and sound results, or refuse in one line."""

import numpy as np
import pytest

from flexsat.design.chain import Designs
from flexsat.fmu.build import SHELLS, component_resources
from flexsat.fmu.python.load_matrices import MODEL_FILE
from flexsat.ports.plant import FASTEST, LARGEST
from flexsat.runtime import plant as stepper
from flexsat.variants import VARIANTS

STEPS = 20


@pytest.fixture(scope="module", params=SHELLS)
def shell(request, centralised, tmp_path_factory):
    """Return a maker of one of the three components of the centralised design, outside an FMU."""
    folder = tmp_path_factory.mktemp(request.param)
    designs = Designs(dict.fromkeys(VARIANTS, centralised))
    (folder / MODEL_FILE).write_bytes(component_resources(designs, request.param)[MODEL_FILE])
    return lambda: SHELLS[request.param](instance_name=request.param, resources=str(folder))


def numbers(table):
    """Return the ports that are set and are no flags."""
    return [port for port in table if port.causality == "parameter" and port.kind in ("real", "integer")]


def test_every_parameter_but_the_seed_has_a_minimum_and_a_maximum(shell):
    unlimited = {p.name for p in numbers(shell().table) if p.minimum is None or p.maximum is None}

    assert unlimited <= {"seed"}


def test_at_each_limit_outputs_are_finite_or_the_value_is_refused_in_one_line(shell):
    table = shell().table
    references = list(range(table.run("output").start, table.run("output").stop))
    for port in numbers(table):
        of_port = [v.value_reference for v in table.variables if v.port is port]
        for limit in (port.minimum, port.maximum):
            if limit is None:
                continue
            slave = shell()
            value = limit if port.kind == "real" else int(limit)
            getattr(slave, f"set_{port.kind}")(of_port, [value] * port.length)
            slave.setup_experiment(0.0)
            slave.enter_initialization_mode()
            slave.exit_initialization_mode()
            h = slave.fixed_step or slave.preferred_step
            while not slave.log_queue and (k := slave._points.present / h) < STEPS:
                slave.do_step(slave._points.present, h)
                assert slave.log_queue or np.isfinite(slave.get_real(references)).all(), (port.name, limit, k)
            for message in slave.log_queue:  # in the first step where that gives its length
                assert message.msg.startswith(("exitInitializationMode: ", "doStep at t = 0.0 s: ")), (
                    port.name,
                    limit,
                    message.msg,
                )
                assert "\n" not in message.msg, message.msg


@pytest.mark.parametrize(
    "start",
    [
        {"rate": np.full(3, FASTEST)},
        {"modal_velocity": np.full(25, LARGEST), "modal_displacement": np.full(25, LARGEST)},
    ],
    ids=["rate", "modes"],
)
def test_energy_without_damping_is_kept_at_the_fastest_motion_that_is_accepted(centralised, quiet_run, start):
    run = quiet_run(centralised.plant, damping_dispersion=np.full(25, -1.0), **start)
    plant = stepper.prepare(centralised.plant, run, 1e-3)
    state, nothing = stepper.init(plant), np.zeros(plant.input_count)
    before = stepper.telemetry(plant, state).energy
    for _ in range(2000):
        stepper.step(plant, state, nothing)
    after = stepper.telemetry(plant, state).energy

    assert abs(after / before - 1.0) < 1e-4  # as ports/plant.py states; at 0.5 rad/s it is 12 %


def test_motion_that_diverges_is_refused_in_words(centralised, quiet_run):
    """It is found by the rotation of one step: half a turn is too much, and not-a-number too."""
    plant = stepper.prepare(centralised.plant, quiet_run(centralised.plant, rate=np.full(3, 5.0)), 1e-3)
    state, nothing = stepper.init(plant), np.zeros(plant.input_count)

    def run():
        for _ in range(1000):
            stepper.step(plant, state, nothing)

    with pytest.raises(ValueError, match=r"the motion has diverged: steps of 0\.001 s are too long for this rate"):
        run()


@pytest.mark.parametrize("error", [-1.0000001, -2.0, -10.0])
def test_negative_damping_is_refused(centralised, quiet_run, error):
    errors = np.zeros(25)
    errors[3] = error
    with pytest.raises(ValueError, match=rf"^dispersion.damping: every relative error must be >= -1, got {error}$"):
        quiet_run(centralised.plant, damping_dispersion=errors)
