"""The exported controller: bitwise that of the FMU in doubles, near it in floats; memory, states and refusals."""

import shutil
import subprocess
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from flexsat.design.chain import Design
from flexsat.fmu.embedded.export import EXAMPLE, HEADER, controller_files
from flexsat.fmu.embedded.header import PRECISIONS
from flexsat.ports import controller as interface
from flexsat.ports.table import PortTable
from flexsat.runtime.slew_optimum import STEPS
from fmus.native.exported import WARNINGS, Exported, compile_export, constant, target_sources
from fmus.native.matrices import compile_with_places, give_matrices
from fmus.native.twin import Twin

pytestmark = pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler: `cc` is not on the path")

Once = Callable[[str, Callable[[Path], None]], Path]
OUTPUTS = ("wheel.torque", "reference.torque", *(f"{kind}.{name}" for kind in ("reference", "estimate") for name in
           ("mrp", "modal.displacement", "rate", "modal.velocity", "wheel.speed")),
           "estimate.disturbance", "estimate.gyro_bias")  # fmt: skip
MEASURED = ("gyro.rate", "accelerometer.acceleration", "encoder.speed", "encoder.angle", "star_tracker.mrp",
            "star_tracker.valid", "command.rotation", "command.start_time")  # fmt: skip
SMALL = (2e-5, 5e-6, -8e-6)  # rad: a slew of 1.5 s
DELAYS = {"delay_measurement": 3e-3, "delay_actuation": 9e-3}


class Exports:
    """The exports of a design and the libraries made from them."""

    def __init__(self, design: Design, once: Once) -> None:
        given = design.controller  # with few of its phases: quicker to write and to compile
        self.matrices = replace(given, gain_coarse=given.gain_coarse[:2], gain_fine=given.gain_fine[:2])
        self.table = PortTable(interface.ports(self.matrices))
        self.files = {p: controller_files(self.matrices, "centralised", "robust", p) for p in PRECISIONS}
        self.libraries = {}
        for precision in PRECISIONS:

            def make(folder: Path, precision: str = precision) -> None:
                compile_export(self.files[precision], folder, ["-O0", "-pedantic"])  # quick; the numbers are the same

            self.libraries[precision] = once(f"exported-controller-{precision}", make) / "controller.so"

    def __call__(self, precision: str = "double", **parameters: object) -> Exported:
        return Exported(self.libraries[precision], self.table, self.files[precision][HEADER], **parameters)


@pytest.fixture(scope="module")
def exports(centralised: Design, once: Once) -> Exports:
    return Exports(centralised, once)


def measurements(exports: Exports, k: int, random: np.random.Generator) -> dict[str, object]:
    """Return the inputs of a step of 5 ms: noise, and a slew that is commanded after a second."""
    nominal = exports.matrices.nominal_speed
    return {
        "gyro.rate": 1e-6 * random.normal(size=exports.matrices.gyros),
        "accelerometer.acceleration": 1e-6 * random.normal(size=exports.matrices.accelerometers),
        "encoder.speed": nominal + 1e-4 * random.normal(size=nominal.size),
        "encoder.angle": (5e-3 * k * nominal + np.arange(nominal.size)) % (2.0 * np.pi),
        "star_tracker.mrp": 1e-7 * random.normal(size=3),
        "star_tracker.valid": k % 20 == 0,
        "command.rotation": SMALL if k >= 200 else (0.0, 0.0, 0.0),
        "command.start_time": 1.6 if k >= 200 else 5.0,
    }


def fly(exports: Exports, controller: Exported, first: int, last: int, seed: int = 1) -> np.ndarray:
    """Return the outputs of steps with inputs that follow from the seed."""
    rows = []
    random = np.random.default_rng(seed)
    for k in range(last):
        given = measurements(exports, k, random)
        if k < first:
            continue
        for name, value in given.items():
            controller.set(name, value)
        if k == 0:
            assert controller.init() == "ok"
        assert controller.step() == "ok", controller.reason
        rows.append(controller.result())
    return np.array(rows)


def test_in_doubles_it_is_the_controller_of_the_fmu_bit_for_bit(exports, once):
    def compiled(folder: Path) -> None:
        variants = dict.fromkeys(("corrected", "published", "as_published"), exports.matrices)
        compile_with_places("controller", interface.ports(exports.matrices), variants, folder, ("-O0",))

    library = once("native-controller-centralised", compiled) / "controller.so"
    give_matrices(library, "controller", {"corrected": exports.matrices})
    twin = Twin(library, interface.ports(exports.matrices), **{k.replace("_", "__"): v for k, v in DELAYS.items()})
    random = np.random.default_rng(1)
    expected = []
    for k in range(500):
        for name, value in measurements(exports, k, random).items():
            twin.view(name)[:] = value
        if k == 0:
            twin.start()
            twin.first_step(5e-3)
        twin.advance(k * 5_000_000 / 1e9, 5e-3)
        expected.append(np.concatenate([twin.view(name) for name in OUTPUTS]))
    twin.close()

    found = fly(exports, exports(**DELAYS), 0, 500)

    assert np.abs(found[:, 12:18]).max() > 1e-6, "it slews"
    assert found.tobytes() == np.array(expected).tobytes()


def test_in_floats_the_torque_is_that_in_doubles_but_for_their_rounding(exports):
    exact, rounded = (fly(exports, exports(precision), 0, 500) for precision in PRECISIONS)
    torque, expected = rounded[:, :6], exact[:, :6]

    # a float has 6e-8 of the largest estimate, which is that of the attitude times the gain of 500 N.m/rad
    assert_allclose(torque, expected, rtol=0.0, atol=1e-4 * np.abs(expected).max())
    assert not np.array_equal(torque, expected)


@pytest.mark.parametrize("precision", PRECISIONS)
def test_it_continues_from_a_saved_state_bit_for_bit(exports, precision):
    one, other = exports(precision, **DELAYS), exports(precision, **DELAYS)
    fly(exports, one, 0, 340)  # in the middle of the slew
    state = one.save()
    rest = fly(exports, one, 340, 400)

    assert other.restore(state) == "ok"
    assert_array_equal(fly(exports, other, 340, 400), rest)


def test_it_refuses_states_that_are_damaged_or_of_another_controller(exports):
    controller = exports(**DELAYS)
    fly(exports, controller, 0, 30)
    state = controller.save()
    before = controller.save()

    assert controller.restore(state[:100] + bytes([state[100] ^ 1]) + state[101:]) == "failed"
    assert controller.reason == "the saved state is damaged"
    assert controller.save() == before
    for parameters in ({}, DELAYS | {"slew_authority": 0.5}, DELAYS | {"slew_guidance": 2}):
        other = exports(**parameters)
        other.init()
        assert other.restore(state) == "failed"
        assert other.reason == "the saved state is that of another design, or of other parameters"
    single = exports("float", **DELAYS)
    single.init()
    assert single.restore(state[: single.state_size]) == "failed"


def test_inputs_that_are_no_numbers_change_nothing(exports):
    one, other = exports(), exports()
    fly(exports, one, 0, 50)
    before, shown = one.save(), one.result()
    one.inputs.gyro_rate[3] = float("nan")

    assert one.step() == "bad input"
    assert one.reason == "an input is not finite"
    assert (one.save(), one.result().tobytes()) == (before, shown.tobytes())
    fly(exports, other, 0, 50)
    assert_array_equal(fly(exports, one, 50, 60), fly(exports, other, 50, 60))


def test_a_refused_command_leaves_the_controller_in_control(exports):
    controller, plain = exports(), exports()
    flown = fly(exports, plain, 0, 341)
    fly(exports, controller, 0, 340)
    random = np.random.default_rng(1)
    for k in range(341):
        given = measurements(exports, k, random)
    for name, value in given.items():
        controller.set(name, value)
    controller.set("command.rotation", (1e-5, 0.0, 0.0))  # during the slew

    assert controller.step() == "command refused"
    assert "command.rotation changed at 1.7 s, after the slew of 1.6 s had begun" in controller.reason
    assert_array_equal(controller.result(), flown[-1])


@pytest.mark.parametrize(
    ("parameters", "reason"),
    [
        ({"delay_measurement": 0.0015},
         "delay.measurement must be whole milliseconds from 0 to 0.02 s, got 0.0015"),
        ({"wheel_torque_limit": -1.0}, "parameter wheel.torque_limit must lie within its limits, got -1"),
        ({"slew_authority": float("nan")}, "parameter slew.authority must lie within its limits, got nan"),
        ({"wheel_speed_offset": [12345.678, *[0.0] * 5]},
         "parameter wheel.speed_offset must lie within its limits, got 12345.7"),
        ({"initial_capture_angle": 0.0}, "initial.capture_angle must be > 0, got 0"),
        ({"slew_guidance": 7}, "parameter slew.guidance must be one of the enumeration, got 7"),
    ],
)  # fmt: skip
def test_parameters_are_refused_with_name_and_value(exports, parameters, reason):
    controller = exports(**parameters)

    assert controller.prepare(controller.memory_size) is False
    assert controller.reason == reason


def test_the_stated_memory_is_enough_and_little_more(exports):
    largest = {"delay_measurement": 0.02, "delay_actuation": 0.02, "slew_guidance": 2, "star_tracker_fine": 1,
               "keep_out_first_direction": (1.0, 0.0, 0.0), "keep_out_first_half_angle": 0.2}  # fmt: skip
    for precision in PRECISIONS:
        controller = exports(precision, **largest)
        least, most = controller.memory_size // 2, controller.memory_size
        assert controller.prepare(most), controller.reason
        assert not controller.prepare(64)
        assert controller.reason == "the memory is too small, or not aligned as a double is"
        for _ in range(4):
            middle = (least + most) // 2
            least, most = (least, middle) if controller.prepare(middle) else (middle, most)
        assert most > 0.75 * controller.memory_size
    assert STEPS == 200  # as the page of the export says


def test_a_programme_of_a_slew_runs_in_the_callers_memory(exports):
    controller = exports(slew_guidance=2)
    controller.set("command.rotation", (8e-3, 0.0, 0.0))
    controller.set("command.start_time", 5.0)

    assert controller.init() == "ok", controller.reason
    assert controller.step() == "bad input" or controller.step() == "ok"


@pytest.mark.skipif(shutil.which("clang") is None, reason="no clang")
@pytest.mark.parametrize("precision", PRECISIONS)
def test_clang_has_no_warning_for_a_target_without_an_operating_system(exports, precision, tmp_path):
    for name, content in exports.files[precision].items():
        (tmp_path / name).write_bytes(content)
    sources = [name for name in target_sources(tmp_path) if name != "data.c"]
    command = ["clang", "-std=c99", "-ffreestanding", "-pedantic", *WARNINGS, "-fsyntax-only", *sources, *EXAMPLE[:2]]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)

    assert (done.returncode, done.stderr) == (0, "")
    texts = [(tmp_path / name).read_text() for name in sources]
    assert not any(header in text for text in texts for header in ("<stdio.h>", "<stdlib.h>", "<time.h>"))


def test_the_linker_sees_names_of_its_own_and_needs_libm_and_copies_of_memory(exports):
    if shutil.which("nm") is None:
        pytest.skip("no nm")

    def symbols(option: str) -> set[str]:
        command = ["nm", option, "-D", "--format=posix", exports.libraries["double"]]
        lines = subprocess.run(command, capture_output=True, text=True, check=True).stdout.splitlines()
        return {line.split()[0].partition("@")[0] for line in lines}

    libc = {"memcpy", "memmove", "memset"}
    libm = {"atan2", "ceil", "cos", "fmod", "floor", "fmax", "fmin", "log", "log10", "log2", "ldexp", "pow", "rint",
            "sin", "sqrt", "acos", "asin", "tan", "exp", "fabs", "atan", "hypot"}  # fmt: skip
    toolchain = {"_ITM_deregisterTMCloneTable", "_ITM_registerTMCloneTable", "__cxa_finalize", "__gmon_start__"}
    assert symbols("--undefined-only") <= libc | libm | toolchain
    assert {name for name in symbols("--defined-only") if not name.startswith(("flexsat_", "_"))} == set()


def test_the_page_and_the_header_name_sizes_rates_and_units(exports):
    header = exports.files["float"][HEADER].decode()
    page = exports.files["float"]["README.md"].decode()

    assert "    /* measured rate about each gyro's axis: bus x y z, then x y at each site [rad/s] */\n" in header
    assert f"    FlexsatReal gyro_rate[{exports.matrices.gyros}];" in header
    assert "    double star_tracker_mrp[3];" in header
    assert "typedef float FlexsatReal;" in header
    assert "every 5 ms (200 Hz)" in page
    assert f"{constant(exports.files['float'][HEADER], 'FLEXSAT_MEMORY_SIZE'):,} bytes" in page
    assert "| `wheel_torque` | 6 | N.m |" in page
    assert "What is in floats" in page
    assert "What is in floats" not in exports.files["double"]["README.md"].decode()
