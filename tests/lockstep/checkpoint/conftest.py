"""A compiled FMU with a state, a system of three at rates of 3:2 with delays, and its runs."""

from dataclasses import replace

import pytest

from fmus.wanderer.triple import triple_of
from fmus.wanderer.wanderer import wanderer
from lockstep import simulate, write_ssd
from lockstep.checkpoint.schedule import CheckpointSchedule


@pytest.fixture(scope="session")
def fmus(tmp_path_factory):
    """Return the FMU, the same one by another name, one that cannot save its state, and one that fails to."""
    folder = tmp_path_factory.mktemp("wanderers")
    made = {"good": (), "other": (), "mute": ("MUTE",), "complains": ("COMPLAINS",)}
    return {name: wanderer(folder, name, *defines) for name, defines in made.items()}


@pytest.fixture(scope="session")
def triple(fmus):
    """Return `a` every 2 ms and `b` every 3 ms, sampled, and `p` every 2 ms, continuous, in a loop with delays."""
    return triple_of(fmus["good"])


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
