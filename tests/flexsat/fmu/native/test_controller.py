"""The native controller against the Python stepper: outputs of all designs, slews, delays; messages, saved states."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from flexsat.design.chain import Design
from flexsat.ports import controller as interface
from flexsat.runtime import controller
from flexsat.runtime.controller_parameters import ControllerMatrices
from flexsat.runtime.periods import whole_multiple
from fmus.native.matrices import compile_with_places, give_matrices
from fmus.native.twin import Twin

MEASURED = ("gyro.rate", "accelerometer.acceleration", "encoder.speed", "encoder.angle", "star_tracker.mrp",
            "star_tracker.valid", "applied.wheel.torque", "applied.valid")  # fmt: skip
STATE = ("mrp", "modal.displacement", "rate", "modal.velocity", "wheel.speed")
OUTPUTS = ("wheel.torque", "reference.torque", *(f"{kind}.{name}" for kind in ("reference", "estimate")
           for name in STATE), "estimate.disturbance", "estimate.gyro_bias")  # fmt: skip
UNEQUAL = (1.0, 0.5, 0.8, 0.9, 0.6, 1.1)  # factors of the wheels' limits, over and over
SMALL = (2e-5, 5e-6, -8e-6)  # rad: a slew of 1.5 s
Commands = dict[int, tuple[tuple[float, float, float], float]]  # by the period in which they are set


class Maker:
    """Make instances of a layout's controller, of three sets of matrices that are all different."""

    def __init__(self, design: Design, once: Callable[[str, Callable[[Path], None]], Path]) -> None:
        given, random = design.controller, np.random.default_rng(1)
        self.ports = interface.ports(given)
        self.variants = {
            "corrected": replace(
                given,
                jitter_torque=0.1 * random.normal(size=given.jitter_torque.shape),
                wheel_inertia=given.wheel_inertia * random.uniform(0.5, 1.0, len(given.wheel_inertia)),
            ),
            "published": replace(given, feedback=0.5 * given.feedback),
            "as_published": replace(given, gain_coarse=0.8 * given.gain_coarse, gain_fine=0.7 * given.gain_fine),
        }

        # one of the two without optimisation: quicker to compile, and the numbers agree all the same
        options = ("-O0",) if design.config.name == "centralised" else ()

        def compiled(folder: Path) -> None:
            compile_with_places("controller", self.ports, self.variants, folder, options)

        self.library = once(f"native-controller-{design.config.name}", compiled) / "controller.so"
        give_matrices(self.library, "controller", self.variants)
        self.instances: list[Twin] = []

    def __call__(self, **values: Any) -> Twin:
        self.instances.append(Twin(self.library, self.ports, **values))
        return self.instances[-1]


@pytest.fixture(scope="module")
def made(request: pytest.FixtureRequest, once: Callable[[str, Callable[[Path], None]], Path]) -> Iterator[Maker]:
    """Return a maker of instances, centralised unless a test says otherwise."""
    maker = Maker(request.getfixturevalue(getattr(request, "param", "centralised")), once)
    yield maker
    for instance in maker.instances:
        instance.close()


def measure(twin: Twin, matrices: ControllerMatrices, k: int, size: float, random: np.random.Generator) -> None:
    """Set the measurements of a step; `size` is that of the attitude errors [rad]."""
    time = 5e-3 * k
    for name, amplitude in (("gyro.rate", size), ("accelerometer.acceleration", size), ("encoder.speed", 30.0 * size)):
        view = twin.view(name)
        view[:] = amplitude * (np.sin(0.7 * time + np.arange(view.size)) + 0.1 * random.normal(size=view.size))
    twin.view("encoder.speed")[:] += matrices.nominal_speed
    twin.view("encoder.angle")[:] = time * matrices.nominal_speed + np.arange(len(matrices.nominal_speed))
    twin.view("star_tracker.valid")[:] = k % 20 == 0
    if k % 20 == 0:
        twin.view("star_tracker.mrp")[:] = 0.25 * size * np.sin(0.5 * time + np.arange(1.0, 4.0))
    if twin.view("applied.valid")[0]:
        twin.view("applied.wheel.torque")[:] = 1e-3 * random.normal(size=len(matrices.nominal_speed))


def value_of(twin: Twin) -> Callable[[str], Any]:
    """Return what gives the value of a port of an instance."""

    def value(name: str) -> Any:
        if twin.table[name].kind == "string":
            return twin.text(name)
        return twin.view(name).copy() if twin.table[name].size is not None else twin.view(name)[0].item()

    return value


class Stepper:
    """The Python stepper on the inputs of a native instance."""

    def __init__(self, twin: Twin, variants: dict[str, ControllerMatrices]) -> None:
        self.twin, value = twin, value_of(twin)
        self.matrices = variants[interface.variant(value).name]
        self.prepared = controller.prepare(self.matrices, interface.parameters(self.matrices, value))
        self.state = controller.init(self.prepared, *self._command())
        views = [twin.view(name) for name in MEASURED]
        self.measured = controller.Measurements(*(v.reshape(()) if v.dtype == np.int32 else v for v in views))

    def _command(self) -> tuple[np.ndarray, float]:
        return self.twin.view("command.rotation").copy(), float(self.twin.view("command.start_time")[0])

    def advance(self, time: float) -> np.ndarray:
        """Make a step, and return its outputs."""
        controller.command(self.prepared, self.state, time, *self._command())
        out = controller.step(self.prepared, self.state, time, self.measured)
        estimate = out.estimate[: self.prepared.controlled]
        return np.concatenate([out.torque, out.reference_torque, out.reference, estimate, out.slow_errors])


SCENARIOS: dict[str, tuple[dict[str, Any], Commands, float, int]] = {
    # values of ports, commands, attitude errors [rad], periods
    "nominal, slew after slew": (
        {"star_tracker__fine": True, "command__start_time": 0.9},
        {40: (SMALL, 0.9), 250: ((-1e-5, 3e-5, 0.0), 4.0), 300: ((0.0, 0.0, 0.0), 4.0), 420: ((0.0, 2e-5, 0.0), 4.2)},
        1e-8, 1000,
    ),
    "published, delays, replanned": (
        {"design": "published", "delay__measurement": 5e-3, "delay__actuation": 2e-3, "command__rotation": SMALL,
         "command__start_time": 0.85, "command__during_slew": "replan"},
        {200: ((0.0, 4e-5, 0.0), 0.0), 230: ((1e-5, 0.0, 0.0), 2.0)},
        1e-6, 600,
    ),
    "as published, longest delays": (
        {"as_published": True, "delay__measurement": 0.02, "delay__actuation": 0.02, "command__rotation": SMALL,
         "command__start_time": 1.0},
        {}, 1e-5, 350,
    ),
    "smoothed, far attitude, others in control": (
        {"reference__smoothed": True, "jitter__feed_forward": False, "command__rotation": (0.3, 0.0, 0.1),
         "command__start_time": 1.0, "applied__valid": True},
        {}, 0.8, 300,
    ),
    "round a cone, unequal wheels": (
        {"keep_out__first__direction": (2e-6, -2e-5, 1.0), "keep_out__first__half_angle": 1e-5,
         "command__rotation": (4e-5, 0.0, 0.0), "command__start_time": 0.5, "wheel__torque_limit_factor": UNEQUAL,
         "jitter__imbalance_force_factor": UNEQUAL, "jitter__imbalance_torque_factor": UNEQUAL},
        {}, 1e-8, 1000,
    ),
    "least peak, unequal wheels, gyroscopic": (
        {"slew__least_peak": True, "slew__gyroscopic": True, "command__rotation": (4e-5, 1e-5, -2e-5),
         "command__start_time": 0.5, "wheel__torque_limit_factor": UNEQUAL, "wheel__speed_offset": UNEQUAL},
        {}, 1e-8, 900,
    ),
    "quadratic programme, replanned": (
        {"slew__guidance": "qp", "command__during_slew": "replan", "command__rotation": SMALL,
         "command__start_time": 0.9},
        {300: ((4e-5, 1e-5, -1.5e-5), 0.0)}, 1e-8, 1000,
    ),
    "nominal, torque and biases estimated": (
        {"filter__disturbance": True, "filter__gyro_bias": True, "delay__measurement": 5e-3, "delay__actuation": 7e-3,
         "wheel__torque_limit_factor": UNEQUAL, "command__rotation": SMALL, "command__start_time": 1.2},
        {}, 1e-6, 400,
    ),
    "biases estimated": (
        {"filter__gyro_bias": True, "star_tracker__fine": True, "command__rotation": SMALL,
         "command__start_time": 0.9},
        {}, 1e-7, 250,
    ),
    "torque estimated": (
        {"filter__disturbance": True, "star_tracker__fine": True, "command__rotation": SMALL,
         "command__start_time": 0.9},
        {}, 1e-7, 250,
    ),
    "null motion, unequal wheels, delays": (
        {"wheel__null_motion_rate": 0.3, "wheel__torque_limit_factor": UNEQUAL, "wheel__speed_band_factor": UNEQUAL,
         "delay__measurement": 5e-3, "command__rotation": SMALL, "command__start_time": 0.9},
        {}, 1e-7, 250,
    ),
    "guidance smoothed, open loop": (
        {"slew__guidance": "smoothed", "open_loop": True, "delay__measurement": 7e-3, "command__rotation": SMALL,
         "command__start_time": 0.9, "slew__authority": 0.5},
        {}, 1e-6, 300,
    ),
}  # fmt: skip
FLOWN = [(layout, name) for name in SCENARIOS for layout in ("centralised", "distributed")
         if layout == "distributed" or name.startswith(("nominal", "round"))]  # fmt: skip


@pytest.mark.parametrize(("made", "scenario"), FLOWN, indirect=["made"])
def test_outputs_are_those_of_the_python_stepper(made: Maker, scenario: str):
    values, commands, size, periods = SCENARIOS[scenario]
    wheels = len(made.variants["corrected"].nominal_speed)
    twin = made(**{name: np.resize(value, wheels) if value is UNEQUAL else value for name, value in values.items()})
    twin.start()
    stepper = Stepper(twin, made.variants)
    twin.first_step(5e-3)
    random = np.random.default_rng(2)
    seen, expected = [], []
    for k in range(periods):
        measure(twin, stepper.matrices, k, size, random)
        if k in commands:
            twin.set("command.rotation", commands[k][0])
            twin.set("command.start_time", commands[k][1])
        expected.append(stepper.advance(5e-3 * k))
        twin.advance(5e-3 * k, 5e-3)
        seen.append(np.concatenate([twin.view(name) for name in OUTPUTS]))
    # the programme ends within its own tolerance, which rounding moves
    within = 1e-8 if values.get("slew__guidance") == "qp" else 1e-10
    first = 0
    for name in OUTPUTS:
        columns = slice(first, first + twin.view(name).size)
        wrong = np.abs(np.array(seen)[:, columns] - np.array(expected)[:, columns]).max()
        assert wrong <= within * np.abs(np.array(expected)[:, columns]).max(), name
        first = columns.stop
    torque = np.abs(np.array(expected)[:, : twin.view("wheel.torque").size])
    assert torque.any() != values.get("open_loop", False)
    assert np.array(expected)[:, torque.shape[1] : 2 * torque.shape[1]].any()  # a slew was flown


def test_several_steps_to_a_period_sample_once(made: Maker):
    twin, other = (
        made(command__rotation=SMALL, command__start_time=0.9),
        made(command__rotation=SMALL, command__start_time=0.9),
    )
    for instance, step in ((twin, 1e-3), (other, 5e-3)):
        instance.start()
        instance.first_step(step)
        random = np.random.default_rng(3)
        for k in range(whole_multiple("run", 0.5, step)):
            if k * step % 5e-3 < 1e-9 or 5e-3 - k * step % 5e-3 < 1e-9:
                measure(instance, made.variants["corrected"], round(k * step / 5e-3), 1e-6, random)
            instance.advance(round(k * step / 5e-3) * 5e-3, step)
    assert twin.view("wheel.torque").any()
    assert_array_equal(twin.arrays["real"], other.arrays["real"])


def test_restored_state_goes_on_bit_for_bit(made: Maker):
    values = {"command__rotation": SMALL, "command__start_time": 0.9, "delay__measurement": 5e-3}
    twin, other = made(**values), made(**values)
    twin.start()
    twin.first_step(5e-3)
    random = np.random.default_rng(4)
    for k in range(250):
        measure(twin, made.variants["corrected"], k, 1e-6, random)
        twin.advance(5e-3 * k, 5e-3)
    other.start()  # it has not made a step: its length comes with the state
    other.restore(twin.save())
    for k in range(250, 450):
        for instance in (twin, other):
            measure(instance, made.variants["corrected"], k, 1e-6, np.random.default_rng(k))
            if k == 350:
                instance.set("command.rotation", (0.0, 1e-5, 0.0))
                instance.set("command.start_time", 4.0)
            instance.advance(5e-3 * k, 5e-3)
        assert_array_equal(twin.arrays["real"], other.arrays["real"])


def test_state_that_no_run_reaches_is_refused(made: Maker):
    twin = made()
    twin.start()
    state, values, step = twin.save()
    with pytest.raises(ValueError, match="none that a controller reaches"):
        twin.restore((b"\xff" * len(state), values, step))
    with pytest.raises(ValueError, match="none that a controller reaches"):
        twin.restore((bytes(len(state)), values, step))  # as no motion has it
    twin.restore((state, values, step))


@pytest.mark.parametrize(
    "values",
    [
        {"design": "fancy"},
        {"wheel__torque_limit": 0.0},
        {"wheel__speed_band": -2.5e-7},
        {"slew__authority": 1.5},
        {"slew__guidance": "quick"},
        {"command__during_slew": "ignore"},
        {"initial__capture_angle": 0.0},
        {"delay__measurement": 0.0215},
        {"wheel__torque_limit_factor": -0.5},
        {"wheel__torque_limit_factor": 0.0},
        {"wheel__speed_band_factor": 0.0},
        {"wheel__speed_offset": 3.0},
        {"slew__gyroscopic": True, "reference__smoothed": True},
        {"keep_out__axis": (0.0, 0.0, 0.0)},
        {"keep_out__second__half_angle": 3.5},
        {"keep_out__first__half_angle": 0.2},
        {"keep_out__first__half_angle": 0.2, "keep_out__first__direction": (1.0, 0.0, 0.0), "as_published": True},
        {"filter__gyro_bias": True, "as_published": True},
        {"delay__actuation": 0.0025},
        {"command__rotation": (1e-3, 0.0, 0.0), "command__start_time": 0.1},
        {"command__rotation": (0.0, 1e-3, 0.0), "command__start_time": 0.1, "delay__actuation": 0.003},
    ],
)
def test_bad_parameters_are_refused_in_the_same_words(made: Maker, values: dict[str, Any]):
    twin = made(**values)
    with pytest.raises(ValueError, match=r".") as expected:
        Stepper(twin, made.variants)
    with pytest.raises(ValueError, match=r".") as refused:
        twin.start()
    assert str(refused.value) == str(expected.value)


def test_new_command_during_a_slew_is_refused_in_the_same_words(made: Maker):
    twin = made(command__rotation=SMALL, command__start_time=0.9)
    twin.start()
    stepper = Stepper(twin, made.variants)
    twin.first_step(5e-3)
    twin.set("command.rotation", (1e-5, 0.0, 0.0))
    with pytest.raises(ValueError, match=r".") as expected:
        stepper.advance(1.5)
    with pytest.raises(ValueError, match=r"after the slew of 0\.900 s had begun") as refused:
        twin.advance(1.5, 5e-3)
    assert str(refused.value) == str(expected.value)


@pytest.mark.parametrize(
    ("direction", "angle", "start"),
    [((0.0, 0.0, 1.0), 0.5, 1.0), ((0.0, -1.0, 1.0), 0.6, 1.0), ((1.0, 0.0, 1.0), 0.6, 0.16)],
)
def test_slew_into_a_cone_is_refused_in_the_same_words(
    made: Maker, direction: tuple[float, ...], angle: float, start: float
):
    """It begins there; it ends there; it would begin before the attitude is known."""
    twin = made(keep_out__first__direction=direction, keep_out__first__half_angle=angle,
                command__rotation=(0.8, 0.0, 0.0), command__start_time=start)  # fmt: skip
    twin.start()
    stepper = Stepper(twin, made.variants)
    twin.first_step(5e-3)
    twin.set("star_tracker.valid", start > 0.5)

    def run(advance: Callable[[float], Any]) -> None:
        for k in range(10):
            advance(5e-3 * k)

    with pytest.raises(ValueError, match=r".") as expected:
        run(stepper.advance)
    with pytest.raises(ValueError, match=r"keep_out") as refused:
        run(lambda time: twin.advance(time, 5e-3))
    assert str(refused.value) == str(expected.value)


@pytest.mark.parametrize("seed", [0, 2, 4])
def test_chains_of_turns_round_cones_are_those_of_the_python_stepper(made: Maker, seed: int):
    random = np.random.default_rng(seed)
    twin = made(keep_out__first__direction=random.uniform(-0.1, 0.1, 3) + np.array([0.5, -0.4, 0.9]),
                keep_out__first__half_angle=random.uniform(0.2, 0.5),
                keep_out__second__direction=random.uniform(-0.1, 0.1, 3) + np.array([-0.7, -0.9, 0.1]),
                keep_out__second__half_angle=random.uniform(0.2, 0.5),
                wheel__speed_offset=random.uniform(-0.2, 0.2, 6),
                command__rotation=random.uniform(-0.2, 0.2, 3) + np.array([1.3, 0.9, 0.2]),
                command__start_time=1.0)  # fmt: skip
    twin.start()
    stepper = Stepper(twin, made.variants)
    twin.first_step(5e-3)
    twin.set("star_tracker.valid", True)
    turns = 0
    for time in np.linspace(0.0, 1e4, 150).tolist():  # in leaps: of the slew all turns are seen, of the loop nothing
        expected = stepper.advance(time)
        twin.advance(time, 5e-3)
        seen = np.concatenate([twin.view("reference.torque"), twin.view("reference.mrp")])
        assert_allclose(seen, expected[6:15], rtol=1e-10, atol=1e-12)
        turns = max(turns, stepper.state.turns_ended)
    assert turns >= 1


def test_step_that_does_not_divide_the_period_is_refused(made: Maker):
    twin = made()
    twin.start()
    with pytest.raises(ValueError, match=r"a step of 0\.003 s is not accepted; the controller samples every 0\.005 s"):
        twin.first_step(3e-3)


def test_state_before_a_slew_at_the_end_of_time_is_restored(made: Maker):
    """So late that a slew's times are one number."""
    twin = made(command__rotation=(1e-3, 0.0, 0.0), command__start_time=1.9e19)
    twin.start()
    stepper = Stepper(twin, made.variants)
    twin.first_step(5e-3)
    for k in range(3):
        expected = stepper.advance(5e-3 * k)
        twin.advance(5e-3 * k, 5e-3)
    assert_allclose(twin.view("wheel.torque"), expected[:6], rtol=1e-10)
    saved = twin.save()
    twin.advance(0.015, 5e-3)
    after = twin.view("wheel.torque").copy()
    twin.restore(saved)
    twin.advance(0.015, 5e-3)
    assert_array_equal(twin.view("wheel.torque"), after)
