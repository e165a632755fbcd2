"""The results of a sweep over wheel speed as rows of text and as a sentence."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from flexsat.variants import CORRECTED, chosen_by

HEADER = ("speed [rpm]", "mode", "allowed for wheels", "linear deformation there [µm]")


def flagged_rows(content: Mapping[str, Any]) -> list[tuple[str, ...]]:
    """Return the crossings inside an allowed band, as texts."""
    return [
        (
            f"{crossing['speed_rpm']:.1f}",
            str(crossing["mode"]),
            ", ".join(map(str, crossing["inside_band_of_wheels"])),
            f"{1e6 * crossing['linear_deformation_of_those_m']:.3g}",
        )
        for crossing in content["crossings"]
        if crossing["inside_band_of_wheels"]
    ]


def summary(content: Mapping[str, Any]) -> str:
    """Return the sweep in a sentence."""
    speeds, flagged = content["speed_rpm"], flagged_rows(content)
    variant = chosen_by(content.get)
    which = "" if variant == CORRECTED else f", {variant.label}"
    return (
        f"{content['configuration']}{which}, seed {content['seed']}: {len(speeds)} runs of {content['stop']:g} s"
        f" from {speeds[0]:.0f} to {speeds[-1]:.0f} rpm, all wheels at one speed, loop open. The first harmonic meets"
        f" {len(content['crossings'])} modes, {len(flagged)} of them inside an allowed band."
    )
