"""What the native plant refuses: with the words of the Python component, without a crash, without lost memory."""

import ctypes

import numpy as np
import pytest

from flexsat.ports import plant as interface
from flexsat.runtime import plant
from flexsat.variants import chosen_by
from fmus.native.twin import Twin


@pytest.fixture(scope="module")
def native(plant_library, plants):
    """Return a maker of native plants."""
    return lambda **values: Twin(plant_library, interface.ports(plants["corrected"]), **values)


def refusal_of(start):
    """Return the words with which a start is refused."""
    try:
        start()
    except ValueError as error:
        return str(error)
    raise AssertionError("nothing was refused")


def python_says(native, plants):
    """Return the words with which the Python component refuses the values of a native one."""
    kinds = {"real": float, "integer": int, "boolean": bool}

    def value(name):
        port, values = native.table[name], native.view(name)
        return values.copy() if port.size is not None else kinds[port.kind](values[0])

    def start():
        matrices = interface.simulated(plants[chosen_by(value).name], value)
        plant.prepare(matrices, interface.parameters(matrices, value), 1e-3)

    return refusal_of(start)


@pytest.mark.parametrize(
    "values",
    [
        {"modes": 26, "as_published": 1},
        {"modes": -1},
        {"seed": -3},
        {"initial__mrp": [1.0, 0.5, 0.0]},
        {"wheel__torque_limit": 0.0},
        {"wheel__torque_limit": np.nan},
        {"wheel__torque_limit_factor": -0.5},
        {"wheel__speed_limit": np.nan},
        {"wheel__torque_step": -1e-3},
        {"wheel__speed_limit": 100.0, "wheel__full_torque_speed": 100.5},
        {"dispersion__frequency": -1.0},
        {"dispersion__inertia": [0.1, -1.0, 0.0]},
        {"dispersion__damping": -1.25},
        {"dispersion__participation": -1.5},
        {"dispersion__inertia": [-0.2, 0.1, -0.3]},
        {"dispersion__participation": 0.25, "dispersion__inertia": [0.0, 1e-5, 0.0]},
    ],
    ids=lambda values: " ".join(f"{name}={np.ravel(value)}" for name, value in values.items()),
)
def test_parameters(native, plants, values):
    twin = native(**values)
    assert refusal_of(twin.start) == python_says(twin, plants)


@pytest.mark.parametrize("name", ["initial.modal.displacement", "initial.modal.velocity"])
def test_motion_of_a_mode_that_is_not_simulated(native, plants, name):
    twin = native(modes=6)
    twin.view(name)[9] = 1.25e-7
    said = refusal_of(twin.start)
    assert said == f"{name}[10] = 1.25e-07: 6 modes are simulated; set it to 0"
    assert said == python_says(twin, plants)


def test_steps(native):
    twin = native(modes=3)
    twin.start()
    with pytest.raises(ValueError, match=r"^a step of 0\.0 s is not accepted; the shortest is 1e-9 s$"):
        twin.advance(0.0, 1e-10)
    before = twin.save()
    twin.advance(0.0, 1e-9)
    assert twin.save() != before


def test_a_motion_that_diverges(native):
    twin = native(modes=3, initial__rate=[0.2, 0.2, -0.2])
    twin.start()
    reason = "the motion has diverged: steps of 20 s are too long for this rate; take shorter ones"
    with pytest.raises(ValueError, match=reason):
        twin.advance(0.0, 20.0)


def test_inputs_that_are_not_numbers(native):
    twin = native(modes=3)
    twin.start()
    twin.view("external.torque")[1] = np.nan
    with pytest.raises(ValueError, match="the motion has diverged"):
        twin.advance(0.0, 1e-3)


def test_a_saved_state_without_a_step(native):
    twin = native(modes=3)
    twin.start()
    state, values, length = twin.save()
    with pytest.raises(ValueError, match="the saved state has a step of"):
        twin.restore((b"\xff" * len(state), values, length))


def test_memory_that_is_refused(native):
    """The host gives the first blocks only: each time the start is refused, and all of them are released."""
    twin = native(modes=2)
    heap = ctypes.CDLL(None)
    heap.calloc.restype, heap.calloc.argtypes = ctypes.c_void_p, [ctypes.c_size_t, ctypes.c_size_t]
    heap.free.restype, heap.free.argtypes = None, [ctypes.c_void_p]
    given: set[int] = set()
    most = 0

    def allocate(count, size):
        if len(given) >= most:
            return None
        address = heap.calloc(count, size)
        given.add(address)
        return address

    def release(address):
        given.remove(address)
        heap.free(address)

    functions = (
        ctypes.CFUNCTYPE(ctypes.c_void_p, ctypes.c_size_t, ctypes.c_size_t)(allocate),
        ctypes.CFUNCTYPE(None, ctypes.c_void_p)(release),
    )
    for name, function in zip(("allocate", "release"), functions, strict=True):
        setattr(twin.component.memory, name, ctypes.cast(function, ctypes.c_void_p).value)
    refusals = set()
    for most in range(1000):  # noqa: B007  # `allocate` reads it
        try:
            twin.start()
        except ValueError as refusal:
            refusals.add(str(refusal))
        else:
            break
        finally:
            twin.close()
        assert not given
    assert refusals == {"there is not enough memory"}
    assert 50 < most < 500
