"""Run the loop with lockstep in the ways of several hosts, and save its rows of each way, at the step of the hosts."""

import json
import sys
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))
from hosting import save

from lockstep import load_system, read_signals, simulate


def main(given, saved):
    """Run what `given` says."""
    setup = json.loads(Path(given).read_text(encoding="utf-8"))
    names, columns = [], []
    for way, scheme in setup["schemes"].items():
        found = run(load_system(setup["system"]), scheme, setup["step"], setup["ticks"])
        names += [f"{way}|{name}" for name in found]
        columns += found.values()
    save(saved, names, np.column_stack(columns))


def run(system, scheme, step, ticks):
    """Return the real columns of one way by name, one row a step [ns]."""
    if scheme["period"]:
        period = scheme["period"]
        system = replace(system, tick=period, components=tuple(replace(c, period=period) for c in system.components))
    for ends, delay in scheme["delays"].items():
        system = system.with_delay(*ends.split(), delay)
    overrides = {f"{c}.{name}": value for c, values in scheme["values"].items() for name, value in values.items()}
    with tempfile.TemporaryDirectory() as folder:
        simulate(
            system,
            Path(folder) / "run",
            stop_time=ticks * step / 1e9,
            record=["all"],
            record_period=system.tick / 1e9,
            overrides=overrides,
        )
        signals = read_signals(Path(folder) / "run")
    every = step // system.tick
    # a recorded row holds what is true at its time: of the plant what the tick before made
    moved = {name: signals[name][1:] if name.startswith("plant.") else signals[name][:-1] for name in signals.columns}
    return {name: values[every - 1 :: every] for name, values in moved.items() if values.dtype == np.float64}


if __name__ == "__main__":
    main(*sys.argv[1:])
