"""Define the paper's scenarios as parameters of plant, sensors and controller."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal

from flexsat.parameters import Slew
from flexsat.variants import CORRECTED, Variant
from lockstep.errors import InputError

ScenarioName = Literal["slew", "fine_pointing", "fine_pointing_open_loop"]
SCENARIOS: tuple[ScenarioName, ...] = ("slew", "fine_pointing", "fine_pointing_open_loop")
Value = float | int | bool
Parameters = dict[str, dict[str, Value | tuple[float, ...]]]  # component, then port


def scenario_parameters(
    scenario: ScenarioName, variant: Variant = CORRECTED, seed: int | None = None, slew: Slew | None = None
) -> Parameters:
    """Return what a scenario sets, by component and port.

    Parameters
    ----------
    scenario : slews are simulated without wheel jitter, as in the authors' code
    variant : chooses the matrices, and how a run begins
    seed : of plant and sensors; None keeps the seeds that the FMUs start with
    slew : commanded in the scenario `slew`; None for the paper's

    Raises
    ------
    InputError
        For an unknown scenario.
    """
    if scenario not in SCENARIOS:
        raise InputError(f"scenario {scenario!r}: no such scenario; there are {', '.join(SCENARIOS)}")
    command, slewing = slew or Slew(), scenario == "slew"
    parameters: Parameters = {
        "plant": {
            **variant.switch,
            "initial.random_wheel_phases": variant.random_wheel_phases,
            "initial.attitude_deviation": 0.0 if slewing else variant.attitude_deviation,
            "initial.mrp": (0.0 if slewing else 0.25 * variant.attitude_offset,) * 3,
        },
        "sensors": {**variant.switch, "star_tracker.fine": not slewing, "jitter.enabled": not slewing},
        "controller": {
            **variant.switch,
            "star_tracker.fine": not slewing,
            "jitter.feed_forward": not slewing,
            "reference.smoothed": variant.smoothed_slews,
            "open_loop": scenario == "fine_pointing_open_loop",
            "command.rotation": command.rotation if slewing else (0.0, 0.0, 0.0),
            "command.start_time": command.start_time,
        },
    }
    if seed is not None:
        parameters["plant"]["seed"] = parameters["sensors"]["seed"] = seed
    return parameters


def scalar_overrides(parameters: Mapping[str, Mapping[str, Value | tuple[float, ...]]]) -> dict[str, Value]:
    """Return values by `component.port` or `component.port[i]`, one scalar each, as a master takes them."""
    flat: dict[str, Value] = {}
    for component, ports in parameters.items():
        for port, value in ports.items():
            if isinstance(value, tuple):
                flat |= {f"{component}.{port}[{i}]": element for i, element in enumerate(value, start=1)}
            else:
                flat[f"{component}.{port}"] = value
    return flat
