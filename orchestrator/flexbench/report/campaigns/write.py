"""Write the page and the statistics of a campaign, whole or not at all."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from flexbench.campaign.samples import CampaignResults, load_samples
from flexbench.campaign.statistics.evaluation import Evaluation
from flexbench.campaign.statistics.tables import answer, plain_values
from flexbench.runs.json_file import write_json
from flexbench.runs.run_folder import refuse_own_file
from lockstep import InputError, RunError
from lockstep.whole_file import DISK_FULL, write_whole

from .compose import compose_page, evaluations

PAGE, STATISTICS = "report.html", "statistics.json"


def write_campaign_page(folder: Path, out: Path | None = None) -> tuple[list[Path], list[Evaluation]]:
    """Write the page of a campaign and its statistics; return the files and the evaluation of each system.

    Parameters
    ----------
    folder : of a merged campaign
    out : page to write; None for report.html in that folder. statistics.json stands beside it

    Raises
    ------
    InputError
        If the folder holds no campaign, or a file cannot be written.
    RunError
        If the disk is full.
    """
    results = load_samples(folder)
    out = out or folder / PAGE
    if out.is_dir():
        raise InputError(f"{out}: is a folder; give a file, for example {out / PAGE}")
    refuse_own_file(out)
    found = evaluations(results)
    page = compose_page(results, found)
    try:
        write_whole(out, page.encode())
        written = write_json(out.with_name(STATISTICS), statistics(results, found))
    except OSError as error:
        if error.errno in DISK_FULL:
            raise RunError(f"{out}: cannot be written ({error.strerror}); free space there and give the same command"
                           " again") from None  # fmt: skip
        raise InputError(f"{out}: cannot be written ({error.strerror or error}); choose another file") from None
    return [out, written], found


def statistics(results: CampaignResults, found: Sequence[Evaluation]) -> dict[str, Any]:
    """Return all numbers of a campaign as plain values, in SI."""
    return {"campaign": results.name, "answer": answer(found), "systems": plain_values(found)}
