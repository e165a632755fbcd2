"""Rebuild the system of a run from its run.toml."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from lockstep.adapter.component import replace_component
from lockstep.adapter.read import read_adapter
from lockstep.errors import InputError
from lockstep.shadow.component import with_isolation, with_shadow
from lockstep.ssp.load import load_system
from lockstep.ssp.step_times import timing_of_run
from lockstep.system.clock import nanoseconds
from lockstep.system.system import System


def system_of(run: Mapping[str, Any]) -> System:
    """Load the system of a run, with its replaced components, adapters, periods, delays and processes.

    Raises
    ------
    InputError
        If the run was not of a system file, or the file has changed.
    """
    saved = run["system"]
    if not saved["path"]:
        raise InputError(f"system {saved['name']}: was made in Python, not read from a file; pass it to `simulate`")
    system = load_system(Path(saved["path"]), timing_of_run(run))
    if system.sha256 != saved["sha256"]:
        hashes = f"sha256 {saved['sha256'][:12]} then, {(system.sha256 or '')[:12]} now"
        raise InputError(f"{saved['path']}: has changed since the run, {hashes}; restore the old one")
    system = system.with_start_time(nanoseconds(run.get("start_time", 0), "start time"))
    for entry in run["component"]:
        name, source = entry["name"], Path(entry["source"])
        if entry.get("adapter"):
            adapter = read_adapter(Path(entry["adapter"]))
            system = replace_component(system, name, source, adapter)
        elif source != system.component(name).source:
            system = replace_component(system, name, source, None)
        system = system.with_period(name, nanoseconds(entry["period"], f"period of {name}"))
        system = system.with_isolation(name, _isolated(entry))
        if "shadow" in entry:
            system = _with_shadow_of_run(system, name, entry["shadow"])
    pairs = Counter((entry["from"], entry["to"]) for entry in run["latency"])
    for entry in run["latency"]:
        if pairs[entry["from"], entry["to"]] == 1:  # several: then they are those of the file
            system = system.with_delay(entry["from"], entry["to"], entry["delay"])
    return system


def _with_shadow_of_run(system: System, name: str, entry: Mapping[str, Any]) -> System:
    """Return the system with the shadow that run.toml describes for a component."""
    adapter = read_adapter(Path(entry["adapter"])) if "adapter" in entry else None
    over = nanoseconds(entry["switchover"], "switchover") if "switchover" in entry else None
    system = with_shadow(system, name, Path(entry["source"]), adapter, over, nanoseconds(entry["blend"], "blend"))
    return with_isolation(system, entry["name"], _isolated(entry))


def _isolated(entry: Mapping[str, Any]) -> bool | None:
    """Return whether an FMU ran in a process of its own; None: in a shared one, as was decided for it."""
    return None if entry.get("grouped") else bool(entry["isolated"])
