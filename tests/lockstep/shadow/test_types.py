"""Values of every type of FMI 3.0, arrays and texts too, reach a shadow and act after the switchover."""

import shutil

import numpy as np
import pytest

from lockstep import Component, Connection, System, read_signals, simulate
from lockstep.fmi.model_description import read_description
from lockstep.shadow.component import with_isolation, with_shadow

pytestmark = pytest.mark.usefixtures("each_tick")

MS = 1_000_000
GIVEN = {"String": "90°", "Boolean": True}


@pytest.mark.skipif(shutil.which("gcc") is None, reason="the FMU is compiled with gcc")
@pytest.mark.parametrize("isolated", [False, True], ids=["shared", "isolated"])
def test_a_shadow_of_all_types_changes_nothing_when_it_takes_over(reference_fmu, tmp_path, isolated):
    fmu = reference_fmu("feedthrough", "3.0")
    ports = read_description(Component(name="any", source=fmu, period=MS, kind="sampled")).variables.values()
    inputs = [port for port in ports if port.causality == "input"]
    outputs = [port for port in ports if port.causality == "output"]
    first = Component(
        name="first", source=fmu, period=MS, kind="sampled", isolated=False,
        parameters={port.name: GIVEN.get(port.type, 3) for port in inputs},
    )  # fmt: skip
    system = System(
        name="pair",
        tick=MS,
        stop_time=8 * MS,
        components=(first, Component(name="second", source=fmu, period=MS, kind="sampled", isolated=False)),
        connections=tuple(
            Connection(from_component="first", output=output.name, to_component="second", input=entry.name)
            for output, entry in zip(outputs, inputs, strict=True)
        ),
    )
    simulate(system, tmp_path / "alone")
    shadowed = with_isolation(with_shadow(system, "first", fmu, None, 4 * MS, 2 * MS), "first_shadow", isolated)
    simulate(shadowed, tmp_path / "shadowed")
    alone, run = read_signals(tmp_path / "alone"), read_signals(tmp_path / "shadowed")

    assert {port.type for port in outputs} >= {"Real", "Integer", "Boolean", "String", "Enumeration"}
    assert alone["second.String_out"].tolist() == ["90°"] * 9
    for name, values in alone.columns.items():
        np.testing.assert_array_equal(run[name], values, err_msg=name)
    for output in outputs:
        for kind in ("shadow", "original"):
            shown = run[f"first.{kind}.{output.name}"]
            np.testing.assert_array_equal(shown, alone[f"first.{output.name}"], err_msg=output.name)
        if output.scalar == "Real":
            assert not np.any(run[f"first.residual.{output.name}"])
