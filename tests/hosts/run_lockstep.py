"""Run a system with lockstep and save what its outputs are after each tick."""

import json
import sys
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np
from hosting import save

from lockstep import load_system, read_signals, simulate


def main(given: str, saved: str) -> None:
    """Run what `given` says."""
    setup = json.loads(Path(given).read_text(encoding="utf-8"))
    system = load_system(setup["system"])
    if setup["delays"] is not None:
        delays = {tuple(ends.split()): delay for ends, delay in setup["delays"].items()}
        system = replace(
            system,
            connections=tuple(replace(c, delay=delays[c.from_component, c.to_component]) for c in system.connections),
        )
    overrides = {}
    if setup["period"] is not None:
        period = setup["period"]
        system = replace(system, tick=period, components=tuple(replace(c, period=period) for c in system.components))
        overrides["sensors.step_size"] = period / 1e9
    with tempfile.TemporaryDirectory() as folder:
        simulate(
            system,
            Path(folder) / "run",
            stop_time=setup["ticks"] * system.tick / 1e9,
            record=setup["signals"],
            record_period=system.tick / 1e9,
            overrides=overrides,
        )
        signals = read_signals(Path(folder) / "run")
    # a recorded row holds what is true at its time: of the plant what the tick before made
    names = [name for name in signals.columns if signals[name].dtype == np.float64]
    columns = [signals[name][1:] if name.startswith("plant.") else signals[name][:-1] for name in names]
    save(saved, names, np.column_stack(columns))


if __name__ == "__main__":
    for given, saved in zip(sys.argv[1::2], sys.argv[2::2], strict=True):
        main(given, saved)
