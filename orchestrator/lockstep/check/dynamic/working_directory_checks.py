"""Check that results depend neither on the working directory nor on the path, and that no files are left behind."""

from __future__ import annotations

import os
import shutil
from pathlib import Path
from typing import Any

from lockstep.check.dynamic import probes_life
from lockstep.check.dynamic.experiment import Experiment
from lockstep.check.dynamic.probe_process import ProbeResult
from lockstep.check.dynamic.probe_runner import ProbeRunner
from lockstep.check.dynamic.trajectory import Trajectory, difference

SPACES, UMLAUTS = "two short spaces", "Größe und Maß"


def working_directory(runner: ProbeRunner, experiment: Experiment, base: Trajectory) -> ProbeResult:
    """Run from several working directories."""
    read_only = runner.work / "read-only"
    shutil.rmtree(runner.elsewhere)  # remove what earlier checks left there
    runner.elsewhere.mkdir()
    read_only.mkdir(mode=0o555)
    for words, directory, folder in (
        ("in an empty working directory", runner.elsewhere, None),
        ("in a read-only working directory", read_only, None),
        ("in the folder that it is unpacked to", runner.unpacked, None),
        ("in its resources folder", runner.unpacked / "resources", None),
    ):
        unpacked = runner.unpack(folder)
        if not directory.is_dir():
            continue  # it has no resources
        before = _listing(directory)
        wrong = _unlike(runner, experiment, base, folder=folder, directory=directory)
        if wrong:
            return ProbeResult(status="error", message=f"{words}: {wrong}")
        left = sorted(_listing(directory) - before)
        if left and not directory.is_relative_to(unpacked):  # it may write to its own folder
            return ProbeResult(status="error", message=f"leaves files in the working directory: {', '.join(left[:4])}")
    writes = " (as this is root, it could have written there)" if os.access(read_only, os.W_OK) else ""
    return ProbeResult(message=f"the same bits from 4 working directories, one read-only{writes}; nothing left behind")


def resource_location(runner: ProbeRunner, experiment: Experiment, base: Trajectory) -> ProbeResult:
    """Run from paths with spaces and umlauts, in each of the forms that a URI may have."""

    def wrong(folder: Path, form: str) -> str:
        return _unlike(runner, experiment, base, folder=folder, location=form)

    spaces, umlauts = runner.work / SPACES, runner.work / UMLAUTS
    encoded = wrong(spaces, "encoded")
    if encoded:
        return ProbeResult(status="error", message=f"unpacked to a path with spaces: {encoded}")
    if experiment.fmi != "2.0":  # which alone passes a URI of the resources
        encoded = wrong(umlauts, "encoded")
        if encoded:
            return ProbeResult(status="error", message=f"unpacked to a path with umlauts: {encoded}")
        return ProbeResult(message="the same bits from paths with spaces and umlauts")
    encoded, bare = wrong(umlauts, "encoded"), wrong(runner.unpacked, "bare")
    if encoded and wrong(umlauts, "raw"):
        return ProbeResult(status="error", message=f"unpacked to a path with umlauts: {encoded}")
    failures = []
    if encoded:
        failures.append(f"with percent-encoded umlauts, though it runs where a host leaves them as they are: {encoded}")
    if bare:
        failures.append(f"without an authority, file:/path: {bare}")
    if failures:
        return ProbeResult(status="warning", message=f"a resource location {'; and '.join(failures)}")
    return ProbeResult(message="the same bits from paths with spaces and umlauts, and without an authority, file:/path")


def _unlike(runner: ProbeRunner, experiment: Experiment, base: Trajectory, **options: Any) -> str:
    """Repeat the run and describe the difference from the reference; empty if there is none."""
    result = runner.run(probes_life.trajectory, experiment, name="there", steps=len(base), **options)
    if result.status == "error":
        return result.message
    return difference(Trajectory.load(runner.results / "there.npz"), base, experiment)


def _listing(folder: Path) -> set[str]:
    return {str(path.relative_to(folder)) for path in folder.rglob("*")}
