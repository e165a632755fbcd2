"""Run an SSP in ecos and save what the outputs are after each base step, or after every so many."""

import json
import sys
from pathlib import Path

from ecospy.EcosSimulation import EcosSimulation
from hosting import save


def main(given, saved):
    """Run what `given` says."""
    setup = json.loads(Path(given).read_text(encoding="utf-8"))
    every = setup.get("every", 1)
    outputs = [(name, output) for name, references in setup["references"].items() for output in references]
    rows = []
    with EcosSimulation(step_size=setup["tick"] / 1e9, ssp_path=setup["package"]) as simulation:
        for name, values in setup.get("parameters", {}).items():
            for parameter, value in values.items():
                simulation.set_real(f"{name}::{parameter}", value)
        assert simulation.init(parameter_set="initialValues")
        for _ in range(setup["ticks"] // every):
            simulation.step(every)
            rows.append([simulation.get_real(f"{_shown_by(name, output)}::{output}") for name, output in outputs])
        simulation.terminate()
    save(saved, [f"{name}.{output}" for name, output in outputs], rows)


def _shown_by(name, output):
    """Return the component to read an output at: accelerations change with the next torque, so as they arrive."""
    return "sensors" if (name, output.partition("[")[0]) == ("plant", "accelerometer_site.acceleration") else name


if __name__ == "__main__":
    for given, saved in zip(sys.argv[1::2], sys.argv[2::2], strict=True):
        main(given, saved)
