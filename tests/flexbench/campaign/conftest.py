"""A campaign of short runs of one small FMU that can be made to crash and to hang, in the process of its run."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from flexbench.campaign.campaign import run_campaign
from flexbench.engine.pools import LocalPool
from fmus.wanderer.wanderer import wanderer
from lockstep import Component, System, write_ssd

START = {"offset": 0.0, "number": 0, "flag": False}
HEAD = """
[campaign]
name = "toy"
seed = 5
stop_time = 0.02
{campaign}

[systems]
toy = "{system}"

[metric.largest]
of = "a.y"
take = "max"

[metric.spread]
of = "a.y"
take = "rms"
window = [0.005, 0.02]
"""


@pytest.fixture(scope="session")
def toy_system(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a system file of one FMU, not isolated."""
    folder = tmp_path_factory.mktemp("toy")
    part = Component(
        name="a",
        source=wanderer(folder, "moody", "CRASHES"),
        period=1_000_000,
        kind="sampled",
        isolated=False,
        parameters=START,
    )
    write_ssd(System(name="toy", tick=1_000_000, stop_time=10**8, components=(part,), connections=()),
              folder / "toy.ssd")  # fmt: skip
    return folder / "toy.ssd"


@pytest.fixture
def campaign_file(toy_system: Path, tmp_path: Path) -> Callable[..., Path]:
    """Return a function that writes a campaign file: keys of [campaign], and the tables behind it."""

    def write(campaign: str, tables: str = "", name: str = "toy.toml") -> Path:
        path = tmp_path / name
        path.write_text(HEAD.format(campaign=campaign, system=toy_system) + tables, encoding="utf-8")
        return path

    return write


@pytest.fixture
def fly() -> Callable[..., object]:
    """Return a function that runs a campaign with so many processes and returns what came of it."""

    def run(path: Path, folder: Path, size: int = 1, **more: object) -> object:
        return run_campaign(path, folder, lambda settings: LocalPool(settings, size), lambda _: None, **more)

    return run
