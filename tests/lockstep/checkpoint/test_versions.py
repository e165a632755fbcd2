"""States of FMI 2.0 and 3.0, and values of every type on their way; FMI 1.0 has no states."""

from dataclasses import replace

import numpy as np
import pytest

from lockstep import Component, Connection, InputError, System, read_signals, simulate
from lockstep.checkpoint.file import read_checkpoint
from lockstep.checkpoint.restart import Restart
from lockstep.checkpoint.schedule import CheckpointSchedule
from lockstep.fmi.model_description import read_description

STEP = 10_000_000  # [ns]
SENT = {
    "Float32_in": 0.5,
    "Float64_in": 0.0,
    "Real_in": 0.0,
    "Integer_in": -7,
    "Int64_in": -(2**63),
    "UInt64_in": 2**64 - 1,
    "Boolean_in": True,
    "String_in": "Größe\n→ 1",
    "words_in[1]": "zwei Worte",
    "whole_in[2]": 2**53 + 1,
    "Enumeration_in": "coarse",
}
OTHERS = {"String": "", "Boolean": False}


def chain(reference_fmu, version):
    """Return a moving integrator, and two feedthroughs of all types with a delay between them."""
    fmu = reference_fmu("feedthrough", version)
    ports = read_description(Component(name="one", source=fmu, period=STEP, kind="sampled")).variables.values()
    values = {v.name: SENT.get(v.name, OTHERS.get(v.scalar, 0)) for v in ports if v.causality == "input"}
    real = "Real_in" if "Real_in" in values else "Float64_in"
    one = Component(name="one", source=fmu, period=STEP, kind="sampled", isolated=False, parameters=values)
    way = Connection(from_component="one", output="", to_component="two", input="", delay=5)
    wires = [replace(way, output=name.replace("_in", "_out"), input=name) for name in values]
    first = Connection(from_component="moving", output="x", to_component="one", input=real, delay=1)
    source = reference_fmu("integrator", version)
    moving = {"u": 2.0, "x0": 3.0, "rate": 0.5}
    return System(
        name="chain",
        tick=STEP,
        stop_time=30 * STEP,
        components=(
            Component(name="moving", source=source, period=STEP, kind="continuous", isolated=False, parameters=moving),
            replace(one, parameters={name: value for name, value in values.items() if name != real}),
            replace(one, name="two", parameters={}),
        ),
        connections=(first, *wires),
    )


@pytest.mark.parametrize("version", ["2.0", "3.0"])
@pytest.mark.parametrize("apart", [False, True])
def test_every_type_goes_on(reference_fmu, tmp_path, version, apart):
    system = chain(reference_fmu, version)
    simulate(system, tmp_path / "whole", checkpoints=CheckpointSchedule(times=["0.13"]))
    restart = Restart(checkpoint=read_checkpoint(tmp_path / "whole/checkpoints/t=0.13.ckpt"))
    for name in ("moving", "two"):
        system = system.with_isolation(name, apart)
    simulate(system, tmp_path / "branch", restart=restart)
    mine, full = read_signals(tmp_path / "branch"), read_signals(tmp_path / "whole")
    assert list(mine.columns) == list(full.columns)
    for name in mine.columns:
        np.testing.assert_array_equal(mine[name], full[name][13:], name)
    assert mine["two.String_out"][0] == SENT["String_in"]
    assert len(set(mine["moving.x"])) == 18  # from 0.13 to 0.3 s
    if version == "3.0":
        assert (mine["two.UInt64_out"][0], mine["two.whole_out[2]"][0]) == (2**64 - 1, 2**53 + 1)


def test_fmi_1_has_no_states(reference_fmu, tmp_path):
    with pytest.raises(InputError, match=r"moving, one, two: cannot save its state .* --checkpoint-without moving"):
        simulate(chain(reference_fmu, "1.0"), tmp_path / "no", checkpoints=CheckpointSchedule(times=["0.13"]))
