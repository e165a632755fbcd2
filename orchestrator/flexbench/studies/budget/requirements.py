"""Requirements on the pointing of a run, from a TOML file, and whether the run meets them.

The file is a list of tables:

    [[requirement]]
    name = "exposure stability"  # shown in the table
    index = "RPE"                # APE, MPE, RPE, PDE or PRE
    axis = "line_of_sight"       # x, y, z, line_of_sight (about x and y) or angle
    limit = 0.2                  # not to be exceeded
    unit = "arcsec"              # rad, mrad, urad, nrad, deg, arcmin, arcsec or mas
    level = 0.9973               # optional: share of the times or windows
    window = 10.0                # optional [s]: not for APE
    separation = 60.0            # optional [s]: PDE alone
    observation = 50.0           # optional [s]: PRE alone
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, get_args

from lockstep import InputError
from lockstep.data_text import parse_toml
from lockstep.errors import suggestion
from lockstep.system.unit_table import UNITS

from .evaluate import AXES, INDICES, AxisName, ErrorHistory, IndexName, IndexWindows, index_values, sizes
from .indices import at_level

ANGLES = ("rad", "mrad", "urad", "nrad", "deg", "arcmin", "arcsec", "mas")  # units
LEVEL = 0.9973
Time = Literal["window", "separation", "observation"]
# times that an index refers to: others in its table would have no effect, and are refused
TIMES: Mapping[IndexName, tuple[Time, ...]] = {
    "APE": (),
    "MPE": ("window",),
    "RPE": ("window",),
    "PDE": ("window", "separation"),
    "PRE": ("window", "observation"),
}
NEEDED = ("name", "index", "axis", "limit", "unit")
KEYS = (*NEEDED, "level", *get_args(Time))


@dataclass(frozen=True, slots=True, kw_only=True)
class PointingRequirement:
    """One line of the file."""

    name: str
    index: IndexName
    axis: AxisName
    limit: float  # in `unit`
    unit: str
    level: float
    windows: IndexWindows


@dataclass(frozen=True, slots=True, kw_only=True)
class Assessment:
    """The value that a run reaches for a requirement."""

    requirement: PointingRequirement
    value: float  # in the requirement's unit
    count: int  # of values it was taken from

    @property
    def met(self) -> bool:
        """Whether the limit is not exceeded."""
        return self.value <= self.requirement.limit

    @property
    def margin(self) -> float:
        """What is left of the limit, as a share of it."""
        return 1.0 - self.value / self.requirement.limit


def read_requirements(path: Path) -> list[PointingRequirement]:
    """Read a requirements file.

    Raises
    ------
    InputError
        If it cannot be read, is no TOML, or a requirement has a wrong key or value: named with the remedy.
    """
    try:
        content = parse_toml(path.read_bytes(), str(path))
    except OSError as error:
        raise InputError(f"{path}: {error.strerror}; give a TOML file of [[requirement]] tables") from None
    for key in content:
        if key != "requirement":
            raise InputError(f"{path}: {key}: no such key; write [[requirement]] tables")
    tables = content.get("requirement", [])
    if not isinstance(tables, list) or not tables:
        raise InputError(f"{path}: requirement: must be one or more [[requirement]] tables")
    return [_requirement(table, f"{path}: requirement {number}") for number, table in enumerate(tables, start=1)]


def _requirement(table: Any, location: str) -> PointingRequirement:
    if not isinstance(table, dict):
        raise InputError(f"{location}: must be a table, got {table!r}; write [[requirement]] before its keys")
    for key in table:
        if key not in KEYS:
            raise InputError(f"{location}: {key}: no such key; there are {', '.join(KEYS)}{suggestion(key, KEYS)}")
    for key in NEEDED:
        if key not in table:
            raise InputError(f"{location}: {key}: missing; every requirement needs {', '.join(NEEDED)}")
    name = table["name"]
    if not isinstance(name, str) or not name:
        raise InputError(f"{location}: name = {name!r}: must be a text")
    index = _one_of(table, "index", INDICES, location)
    axis = _one_of(table, "axis", tuple(AXES), location)
    unit = _one_of(table, "unit", ANGLES, location)
    limit, level = _number(table, "limit", location), _number(table, "level", location, LEVEL)
    if not limit > 0.0:
        raise InputError(f"{location}: limit = {limit!r}: must be > 0")
    if not 0.0 < level < 1.0:
        raise InputError(f"{location}: level = {level!r}: must be between 0 and 1, for example {LEVEL}")
    checked: IndexName = next(known for known in INDICES if known == index)
    times: dict[str, float] = {}
    for key in get_args(Time):
        if key not in table:
            continue
        if key not in TIMES[checked]:
            raise InputError(f"{location}: {key} = {table[key]!r}: {index} has none; leave it out")
        times[key] = _number(table, key, location)
    try:
        windows = IndexWindows(**_consistent(times))
    except InputError as error:
        raise InputError(f"{location}: {error}") from None
    checked_axis: AxisName = next(known for known in AXES if known == axis)
    return PointingRequirement(
        name=name, index=checked, axis=checked_axis, limit=limit, unit=unit, level=level, windows=windows
    )


def _consistent(times: Mapping[str, float]) -> dict[str, float]:
    """Return the times, with an observation that holds the window where none was given."""
    if "observation" in times or "window" not in times:
        return dict(times)
    return {**times, "observation": max(times["window"], IndexWindows().observation)}


def _one_of(table: Mapping[str, Any], key: str, known: Sequence[str], location: str) -> str:
    value = table[key]
    if not isinstance(value, str) or value not in known:
        hint = suggestion(value, known) if isinstance(value, str) else ""
        raise InputError(f"{location}: {key} = {value!r}: must be one of {', '.join(known)}{hint}")
    return value


def _number(table: Mapping[str, Any], key: str, location: str, default: float | None = None) -> float:
    value = table.get(key, default)
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise InputError(f"{location}: {key} = {value!r}: must be a number")
    return float(value)


def judge(history: ErrorHistory, requirement: PointingRequirement) -> Assessment:
    """Assess a run's error against one requirement.

    Raises
    ------
    InputError
        If the run is too short for the index, or a window no whole number of samples.
    """
    values = index_values(history, requirement.index, requirement.windows)
    if not len(values):
        duration = len(history.error) * history.interval
        raise InputError(
            f"requirement {requirement.name!r}: {requirement.index} needs longer than the {duration:g} s that are"
            " judged; simulate longer, or shorten its window, separation or observation"
        )
    size = sizes(values, requirement.axis)
    return Assessment(
        requirement=requirement,
        value=at_level(size, requirement.level) / UNITS[requirement.unit].factor,
        count=len(size),
    )
