"""Three wanderers at rates of 3:2 in a loop with delays."""

from functools import partial
from pathlib import Path

from lockstep import Component, Connection, System

MS = 1_000_000  # [ns]


def triple_of(fmu: Path) -> System:
    """Return `a` every 2 ms and `b` every 3 ms, sampled, and `p` every 2 ms, continuous, in a loop with delays."""
    part = partial(Component, source=fmu, isolated=False)
    wire = partial(Connection, from_component="a", to_component="b")
    return System(
        name="triple",
        tick=MS,
        stop_time=60 * MS,
        components=(
            part(name="a", period=2 * MS, kind="sampled", parameters={"seed": 5, "offset": 0.25, "flag": True}),
            part(name="b", period=3 * MS, offset=MS, kind="sampled", parameters={"seed": 6, "offset": -0.5}),
            part(name="p", period=2 * MS, kind="continuous",
                 parameters={"seed": 7, "offset": 0.125, "flag": False, "number": 0}),
        ),
        connections=(
            wire(output="y", input="u"),
            wire(output="odd", input="flag", delay=3),
            wire(output="steps", input="number"),
            Connection(from_component="b", output="y", to_component="p", input="u", delay=4),
            Connection(from_component="p", output="y", to_component="a", input="u", delay=1, factor=0.5),
            Connection(from_component="p", output="steps", to_component="a", input="number", delay=7),
        ),
    )  # fmt: skip
