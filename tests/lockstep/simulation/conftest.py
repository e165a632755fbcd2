"""Compiled FMUs with states, and systems of them."""

import pytest

from fmus.echo_fmu import echo_fmu
from fmus.wanderer.triple import triple_of
from fmus.wanderer.wanderer import wanderer
from lockstep import Component, System


@pytest.fixture(scope="session")
def fmus(tmp_path_factory):
    """Return a filter with noise, the same one that cannot save its state, and an echo of every type."""
    folder = tmp_path_factory.mktemp("fmus")
    return {"good": wanderer(folder, "good"), "mute": wanderer(folder, "mute", "MUTE"), "echo": echo_fmu(folder)}


@pytest.fixture(scope="session")
def echo_alone(fmus):
    """Return the echo alone, in this process."""
    part = Component(name="echo", source=fmus["echo"], period=1_000_000, isolated=False)
    return System(name="echo", tick=1_000_000, stop_time=10_000_000_000, components=(part,))


@pytest.fixture(scope="session")
def triple(fmus):
    """Return three filters at rates of 3:2 in a loop with delays."""
    return triple_of(fmus["good"])
