"""Find the plant of flexsat and its controller among the components of a run."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from flexsat.description.built_in import CONFIGURATIONS
from flexsat.parameters import ConfigurationName

_PLANT = re.compile(rf"plant_({'|'.join(CONFIGURATIONS)})(_flat)?")


@dataclass(frozen=True, slots=True, kw_only=True)
class LoopNames:
    """Which components of a run are the plant and its controller."""

    configuration: ConfigurationName
    plant: str
    controller: str | None  # None: no component is called controller
    flat: bool  # names of variables without structure: attitude_mrp_1


def loop_names(record: Mapping[str, Any]) -> LoopNames | None:
    """Return plant and controller of a run, None if it has no plant of flexsat, or several."""
    components = record.get("component", [])
    found = [(c["name"], match) for c in components if (match := _PLANT.fullmatch(c.get("model", "")))]
    if len(found) != 1:
        return None
    ((plant, match),) = found
    configuration = next(name for name in CONFIGURATIONS if name == match[1])
    controllers = [c["name"] for c in components if c["name"].rpartition("/")[2] == "controller"]
    controller = controllers[0] if len(controllers) == 1 else None
    return LoopNames(configuration=configuration, plant=plant, controller=controller, flat=match[2] is not None)
