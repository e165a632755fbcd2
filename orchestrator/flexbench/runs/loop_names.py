"""Find the plant of flexsat and its controller among the components of a run."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from flexsat.description.built_in import CONFIGURATIONS
from flexsat.parameters import ConfigurationName
from flexsat.variants import VARIANT_PORT

_PLANT = re.compile(r"plant_([a-z][a-z0-9_]*?)(_flat)?")


@dataclass(frozen=True, slots=True, kw_only=True)
class LoopNames:
    """Which components of a run are the plant and its controller."""

    configuration: ConfigurationName
    plant: str
    controller: str | None  # None: no component is called controller
    flat: bool  # names of variables without structure: attitude_mrp_1


def plant_model(component: Mapping[str, Any]) -> re.Match[str] | None:
    """Return the match of a component's model if it is a plant of flexsat: [1] is the spacecraft's name.

    That of a built-in spacecraft, or a model called plant_<name> of a system that chooses the variant, as those of
    `flexsat build` do.
    """
    match = _PLANT.fullmatch(component.get("model", ""))
    known = match is not None and (match[1] in CONFIGURATIONS or VARIANT_PORT in component.get("parameters", {}))
    return match if known else None


def loop_names(record: Mapping[str, Any]) -> LoopNames | None:
    """Return plant and controller of a run, None if it has no plant of flexsat, or several."""
    components = record.get("component", [])
    found = [(c["name"], match) for c in components if (match := plant_model(c))]
    if len(found) != 1:
        return None
    ((plant, match),) = found
    controllers = [c["name"] for c in components if c["name"].rpartition("/")[2] == "controller"]
    controller = controllers[0] if len(controllers) == 1 else None
    return LoopNames(configuration=match[1], plant=plant, controller=controller, flat=match[2] is not None)
