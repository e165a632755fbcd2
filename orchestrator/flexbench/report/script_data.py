"""Prepare the data of the page's script: runs, histories, motion, geometry; large data are elements with an id."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from flexsat.variants import CORRECTED

from .motion_data import geometry_data
from .results import Result
from .run_data import RunData
from .text_blocks import scenario_of

FIRST_PANELS = ("pointing error", "deformation", "rate error", "torque, sum over wheels")
MOST_FIRST_PANELS = 4
OF_GROUP = ("unit", "description")  # the same for all lines of a group
MOST_SHOWN = 4  # runs in a plot until the reader asks for more


def script_data(title: str, runs: Sequence[RunData]) -> tuple[dict[str, Any], list[str]]:
    """Return the contents for the script, and the texts of the data elements that they refer to as d0, d1, ..."""
    data: list[str] = []

    def element(text: str) -> str:
        data.append(text)
        return f"d{len(data) - 1}"

    described: list[dict[str, Any]] = []
    about: dict[str, dict[str, Any]] = {}  # by group
    geometries: dict[str, dict[str, Any]] = {}  # by configuration
    shown = _shown_first([run.result for run in runs])
    for run in runs:
        parts = []
        full_rate = run.for_script["full_rate"]
        for part in run.for_script["parts"]:
            histories = [history | ({"id": element(text)} if text else {}) for history, text in
                         zip(part["histories"], part["data"], strict=True)]  # fmt: skip
            if part["time"]["stride"] > 1:
                for history in histories:
                    if history["name"] in full_rate["data"]:
                        history["full"] = element(full_rate["data"][history["name"]])
            about |= {
                one["group"]: {key: one[key] for key in OF_GROUP} for one in histories if one["group"] not in about
            }
            slim = [{key: value for key, value in one.items() if key not in (*OF_GROUP, "name")} for one in histories]
            parts.append({"time": part["time"], "histories": slim})
        motion = run.for_script["motion"]
        if motion is not None and run.result.run is not None:
            geometry = geometry_data(run.result.run)
            if geometries.setdefault(motion["configuration"], geometry) != geometry:
                motion = None  # another spacecraft of the same name
        if motion is not None:
            motion = motion | {key: element(motion[key]) for key in ("modal", "torque", "error") if motion.get(key)}
        described.append(
            {
                "name": run.for_script["name"],
                "marks": run.for_script["marks"],
                "parts": parts,
                "windows": full_rate["windows"],
                "motion": motion,
                "shown": run.result.name in shown,
            }
        )
    groups = list(
        dict.fromkeys(history["group"] for run in described for part in run["parts"] for history in part["histories"])
    )
    panels = list(dict.fromkeys([*(name for name in FIRST_PANELS if name in groups), *groups]))[:MOST_FIRST_PANELS]
    return {"title": title, "runs": described, "groups": about, "geometry": geometries, "panels": panels}, data


def _shown_first(results: Sequence[Result]) -> set[str]:
    """Return the runs whose lines show from the start: all of a few, else those of one scenario and variant."""
    if len(results) <= MOST_SHOWN:
        return {result.name for result in results}
    kinds = [(scenario_of(r), "" if r.run is None else r.run.variant.label) for r in results]
    wanted = ((scenario, CORRECTED.label) for scenario in ("slew", "fine_pointing"))
    preferred = next((kind for kind in wanted if kind in kinds), kinds[0])
    alike = [result.name for result, kind in zip(results, kinds, strict=True) if kind == preferred]
    return set(alike[:MOST_SHOWN])
