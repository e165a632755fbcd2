"""The file that `flexsat budget` leaves in a results folder: budget.json, in SI."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

from lockstep import InputError

from ...runs.json_file import read_json, write_json
from ...runs.run_folder import Run
from .evaluate import INTERPRETATION, Budget, IndexWindows
from .requirements import Assessment, PointingRequirement

RESULT = "budget.json"
REQUIREMENT_KEYS = ("name", "index", "axis", "level", "limit", "unit")


@dataclass(frozen=True, slots=True, kw_only=True)
class StoredBudget:
    """What a later reader needs of the file to compute the same budget again."""

    windows: IndexWindows
    start: float  # s
    assessments: Sequence[Assessment]


def write_budget(
    budget: Budget, assessments: Sequence[Assessment], run: Run, folder: Path, requirements: Path | None
) -> Path:
    """Write budget.json to a folder; return its path.

    Parameters
    ----------
    budget, assessments : of the run
    run : that was evaluated
    folder : its own or another
    requirements : file that the assessments refer to
    """
    content = {
        "configuration": run.configuration,
        "seed": run.seed,
        "unit": "rad",
        "interpretation": INTERPRETATION,
        "start": budget.start,
        "duration": budget.duration,
        "windows": asdict(budget.windows),
        "indices": [
            {
                "index": entry.index,
                "axis": entry.axis,
                "values": entry.count,
                "rms": entry.rms,
                "levels": {str(level): value for level, value in entry.levels.items()},
                "largest_only": [level for level in budget.levels if not entry.sampled_enough(level)],
            }
            for entry in budget.entries
        ],
        "requirements_file": str(requirements) if requirements else None,
        "requirements": [
            {key: getattr(one.requirement, key) for key in REQUIREMENT_KEYS} | {"value": one.value, "met": one.met}
            for one in assessments
        ],
    }
    return write_json(folder / RESULT, content)


def read_budget(folder: Path) -> StoredBudget | None:
    """Return what `write_budget` left in a results folder, None if there is nothing.

    Raises
    ------
    InputError
        If the file is not one of `flexsat budget`.
    """
    path = folder / RESULT
    try:
        content = read_json(path)
        if content is None:
            return None
        assessments = [
            Assessment(
                requirement=PointingRequirement(**{key: line[key] for key in REQUIREMENT_KEYS}, windows=IndexWindows()),
                value=line["value"],
                count=0,
            )
            for line in content["requirements"]
        ]
        return StoredBudget(windows=IndexWindows(**content["windows"]), start=content["start"], assessments=assessments)
    except InputError:
        raise
    except (ValueError, KeyError, TypeError, AttributeError):
        raise InputError(f"{path}: not written by `flexsat budget`; delete it or write it again") from None
