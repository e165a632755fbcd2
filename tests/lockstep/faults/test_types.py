"""Faults on every type of FMI 3.0, and on elements of its arrays."""

import numpy as np
import pytest

from lockstep import Component, Connection, System, read_scenario, read_signals, simulate
from lockstep.fmi.model_description import read_description

pytestmark = pytest.mark.usefixtures("each_tick")

STEP = 10_000_000  # [ns]
FAULTED = {  # input: what the file says, and what the second FMU then puts out in place of what was sent
    "UInt8_in": ('kind = "scale"\nfactor = 3.0', 255),  # 600 does not fit
    "Int8_in": ('kind = "bias"\nvalue = -0.6', 99),
    "UInt32_in": ('kind = "bias"\nvalue = 1e10', 2**32 - 1),
    "Int64_in": ('kind = "stuck"\nvalue = -9007199254740993', -(2**53) - 1),  # no double is that number
    "Float32_in": ('kind = "scale"\nfactor = 0.5', 0.75),
    "String_in": ('kind = "stuck"\nvalue = "Störung"', "Störung"),
    "Enumeration_in": ('kind = "stuck"\nvalue = "{item}"', None),
    "matrix_in[2,1]": ('kind = "bias"\nvalue = 10.0', 14.0),
    "vector_in": ('kind = "bias"\nvalue = [1.0, 2.0, 3.0]', [2.0, 4.0, 6.0]),
    "flags_in[1]": ('kind = "dropout"', False),
}
SENT = {"UInt8_in": 200, "Int8_in": 100, "UInt32_in": 7, "Int64_in": 5, "Float32_in": 1.5, "String_in": "gut",
        "flags_in[1]": True} | {f"vector_in[{k}]": float(k) for k in (1, 2, 3)} | {
        f"matrix_in[{i},{j}]": 3.0 * (i - 1) + j for i in (1, 2) for j in (1, 2, 3)}  # fmt: skip


@pytest.mark.parametrize("isolated", [False, True], ids=["inside", "isolated"])
def test_every_type_has_its_faults(reference_fmu, scenario, tmp_path, isolated):
    source = reference_fmu("feedthrough", "3.0")
    one = Component(name="one", source=source, period=STEP, kind="sampled", isolated=isolated, parameters=dict(SENT))
    variables = read_description(one).variables
    inputs = [v for v in variables.values() if v.causality == "input" and v.scalar is not None]
    items = variables["Enumeration_in"].items
    item = next(name for name, number in items.items() if str(number) != variables["Enumeration_in"].start)
    zero = {"Boolean": False, "String": "", "Real": 0.0}
    for v in inputs:
        one.parameters.setdefault(v.name, int(v.start) if v.items else zero.get(v.type, 0))
    two = Component(name="two", source=source, period=STEP, kind="sampled", isolated=isolated)
    connections = tuple(
        Connection(from_component="one", output=v.name.replace("_in", "_out"), to_component="two", input=v.name)
        for v in inputs
    )
    system = System(name="two", tick=STEP, stop_time=4 * STEP, components=(one, two), connections=connections)
    text = "\n".join(
        f'[[fault]]\nconnection = "two.{name}"\n{what.format(item=item)}\nfrom = 0.01\nto = 0.03\n'
        for name, (what, _) in FAULTED.items()
    )
    simulate(system, tmp_path / "out", faults=[read_scenario(scenario(text))])
    signals = read_signals(tmp_path / "out")

    for name, (_, expected) in FAULTED.items():
        output = name.replace("_in", "_out")
        before, during = signals[f"one.{output}"], signals[f"two.{output}"]
        expected = items[item] if name == "Enumeration_in" else expected
        assert during[1:3].tolist() == [expected] * 2, name
        assert during[[0, 3]].tolist() == before[[0, 3]].tolist(), name
        assert np.all(before[1] != during[1]), name
    untouched = signals["two.matrix_out"][1]
    assert untouched.tolist() == [1.0, 2.0, 3.0, 14.0, 5.0, 6.0]
