"""Compiled FMUs with states, and systems of them."""

import pytest

from fmus.echo_fmu import echo_fmu
from fmus.wanderer.triple import triple_of
from fmus.wanderer.wanderer import wanderer


@pytest.fixture(scope="session")
def fmus(tmp_path_factory):
    """Return a filter with noise, the same one that cannot save its state, and an echo of every type."""
    folder = tmp_path_factory.mktemp("fmus")
    return {"good": wanderer(folder, "good"), "mute": wanderer(folder, "mute", "MUTE"), "echo": echo_fmu(folder)}


@pytest.fixture(scope="session")
def triple(fmus):
    """Return three filters at rates of 3:2 in a loop with delays."""
    return triple_of(fmus["good"])
