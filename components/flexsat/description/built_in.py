"""The spacecraft that come with flexsat, read from the files in paper/: the two layouts of the paper."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path

from ..controller_weights import DEFAULT_DESIGN, ConfigurationName, ControllerDesign
from ..parameters import CONTROLLER_DESIGNS
from .configuration import Configuration
from .spacecraft_file import SpacecraftFile, read_spacecraft

FOLDER = Path(__file__).with_name("paper")
CONFIGURATIONS: tuple[ConfigurationName, ...] = tuple(sorted(path.stem for path in FOLDER.glob("*.toml")))


@lru_cache(maxsize=len(CONFIGURATIONS))
def built_in(name: ConfigurationName) -> SpacecraftFile:
    """Return a built-in spacecraft; raise ValueError for any other name."""
    if name not in CONFIGURATIONS:
        raise ValueError(f"configuration {name!r}: no such configuration; there are {', '.join(CONFIGURATIONS)}")
    return read_spacecraft(FOLDER / f"{name}.toml")


def configuration(name: ConfigurationName, controller_design: ControllerDesign = DEFAULT_DESIGN) -> Configuration:
    """Return a built-in configuration with one of its two controller designs; raise ValueError for any other."""
    if controller_design not in CONTROLLER_DESIGNS and name in CONFIGURATIONS:
        known = ", ".join(CONTROLLER_DESIGNS)
        raise ValueError(f"controller.design {controller_design!r}: no such design; there are {known}")
    return built_in(name).configurations[controller_design]
