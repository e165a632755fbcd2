"""A compiled FMU with a state, a system of three at rates of 3:2 with delays, and its runs."""

from dataclasses import replace
from functools import partial

import pytest

from fmus.wanderer.wanderer import wanderer
from lockstep import Component, Connection, System, simulate, write_ssd
from lockstep.checkpoint.schedule import CheckpointSchedule

MS = 1_000_000  # [ns]


@pytest.fixture(scope="session")
def fmus(tmp_path_factory):
    """Return the FMU, the same one by another name, one that cannot save its state, and one that fails to."""
    folder = tmp_path_factory.mktemp("wanderers")
    made = {"good": (), "other": (), "mute": ("MUTE",), "complains": ("COMPLAINS",)}
    return {name: wanderer(folder, name, *defines) for name, defines in made.items()}


@pytest.fixture(scope="session")
def triple(fmus):
    """Return `a` every 2 ms and `b` every 3 ms, sampled, and `p` every 2 ms, continuous, in a loop with delays."""
    part = partial(Component, source=fmus["good"], isolated=False)
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


@pytest.fixture
def triple_ssd(triple, tmp_path):
    """Return it as a file."""
    write_ssd(triple, tmp_path / "triple.ssd")
    return tmp_path / "triple.ssd"


@pytest.fixture
def isolated(triple):
    """Return it with two of the three in processes of their own."""
    return replace(triple, components=tuple(replace(c, isolated=c.name != "b") for c in triple.components))


@pytest.fixture(scope="session")
def whole(triple, tmp_path_factory):
    """Return the results of a run with a checkpoint at each tick of one cycle."""
    folder = tmp_path_factory.mktemp("whole") / "whole"
    simulate(triple, folder, checkpoints=CheckpointSchedule(times=[f"0.0{tick}" for tick in range(20, 32)]))
    return folder
