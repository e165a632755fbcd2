"""The check of the working directory and of awkward paths: the same bits from anywhere, and nothing left behind."""

from __future__ import annotations

import os
import shutil
from pathlib import Path
from typing import Any

from lockstep.check.experiment import Experiment
from lockstep.check.isolation import Laboratory
from lockstep.check.probe import Verdict
from lockstep.check.trajectory import Trajectory, difference

SPACES, UMLAUTS = "two short spaces", "Größe und Maß"


def working_directory(laboratory: Laboratory, experiment: Experiment, base: Trajectory) -> Verdict:
    """Run from several working directories, and from paths with spaces and umlauts."""
    read_only = laboratory.work / "read-only"
    shutil.rmtree(laboratory.elsewhere)  # what earlier checks left there is no matter of this one
    laboratory.elsewhere.mkdir()
    read_only.mkdir(mode=0o555)
    for words, directory, folder in (
        ("in an empty working directory", laboratory.elsewhere, None),
        ("in a read-only working directory", read_only, None),
        ("in the folder that it is unpacked to", laboratory.unpacked, None),
        ("in its resources folder", laboratory.unpacked / "resources", None),
        ("unpacked to a path with spaces", laboratory.elsewhere, laboratory.work / SPACES),
    ):
        place = laboratory.unpack(folder)
        if not directory.is_dir():
            continue  # it has no resources
        before = _listing(directory)
        wrong = _unlike(laboratory, experiment, base, folder=folder, directory=directory)
        if wrong:
            return Verdict(status="error", message=f"{words}: {wrong}")
        left = sorted(_listing(directory) - before)
        if left and not directory.is_relative_to(place):  # its own folder is its own
            return Verdict(status="error", message=f"leaves files in the working directory: {', '.join(left[:4])}")
    writes = " (as this is root, it could have written there)" if os.access(read_only, os.W_OK) else ""
    told = f"the same bits from 4 working directories, one read-only{writes}, and from a path with spaces; nothing left"
    # RFC 3986, which FMI 2.0 refers to, wants letters outside ASCII percent-encoded; not every host does that
    umlauts = laboratory.work / UMLAUTS
    encoded = _unlike(laboratory, experiment, base, folder=umlauts)
    if not encoded:
        return Verdict(message=f"{told}; also from a path with umlauts")
    if _unlike(laboratory, experiment, base, folder=umlauts, raw_path=True):
        return Verdict(status="error", message=f"unpacked to a path with umlauts: {encoded}", details=(told,))
    message = "unpacked to a path with umlauts it runs only where a host hands them over as they are in the resource "
    message += f"location; percent-encoded, as URIs are: {encoded}"
    return Verdict(status="warning", message=message, details=(told,))


def _unlike(laboratory: Laboratory, experiment: Experiment, base: Trajectory, **options: Any) -> str:
    """Run once more, and say how that was unlike the reference; "" if it was not."""
    verdict = laboratory.run("probes_life:trajectory", experiment, name="there", steps=len(base), **options)
    if verdict.status == "error":
        return verdict.message
    return difference(Trajectory.load(laboratory.results / "there.npz"), base, experiment)


def _listing(folder: Path) -> set[str]:
    return {str(path.relative_to(folder)) for path in folder.rglob("*")}
