"""Run an SSP with lockstep and save what its outputs are, as the scripts of the other masters do."""

import json
import sys
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np
from hosting import save

from lockstep import load_system, read_signals, simulate


def main(given: str, saved: str) -> None:
    """Run what `given` says: also `delays` by two components, in ticks, and `one_rate` of all, in ns."""
    setup = json.loads(Path(given).read_text(encoding="utf-8"))
    system = load_system(setup["package"])
    period = setup.get("one_rate")
    if period is not None:
        parts = tuple(replace(c, period=period) for c in system.components)
        system = replace(system, tick=period, components=parts)
    for ends, delay in setup.get("delays", {}).items():
        system = system.with_delay(*ends.split(), delay)
    overrides = {f"{c}.{p}": value for c, values in setup["parameters"].items() for p, value in values.items()}
    names = [f"{name}.{output}" for name, outputs in setup["references"].items() for output in outputs]
    with tempfile.TemporaryDirectory() as folder:
        rows = setup["every"] * setup["tick"]
        simulate(
            system,
            Path(folder) / "run",
            stop_time=setup["ticks"] * setup["tick"] / 1e9,
            record=names,
            record_period=rows / 1e9,
            overrides=overrides,
        )
        signals = read_signals(Path(folder) / "run")
    # a recorded row holds what is true at its time: of the plant what the tick before made
    shift = {c.name: slice(1, None) if c.kind == "continuous" else slice(None, -1) for c in system.components}
    save(saved, names, np.column_stack([signals.columns[name][shift[name.partition(".")[0]]] for name in names]))


if __name__ == "__main__":
    main(*sys.argv[1:])
