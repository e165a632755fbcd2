"""Every type of FMI 3.0 from one FMU to another: extremes, arrays in part, narrower types, and what is refused."""

import zipfile
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from lockstep import Component, Connection, InputError, RunError, System, read_signals, simulate
from lockstep.checkpoint.file import read_checkpoint
from lockstep.checkpoint.restart import Restart
from lockstep.checkpoint.schedule import CheckpointSchedule
from lockstep.fmi.model_description import read_description

STEP = 10_000_000  # [ns]
ROWS = 6  # of five steps: at the start of each, and at the stop time
ISOLATED = pytest.mark.parametrize("isolated", [False, True], ids=["inside", "isolated"])

SENT = {  # by the name without _in
    "Float64": 5e-324,
    "Float32": float(np.float32(3.4e38)),
    "Int8": -128,
    "Int16": 2**15 - 1,
    "Int32": -(2**31),
    "Int64": -(2**63),
    "UInt8": 255,
    "UInt16": 2**16 - 1,
    "UInt32": 2**32 - 1,
    "UInt64": 2**64 - 1,
    "Boolean": True,
    "String": "Größe → 1 \t<&>",
    "Enumeration": 7,
    "vector": [1.5, -2.5, 3.5],
    "matrix": [1.0, 2.0, 3.0, 4.0, 5.0, 6.0],
    "narrow": [0.5, -0.25],
    "whole": [2**63 - 1, -(2**63) + 1],
    "flags": [True, False],
    "words": ["", "zwei Worte"],
}
SHAPES = {"vector": (3,), "matrix": (2, 3), "narrow": (2,), "whole": (2,), "flags": (2,), "words": (2,)}


def elements(name):
    """Return the names of the elements of a port, without its end and with it: `vector[1]`, ..."""
    indices = [",".join(str(k + 1) for k in index) for index in np.ndindex(SHAPES.get(name, ()))]
    return [f"[{index}]" if index else "" for index in indices]


def inputs(**changes):
    """Return values for all inputs of a feedthrough."""
    found = {}
    for name, value in (SENT | changes).items():
        for index, item in zip(elements(name), value if isinstance(value, list) else [value], strict=True):
            found[f"{name}_in{index}"] = item
    return found


def wires(*names, source="one", target="two"):
    """Connect all elements of ports."""
    return tuple(
        Connection(from_component=source, output=f"{name}_out{index}", to_component=target, input=f"{name}_in{index}")
        for name in names
        for index in elements(name)
    )


@pytest.fixture
def two(reference_fmu):
    """Return a function that puts two feedthroughs of FMI 3.0 in a row, the second fed by connections."""

    def made(connections, isolated=False, more=(), **parameters):
        fed = {connection.input for connection in connections}
        one = Component(
            name="one", source=reference_fmu("feedthrough", "3.0"), period=STEP, kind="sampled", isolated=isolated,
            parameters=inputs(**parameters),
        )  # fmt: skip
        two = replace(one, name="two", parameters={k: v for k, v in inputs().items() if k not in fed})
        return System(name="two", tick=STEP, stop_time=5 * STEP, components=(*more, one, two), connections=connections)

    return made


@ISOLATED
def test_values_of_every_type_arrive_and_are_recorded_unchanged(two, tmp_path, isolated):
    simulate(two(wires(*SENT), isolated), tmp_path / "out")
    signals = read_signals(tmp_path / "out")

    for name, value in SENT.items():
        column = signals[f"two.{name}_out"]
        assert column.tolist() == [value] * ROWS, name
    assert signals["two.UInt64_out"].dtype == np.uint64
    assert signals["two.whole_out"].dtype == np.int64
    assert signals["two.UInt8_out"].dtype == np.float64
    assert signals.units["two.vector_out[2]"] == "mm"


@ISOLATED
def test_array_elements_are_set_one_by_one(two, reference_fmu, tmp_path, isolated):
    """Some by connections, of two rates and with a unit converted, the others keep their start values."""
    metres = Component(
        name="metres", source=reference_fmu("integrator", "3.0"), period=2 * STEP, kind="sampled",
        parameters={"u": 1.0, "x0": 2.0, "rate": 1e-300}, isolated=isolated,
    )  # fmt: skip
    system = two(
        (
            *wires("Float64", "words"),
            Connection(from_component="metres", output="x", to_component="two", input="vector_in[2]"),
            Connection(from_component="one", output="vector_out[1]", to_component="two", input="vector_in[3]"),
            Connection(from_component="one", output="matrix_out[1,3]", to_component="two", input="matrix_in[2,1]"),
            Connection(from_component="one", output="narrow_out[2]", to_component="two", input="vector_in[1]"),
        ),
        isolated,
        (metres,),
        vector=[-8.0, 0.0, 0.0],
    )
    with pytest.raises(InputError, match=r"two\.matrix_in\[2,1\]: is connected to one\.matrix_out\[1,3\]"):
        simulate(system, tmp_path / "no", overrides={"two.matrix_in": [9.0, 9.0, 9.0, 9.0, 9.0, -9.0]})
    free = {"1,1": 9.0, "1,2": 9.0, "1,3": 9.0, "2,2": 9.0, "2,3": -9.0}
    simulate(system, tmp_path / "out", overrides={f"two.matrix_in[{index}]": value for index, value in free.items()})
    signals = read_signals(tmp_path / "out")

    vector = signals["two.vector_out"]  # in mm; x grows by 1 m/s in its steps of two ticks, and is held between
    assert vector[:, [0, 2]].tolist() == [[-0.25, -8.0]] * ROWS
    assert_allclose(vector[:, 1], [2020.0, 2020.0, 2040.0, 2040.0, 2060.0, 2060.0], rtol=1e-15)
    assert signals["two.matrix_out"].tolist() == [[9.0, 9.0, 9.0, 3.0, 9.0, -9.0]] * ROWS
    assert signals["two.words_out"].tolist() == [["", "zwei Worte"]] * ROWS


def test_checkpoint_continues_bitwise_with_partly_set_arrays(two, reference_fmu, tmp_path):
    """What an array's other elements are is part of the state: they are sent along with the one that is fed."""
    ball = Component(name="ball", source=reference_fmu("ball", "3.0"), period=STEP, kind="continuous", isolated=True)
    slow = Component(
        name="slow", source=reference_fmu("integrator", "3.0"), period=40 * STEP, kind="sampled",
        parameters={"u": 1.0, "x0": 3.0}, isolated=False,
    )  # fmt: skip
    fed = Connection(from_component="ball", output="h", to_component="two", input="vector_in[2]", delay=1)
    seldom = Connection(from_component="slow", output="x", to_component="two", input="vector_in[3]")
    system = replace(two((fed, seldom, *wires("words")), more=(ball, slow)), stop_time=100 * STEP)
    simulate(system, tmp_path / "whole")
    simulate(system, tmp_path / "first", stop_time=0.6, checkpoints=CheckpointSchedule(times=["0.5"]))
    at = Restart(checkpoint=read_checkpoint(tmp_path / "first/checkpoints/t=0.5.ckpt"))
    simulate(system, tmp_path / "rest", stop_time=1.0, restart=at)

    whole, rest = (read_signals(tmp_path / name) for name in ("whole", "rest"))
    assert rest.time[0] == 0.5
    assert_array_equal(rest["ball.h"], whole["ball.h"][-len(rest.time) :])
    assert_array_equal(rest["two.vector_out"], whole["two.vector_out"][-len(rest.time) :])
    assert rest["two.vector_out"][0].tolist() == [1.5, 1000.0 * rest["ball.h"][0], 1000.0 * rest["slow.x"][0]]  # mm
    assert rest["two.words_out"][-1].tolist() == ["", "zwei Worte"]


def test_integers_of_different_widths_can_be_connected(two, tmp_path):
    def crossing(source, target):
        return (Connection(from_component="one", output=f"{source}_out", to_component="two", input=f"{target}_in"),)

    pairs = [("Int8", "UInt64", 100), ("UInt64", "Int8", 100), ("Int64", "UInt16", 65535), ("UInt32", "Int32", 7)]
    for number, (source, target, value) in enumerate(pairs):
        simulate(two(crossing(source, target), **{source: value}), tmp_path / f"out{number}")
        signals = read_signals(tmp_path / f"out{number}")
        assert signals[f"two.{target}_out"].tolist() == [value] * ROWS


def test_transformation_of_a_wide_integer_is_exact(two, tmp_path):
    tripled = Connection(
        from_component="one", output="Int64_out", to_component="two", input="Int64_in", factor=-3.0, offset=1.0
    )
    simulate(two((tripled,), Int64=2**60 + 1), tmp_path / "out")

    assert read_signals(tmp_path / "out")["two.Int64_out"].tolist() == [-3 * (2**60 + 1) + 1] * ROWS
    with pytest.raises((InputError, RunError), match=r"-3 \* 3074457345618258604 \+ 1 does not fit into 64 bits"):
        simulate(two((tripled,), Int64=2**63 // 3 + 2), tmp_path / "none")


@pytest.mark.parametrize(
    ("source", "target", "value", "message", "isolated"),
    [
        ("Int16", "Int8", 300, "two: cannot set Int8_in: 300 does not fit into Int8", True),
        ("Int8", "UInt64", -1, "two.UInt64_in: -1 is outside [0, 18446744073709551615], the range of its type", True),
        ("UInt64", "Int64", 2**63, "two.Int64_in: 9223372036854775808 is outside [-9223372036854775808, ", False),
        ("UInt32", "Int32", 2**31, "two.Int32_in: 2147483648 is outside [-2147483648, 2147483647]", False),
        ("Float64", "Float32", 1e39, "two: cannot set Float32_in: 1e+39 does not fit into Float32", False),
    ],
)
def test_number_out_of_range_is_refused(two, tmp_path, source, target, value, message, isolated):
    wire = Connection(from_component="one", output=f"{source}_out", to_component="two", input=f"{target}_in", delay=0)
    with pytest.raises((InputError, RunError)) as caught:
        simulate(two((wire,), isolated, **{source: value}), tmp_path / "out")

    assert str(caught.value).startswith(message)


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"one.Int8_in": "128"}, "one.Int8_in: '128' is not of its type Int8"),
        ({"one.UInt64_in": "-1"}, "one.UInt64_in: '-1' is not of its type UInt64"),
        ({"one.Enumeration_in": "medium"}, "one.Enumeration_in: 'medium' is no item of its Enumeration; there are off"),
        ({"one.matrix_in": [1.0, 2.0]}, "one.matrix_in: got 2 values for matrix_in[1,1]"),
        ({"one.columns": 4}, "one.columns: is the FMU's structuralParameter; only parameters and inputs can be set"),
    ],
)
def test_bad_value_is_refused(two, tmp_path, values, message):
    with pytest.raises(InputError) as caught:
        simulate(two(wires("Float64")), tmp_path / "out", overrides=values)

    assert str(caught.value).startswith(message)
    assert not (tmp_path / "out").exists()


def test_enumeration_item_is_set_by_name(two, tmp_path):
    simulate(two(wires("Enumeration"), Enumeration="coarse"), tmp_path / "out")

    assert read_signals(tmp_path / "out")["two.Enumeration_out"].tolist() == [3] * ROWS


def test_text_too_long_for_an_isolated_fmu_is_refused(two, tmp_path):
    long = "ü" * 2049  # bytes: two a letter
    simulate(two(wires("String"), False, String=long), tmp_path / "inside")
    assert read_signals(tmp_path / "inside")["two.String_out"][-1] == long
    with pytest.raises(InputError, match="one: fmi3GetString returned fmi3Error at 0 s: a text of 4098 bytes; at most"):
        simulate(two(wires("String"), True, String=long), tmp_path / "out")


def test_binary_values_and_clocks_are_refused(reference, tmp_path):
    binary = '<Binary name="blob" valueReference="900" causality="input"><Start value="00"/></Binary>'
    path = reference.build("integrator", "3.0", tmp_path / "binary", more=binary)
    part = Component(name="part", source=path, period=STEP, kind="sampled", parameters={"u": 0.0})
    system = System(name="s", tick=STEP, stop_time=STEP, components=(part,))
    simulate(system, tmp_path / "out")  # not used: it keeps its start value
    with pytest.raises(InputError, match=r"^part\.blob: values of type Binary cannot be set; remove it$"):
        simulate(system, tmp_path / "none", overrides={"part.blob": "00"})

    clock = '<Clock name="tick" valueReference="901" causality="input" intervalVariability="triggered"/>'
    path = reference.build("integrator", "3.0", tmp_path / "clock", more=clock)
    with pytest.raises(InputError, match=r"has clocks \(tick\), which the master cannot drive; use one without$"):
        read_description(replace(part, source=path))


def test_description_of_fmi_3_lists_array_elements(reference_fmu):
    description = read_description(
        Component(name="x", source=reference_fmu("feedthrough", "3.0"), period=STEP, kind="sampled")
    )
    matrix = [v for name, v in description.variables.items() if name.startswith("matrix_in")]

    assert description.version == "3.0"
    assert [v.name for v in matrix][:4] == ["matrix_in[1,1]", "matrix_in[1,2]", "matrix_in[1,3]", "matrix_in[2,1]"]
    assert [v.element for v in matrix] == list(range(6))
    assert {v.array for v in matrix} == {14}
    assert description.variables["vector_out[3]"].unit.factor == 1e-3
    assert description.variables["Enumeration_in"].items == {"off": 0, "coarse": 3, "fine": 7}
    assert_array_equal([v.reference for v in description.variables.values()], range(len(description.variables)))


def test_library_for_another_platform_is_refused_with_the_names_of_fmi_3(reference_fmu, tmp_path):
    with zipfile.ZipFile(reference_fmu("stair", "3.0")) as good, zipfile.ZipFile(tmp_path / "x.fmu", "w") as bad:
        for name in good.namelist():
            bad.writestr(name.replace("x86_64-linux", "aarch64-darwin"), good.read(name))
    with pytest.raises(InputError, match="has no binary for x86_64-linux; it has aarch64-darwin"):
        read_description(Component(name="x", source=tmp_path / "x.fmu", period=STEP, kind="sampled"))
