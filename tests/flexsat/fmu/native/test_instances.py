"""Native instances: any number in a process, in the host's memory, and states that go from one to another."""

import ctypes
import math
import subprocess
import sys
from ctypes import byref, c_size_t, c_void_p

import pytest

from fmus.native.native_toy import HERE, build_native_toy, changed_counter
from fmus.raw_fmu import ERROR, OK, Library

HEAD = 96  # bytes before the values in a saved state
ALLOCATE, RELEASE = ctypes.CFUNCTYPE(c_void_p, c_size_t, c_size_t), ctypes.CFUNCTYPE(None, c_void_p)


@pytest.fixture
def library(native_toy, tmp_path):
    return Library(native_toy, tmp_path)


def run(one, first, last):
    """Step with inputs that change, and return all levels and texts."""
    reference = one.library.reference
    found = []
    for k in range(first, last):
        assert one.set("Real", [reference["wheel.torque[1]"]], [0.1 * k]) == OK
        assert one.step(k * 0.01) == OK, one.library.logged
        found += one.get("Real", [reference[f"level[{i}]"] for i in (1, 2, 3)] + [reference["energy"]])[1]
        found += one.get("String", [reference["greeting"]])[1]
    return found


def test_instances_do_not_mix_and_reset_gives_the_same_run(library):
    alone = library.instantiate().initialise()
    expected = run(alone, 0, 20)
    many = [library.instantiate(f"number {k}".encode()).initialise() for k in range(20)]
    halves = [run(one, 0, 10) for one in many]
    assert halves == [expected[: len(halves[0])]] * 20
    assert many[7].call("Reset") == OK
    assert run(many[3], 10, 20) == expected[len(halves[0]) :]
    assert run(many[7].initialise(), 0, 20) == expected
    for one in (alone, *many):
        one.free()


class Heap:
    """Memory functions of a host that counts, and has no more after `limit` blocks."""

    def __init__(self, library):
        self._libc = ctypes.CDLL(None)
        self._libc.calloc.restype, self._libc.calloc.argtypes = c_void_p, (c_size_t, c_size_t)
        self._libc.free.argtypes = (c_void_p,)
        self.held, self.taken, self.limit = set(), 0, None
        self.allocate, self.release = ALLOCATE(self._allocate), RELEASE(self._release)
        library.callbacks.allocate_memory = ctypes.cast(self.allocate, c_void_p)
        library.callbacks.free_memory = ctypes.cast(self.release, c_void_p)

    def _allocate(self, count, size):
        if self.limit is not None and self.taken >= self.limit:
            return None
        self.taken += 1
        block = self._libc.calloc(count, size)
        self.held.add(block)
        return block

    def _release(self, block):
        self.held.remove(block)  # a block that the host did not give, or got back already, is an error
        self._libc.free(block)


def test_memory_is_the_hosts_and_all_of_it_is_given_back(library):
    heap = Heap(library)
    one = library.instantiate().initialise()
    before = heap.taken
    run(one, 0, 10)
    assert heap.taken == before > 0  # the steps allocate nothing
    states = [one.get_state()[1] for _ in range(3)]
    one.deserialise(one.serialise(states[0])[1])
    one.call("Reset")
    one.initialise().set_state(states[1])
    one.free()
    assert heap.held == set()


def test_a_host_without_memory_gets_null_or_an_error_and_no_crash(library):
    heap = Heap(library)
    library.instantiate().initialise().free()
    needed = heap.taken
    made = 0
    for limit in range(needed):
        heap.taken, heap.limit = 0, limit
        library.logged.clear()
        one = library.instantiate()
        if one is None:
            assert library.logged[0][3] == "fmi2Instantiate: there is no memory for the instance"
        else:
            made += 1
            statuses = [one.setup(), one.call("EnterInitializationMode"), one.call("ExitInitializationMode")]
            assert statuses == [OK, OK, ERROR]
            assert library.logged[0][3].startswith("exitInitializationMode: ")
            heap.limit = None
            assert one.call("Reset") == OK
            one.initialise().free()
        assert heap.held == set()
    assert 0 < made < needed
    heap.limit = None
    one = library.instantiate().initialise()
    heap.limit = heap.taken
    status, state = one.get_state()
    assert (status, state.value) == (ERROR, None)
    assert library.logged[-1][3] == "getFMUstate: there is no memory for the state"
    one.free()
    assert heap.held == set()


def test_a_state_that_cannot_be_restored_leaves_the_values_as_they_were(library):
    """The host has no memory for the model of the other parameters: outputs are no results, the rest is unchanged."""
    heap = Heap(library)
    reference = library.reference
    gain, level = reference["gain"], reference["level[1]"]
    one = library.instantiate()
    assert one.set("Real", [gain], [2.5]) == OK
    one.initialise()
    _, state = one.get_state()
    assert one.call("Reset") == OK
    assert one.set("Real", [gain], [3.5]) == OK
    one.initialise()
    heap.limit = heap.taken
    library.logged.clear()
    for _ in range(2):
        assert one.set_state(state) == ERROR
        assert one.get("Real", [gain]) == (OK, [3.5])
        assert math.isnan(one.get("Real", [level])[1][0])
    assert len(library.logged) == 2
    heap.limit = None
    assert one.set_state(state) == OK
    assert one.get("Real", [gain, level]) == (OK, [2.5, 2.5])
    one.free()
    assert heap.held == set()


RESUME = """
import sys
sys.path[:0] = [{tests!r}, {here!r}]
from pathlib import Path
from fmus.raw_fmu import OK, Library
from test_instances import run
library = Library(sys.argv[1], sys.argv[2])
one = library.instantiate()
status, state = one.deserialise(Path(sys.argv[3]).read_bytes())
assert status == one.set_state(state) == OK, library.logged
assert one.get("Real", [library.reference["gain"]]) == (OK, [2.5])
print(run(one, 10, 20))
"""


def test_a_saved_state_goes_on_bitwise_in_the_instance_in_another_and_in_another_process(native_toy, library, tmp_path):
    reference = library.reference
    one = library.instantiate()
    assert one.set("Real", [reference["gain"]], [2.5]) == one.set("Integer", [reference["seed"]], [99]) == OK
    one.initialise()
    run(one, 0, 10)
    _, state = one.get_state()
    _, content = one.serialise(state)
    expected = run(one, 10, 20)
    assert one.set_state(state) == OK
    assert run(one, 10, 20) == expected
    fresh = library.instantiate()
    status, copy = fresh.deserialise(content)
    assert status == fresh.set_state(copy) == OK, library.logged
    assert run(fresh, 10, 20) == expected
    assert fresh.serialise(copy) == (OK, content)
    (tmp_path / "state").write_bytes(content)
    script = RESUME.format(tests=str(HERE.parents[1]), here=str(__file__.rpartition("/")[0]))
    done = subprocess.run(
        [sys.executable, "-c", script, native_toy, tmp_path / "other", tmp_path / "state"],
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert done.stdout.strip() == str(expected)
    one.free()
    fresh.free()


@pytest.fixture(scope="module")
def leaky(tmp_path_factory):
    """Another build of the toy, whose saved states lack its generator."""
    folder = tmp_path_factory.mktemp("leaky")
    main = changed_counter(
        folder,
        ("    int evaluations;", "    unsigned noise;\n    int evaluations;"),
        ("static double draw(State *state)", "static double draw(Own *state)"),
        ("draw(state)", "draw(component->own)"),
    )
    build_native_toy(folder / "toy.fmu", main)
    return Library(folder / "toy.fmu", folder / "unpacked")


def test_a_part_of_the_state_that_is_left_out_is_noticed(leaky):
    one = leaky.instantiate().initialise()
    run(one, 0, 10)
    _, state = one.get_state()
    rest = run(one, 10, 20)
    assert one.set_state(state) == OK
    assert run(one, 10, 20) != rest
    one.free()


def test_damaged_states_and_those_of_another_build_are_refused(library, leaky):
    one = library.instantiate().initialise()
    run(one, 0, 3)
    _, state = one.get_state()
    _, content = one.serialise(state)
    flipped = [bytes((*content[:k], content[k] ^ 4, *content[k + 1 :])) for k in range(0, len(content), 7)]
    cut = [content[:k] for k in (0, 1, 7, 8, 9, 50, 104, len(content) - 8, len(content) - 1)]
    for damaged in (*flipped, *cut, content + b"\0", b"nonsense" * 20):
        library.logged.clear()
        status, handle = one.deserialise(damaged)
        assert (status, handle.value) == (ERROR, None)
        assert "these bytes are not a saved state of this component: cut short, or changed" in library.logged[-1][3]
    assert one.set_state(state) == OK
    foreign = leaky.instantiate().initialise()
    assert foreign.deserialise(content)[0] == ERROR
    guids = (library.guid.decode(), leaky.guid.decode())
    assert guids[0] != guids[1]
    assert leaky.logged[-1][3] == (f"deSerializeFMUstate: the saved state belongs to {guids[0]}, this is {guids[1]}")
    one.free()
    foreign.free()


def test_values_in_a_forged_state_are_checked(library):
    one = library.instantiate().initialise()
    _, state = one.get_state()
    content = one.serialise(state)[1][:-8]
    reals = content.index(bytes.fromhex("000000000000f03f"), HEAD)  # level[1], the first 1.0 behind the head
    gain = reals + 8 * 5
    for place, number, reason in (
        (gain, b"\0\0\0\0\0\0\xf0\xbf", "gain must be >= 0.0, got -1.0 in the saved state"),
        (HEAD, b"\0\0\0\0\0\0\xf8\x7f", "wheel.torque[1] must be finite, got nan in the saved state"),
        (reals, b"\0\0\0\0\0\0\xf0\xff", "level[1] must be finite, got -inf in the saved state"),
        (content.index(b"toy\0"), b"to\xffy\0\0\0\0", "label is no text in the saved state"),
    ):
        forged = content[:place] + number + content[place + 8 :]
        assert one.deserialise(forged + digest(forged))[0] == ERROR
        assert library.logged[-1][3] == f"deSerializeFMUstate: {reason}"
    assert one.deserialise(content + digest(content))[0] == OK
    one.free()


def digest(content):
    """Return the 64-bit FNV-1a sum that ends a saved state."""
    total = 0xCBF29CE484222325
    for byte in content:
        total = (total ^ byte) * 0x100000001B3 % 2**64
    return total.to_bytes(8, "little")


def test_states_are_shared_by_no_two_instances(library):
    one, two = library.instantiate(), library.instantiate(b"two")
    _, state = one.get_state()
    assert two.set_state(state) == ERROR
    assert library.logged[-1][3] == "setFMUstate: no state of this instance: freed, or of another one"
    assert one.call("FreeFMUstate", byref(state)) == OK
    one.free()
    two.free()
