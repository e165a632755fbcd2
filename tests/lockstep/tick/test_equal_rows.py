"""The tick in C and that in Python record the same bytes: all types, versions of FMI, rates, delays and faults."""

import numpy as np
import pytest

from lockstep import Component, Connection, System, read_signals, simulate
from lockstep.adapter.component import replace_component
from lockstep.adapter.read import read_adapter
from lockstep.faults.read import read_scenario
from lockstep.shadow.component import with_shadow
from lockstep.system.transformation import Table

MS = 1_000_000
FAULTS = """
[[fault]]
kind = "bias"
connection = "wave.x -> three.vector_in[1]"
value = 0.3
from = 0.02
to = 0.05

[[fault]]
kind = "scale"
connection = "wave.x -> three.vector_in[1]"
factor = 3.0
from = 0.04
to = 0.06

[[fault]]
kind = "stuck"
connection = "three.vector_out[*] -> two.*"
from = 0.03
to = 0.05

[[fault]]
kind = "stuck"
connection = "steps.counter -> three.Int32_in"
value = -7
from = 0.01
to = 0.02

[[fault]]
kind = "delay"
connection = "steps.counter -> three.Int32_in"
ticks = 7
from = 0.03
to = 0.07

[[fault]]
kind = "delay"
connection = "two.Real_out -> one.Real_in"
ticks = 9
from = 0.0
to = 0.06

[[fault]]
kind = "noise"
connection = "two.Real_out -> one.Real_in"
deviation = 0.125
seed = 3
from = 0.05
"""
ADAPTER = """
ignore = ["*_out"]

[[input]]
port = "Real_in"
variable = "Real_in"
scale = -2.5

[[input]]
port = "Integer_in"
variable = "Integer_in"

[[input]]
port = "Boolean_in"
variable = "Boolean_in"

[[output]]
port = "Real_out"
variable = "Real_out"
offset = 0.1
scale = 0.3

[[output]]
port = "Integer_out"
variable = "Integer_out"

[constants]
String_in = "90"
Enumeration_in = "coarse"
"""
SHADOW_ADAPTER = """
step = 0.004
ignore = ["*_out"]

[[input]]
port = "Real_in"
variable = "Real_in"

[[output]]
port = "Real_out"
variable = "Real_out"
sign = -1

[constants]
Integer_in = 3
Boolean_in = true
String_in = "90"
Enumeration_in = "coarse"
"""


@pytest.fixture
def everything(reference_fmu):
    """Return a system of all versions of FMI and all types, with rates of 1:2:3, delays, conversions and a table."""

    def part(name, model, version, period, kind="sampled", **parameters):
        fmu = reference_fmu(model, version)
        return Component(name=name, source=fmu, period=period * MS, kind=kind, isolated=False, parameters=parameters)

    def wire(start, end, **more):
        (a, output), (b, entry) = start.split("."), end.split(".")
        return Connection(from_component=a, output=output, to_component=b, input=entry, **more)

    odd = Table(kind="Integer", entries=tuple((k, k % 3 % 2) for k in range(200)))
    return System(
        name="everything",
        tick=MS,
        stop_time=100 * MS,
        components=(
            part("wave", "integrator", "2.0", 1, "continuous", x0=0.7, rate=1.3),
            part("steps", "stair", "3.0", 2, last=1000),
            part("three", "feedthrough", "3.0", 1, String_in="90°", Float64_in=0.1),
            part("two", "feedthrough", "2.0", 3),
            part("one", "feedthrough", "1.0", 2),
        ),
        connections=(
            *(wire("wave.x", f"three.vector_in[{k}]", delay=k) for k in (1, 2, 3)),
            wire("wave.x", "three.narrow_in[2]", delay=2),
            wire("wave.x", "three.matrix_in[1,2]", delay=4, factor=-2.5, offset=0.1),
            wire("steps.counter", "three.Int32_in"),
            wire("steps.counter", "three.Int64_in", delay=3),
            wire("steps.counter", "three.UInt8_in", delay=2),
            wire("three.vector_out[2]", "two.Real_in"),
            wire("three.Int32_out", "two.Integer_in", delay=5),
            wire("three.String_out", "two.String_in"),
            wire("three.Boolean_out", "two.Boolean_in"),
            wire("steps.counter", "three.flags_in[2]", table=odd),
            wire("steps.counter", "three.Boolean_in", table=odd, delay=1),
            wire("three.flags_out[2]", "one.Boolean_in", delay=1),
            wire("two.Real_out", "one.Real_in", factor=1.7, offset=-0.3),
            wire("two.Integer_out", "one.Integer_in"),
            wire("one.Real_out", "wave.u", delay=1, factor=-0.5, convert_units=False),
        ),
    )


def recorded_by_both(system, folder, faults=FAULTS):
    """Return what the tick in Python and that in C record, bytes of the files, and the signals."""
    (folder / "faults.toml").write_text(faults)
    files = {}
    for tick in ("python", "c"):
        simulate(
            system,
            folder / tick,
            tick=tick,
            record=["all", "inputs:*"],
            faults=[read_scenario(folder / "faults.toml")],
        )
        files[tick] = [(folder / tick / name).read_bytes() for name in ("signals.parquet", "events.jsonl")]
    return files, read_signals(folder / "c")


def test_all_types_rates_delays_and_faults(everything, tmp_path):
    files, found = recorded_by_both(everything, tmp_path)
    assert files["python"] == files["c"]
    for name in ("wave.x", "one.Real_out", "three.matrix_out[1,2]", "two.Integer_out", "three.Int64_out"):
        assert len(set(found[name].tolist())) > 20, name


def test_an_adapter_of_another_version_and_a_shadow_that_takes_over(everything, reference_fmu, tmp_path):
    """Both are slaves of Python around FMUs, which C calls back for: one with conversions, one at its own rate."""
    for name, text in (("adapter.toml", ADAPTER), ("shadow.toml", SHADOW_ADAPTER)):
        (tmp_path / name).write_text(text)
    system = replace_component(
        everything, "two", reference_fmu("feedthrough", "1.0"), read_adapter(tmp_path / "adapter.toml")
    )
    system = with_shadow(
        system,
        "one",
        reference_fmu("feedthrough", "2.0"),
        read_adapter(tmp_path / "shadow.toml"),
        switchover=40 * MS,
        blend=20 * MS,
    )
    files, found = recorded_by_both(system, tmp_path)
    assert files["python"] == files["c"]
    real = found["one.Real_out"]
    shadow, original = found["one.shadow.Real_out"], found["one.original.Real_out"]
    assert len(set(real.tolist())) > 20
    assert np.array_equal(real[:40], original[:40])  # before the switchover the original acts
    assert np.array_equal(real[61:], shadow[61:])
    assert not np.array_equal(real[61:], original[61:])
