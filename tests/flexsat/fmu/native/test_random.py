"""Native random numbers against numpy's, bit for bit."""

import ctypes
import shutil

import numpy as np
import pytest

from flexsat.fmu.native.sources import c_files
from flexsat.fmu.native.ziggurat_source import EDGE, ziggurat_header
from fmus.native.twin import compile_library

SEEDS = (0, 1, 12345, 2**31 - 1, 2**32 - 1, 2**32, 987654321987, 2**64 - 1)  # FMI's integers end at 2^31 - 1
FILLERS = """
#include <stddef.h>
#include "random.h"
void fill_normal(Random *random, size_t n, double *out) { while (n--) *out++ = random_normal(random); }
void fill_uniform(Random *random, size_t n, double low, double high, double *out)
{ while (n--) *out++ = random_uniform(random, low, high); }
"""


class State(ctypes.Structure):
    """The generator's state."""

    _fields_ = [(name, ctypes.c_uint64) for name in ("high", "low", "increment_high", "increment_low")]


class Streams:
    """Streams of the C library."""

    def __init__(self, library: ctypes.CDLL) -> None:
        self._library = library

    def begin(self, seed: int, stream: int, child: int) -> State:
        state = State()
        self._library.random_begin(
            ctypes.byref(state), ctypes.c_uint64(seed), ctypes.c_uint32(stream), ctypes.c_uint32(child)
        )
        return state

    def normal(self, state: State, count: int) -> np.ndarray:
        drawn = np.empty(count)
        self._library.fill_normal(ctypes.byref(state), ctypes.c_size_t(count), ctypes.c_void_p(drawn.ctypes.data))
        return drawn

    def uniform(self, state: State, count: int, low: float, high: float) -> np.ndarray:
        drawn, ends = np.empty(count), (ctypes.c_double(low), ctypes.c_double(high))
        self._library.fill_uniform(
            ctypes.byref(state), ctypes.c_size_t(count), *ends, ctypes.c_void_p(drawn.ctypes.data)
        )
        return drawn


@pytest.fixture(scope="module", params=[(), ("-U__SIZEOF_INT128__",)], ids=["128 bits", "64 bits"])
def streams(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Streams:
    """Return the C library, with the products of the compiler and with those from products of 32 bits."""
    if shutil.which("cc") is None:
        pytest.skip("no C compiler: `cc` is not on the path")
    folder = tmp_path_factory.mktemp("random")
    (folder / "fillers.c").write_text(FILLERS)
    return Streams(
        ctypes.CDLL(
            str(compile_library([c_files()["random.c"], folder / "fillers.c"], folder / "random.so", request.param))
        )
    )


def numpys(seed: int, stream: int, child: int) -> np.random.Generator:
    """Return numpy's generator of a stream, as the steppers make it."""
    return np.random.default_rng(np.random.SeedSequence([seed, stream]).spawn(child + 1)[child])


def test_table_in_the_source_is_the_generated_one():
    assert c_files()["ziggurat.h"].read_text() == ziggurat_header()


@pytest.mark.parametrize("seed", SEEDS)
def test_streams_of_a_seed_are_those_of_numpy(streams: Streams, seed: int):
    for stream, child in ((1, 0), (1, 1), (2, 0), (2, 1), (2, 7)):
        expected, state = numpys(seed, stream, child), streams.begin(seed, stream, child)
        np.testing.assert_array_equal(streams.normal(state, 1000), expected.standard_normal(1000))
        turn = 2.0 * np.pi
        np.testing.assert_array_equal(streams.uniform(state, 100, 0.0, turn), expected.uniform(0.0, turn, 100))
        np.testing.assert_array_equal(streams.uniform(state, 100, -3.5, 0.1), expected.uniform(-3.5, 0.1, 100))


def test_two_million_normal_numbers_are_those_of_numpy(streams: Streams):
    expected, state = numpys(3, 2, 0), streams.begin(3, 2, 0)
    numbers = expected.standard_normal(2_000_000)
    # those from beyond the lowest layer, on either side, are among them
    assert numbers.min() < -EDGE
    assert numbers.max() > EDGE
    assert np.count_nonzero(np.abs(numbers) > EDGE) > 400
    np.testing.assert_array_equal(streams.normal(state, len(numbers)), numbers)


def test_copied_state_goes_on_with_the_same_numbers(streams: Streams):
    state = streams.begin(5, 2, 1)
    streams.normal(state, 77)
    copy = State.from_buffer_copy(state)
    np.testing.assert_array_equal(streams.normal(state, 500), streams.normal(copy, 500))
