"""The tick in C and that in Python record the same bytes: all types, versions of FMI, rates, delays and faults."""

import pytest

from lockstep import Component, Connection, System, read_signals, simulate
from lockstep.faults.read import read_scenario
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


def test_all_types_rates_delays_and_faults(everything, tmp_path):
    (tmp_path / "faults.toml").write_text(FAULTS)
    files = {}
    for tick in ("python", "c"):
        simulate(
            everything,
            tmp_path / tick,
            tick=tick,
            record=["all", "inputs:*"],
            faults=[read_scenario(tmp_path / "faults.toml")],
        )
        files[tick] = [(tmp_path / tick / name).read_bytes() for name in ("signals.parquet", "events.jsonl")]
    assert files["python"] == files["c"]
    found = read_signals(tmp_path / "c")
    for name in ("wave.x", "one.Real_out", "three.matrix_out[1,2]", "two.Integer_out", "three.Int64_out"):
        assert len(set(found[name].tolist())) > 20, name
