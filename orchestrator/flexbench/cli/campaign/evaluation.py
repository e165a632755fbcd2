"""The words `report` and `rare` of `flexsat campaign`, and the tables at the end of a campaign."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from lockstep.cli.outcome import PRINTED, show_table, suggest
from lockstep.errors import InputError
from lockstep.whole_file import write_whole

from .kept_traceback import kept_traceback

if TYPE_CHECKING:
    from ...campaign.campaign import MakePool


def report(given: Sequence[str], out: Path | None, json: Path | None) -> int:
    """Write the page of a campaign, and print its tables."""
    from ...campaign.result_file import read_about
    from ...campaign.statistics.tables import answer, metric_table, requirement_table, sampling_note
    from ...report.campaigns import write_campaign_page

    if len(given) != 1:
        raise InputError("report: give the folder of one campaign: report results/short")
    (page, numbers), found = write_campaign_page(Path(given[0]), out)
    _write_json(json, numbers)
    if json == PRINTED:
        return 0
    show_table(*metric_table(found))
    if any(one.judgements for one in found):
        print()
        show_table(*requirement_table(found))
    note = sampling_note(str(read_about(Path(given[0]))["sampling"]))
    print("\n".join(["", *answer(found), *([note] if note else []), f"page {page}, numbers {numbers}"]))
    first = found[0]
    worst = first.sample.numbers[first.worst[0][0]]
    suggest(
        f"{{program}} campaign rerun {given[0]} {worst}    # the worst run by {first.metrics[0].name}, fully recorded"
    )
    return 0


def rare(given: Sequence[str], out: Path | None, make_pool: MakePool, json: Path | None) -> int:
    """Find the probability of a rare event."""
    from ...campaign.rare.estimate import RARE, level_rows, run_rare, sentence

    if len(given) != 2:
        raise InputError('rare: give a campaign file and an event: rare wheel_speed.toml "speed > 44.841"')
    path = Path(given[0])
    folder = out or Path("results", f"{path.stem}-rare")
    with kept_traceback(folder):
        event, found = run_rare(path, given[1], folder, make_pool, say(json))
    _write_json(json, folder / RARE)
    if json == PRINTED:
        return 0
    show_table(*level_rows(event, found))
    print("\n".join(["", sentence(event, found), f"levels {folder / RARE}"]))
    suggest(f"{{program}} campaign report {folder}    # its runs, the worst ones first")
    return 0


def say(json: Path | None) -> Callable[[str], None]:
    """Return what prints a line: to standard error where standard output is JSON."""
    return partial(print, file=sys.stderr if json == PRINTED else sys.stdout, flush=True)


def _write_json(path: Path | None, source: Path) -> None:
    """Print or copy a JSON file that was written."""
    if path is None:
        return
    content = source.read_bytes()
    if path == PRINTED:
        print(content.decode(), end="")
        return
    try:
        write_whole(path, content)
    except OSError as error:
        raise InputError(f"--json {path}: cannot be written ({error.strerror}); choose another file") from None
