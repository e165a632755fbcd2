"""Step one FMU through FMPy, by its low-level calls or by `simulate_fmu`, and save its outputs after each step."""

import json
import os
import sys
import tempfile
from pathlib import Path

import fmpy
import numpy as np
from fmpy.fmi2 import FMU2Slave
from hosting import save


def moved(inputs, tick):
    """Return what the real inputs are at a tick: integers and one product, so that C computes the same bits."""
    return [start + ((7 * tick + 13 * i) % 23 - 11) / 1048576.0 for i, (_, start) in enumerate(inputs)]


def low_level(setup):
    """Call function by function, as a host in C does."""
    description = fmpy.read_model_description(setup["fmu"])
    folder = tempfile.mkdtemp()
    fmpy.extract(setup["fmu"], folder)
    fmu = FMU2Slave(
        guid=description.guid,
        unzipDirectory=folder,
        modelIdentifier=description.coSimulation.modelIdentifier,
        instanceName="one",
    )
    references = [reference for reference, _ in setup["inputs"]]
    fmu.instantiate(loggingOn=True)
    fmu.setupExperiment()
    fmu.enterInitializationMode()
    if setup["times"] == "simulate_fmu":  # which sets inputs before it leaves initialisation
        fmu.setReal(references, moved(setup["inputs"], 0))
    fmu.exitInitializationMode()
    rows = []
    for tick in range(setup["steps"]):
        if references:
            fmu.setReal(references, moved(setup["inputs"], tick))
        if setup["times"] == "simulate_fmu":
            step = setup["step"] / 1e9
            fmu.doStep(tick * step, (tick + 1) * step - tick * step)
        else:
            fmu.doStep(tick * setup["step"] / 1e9, setup["step"] / 1e9)
        rows.append(fmu.getReal(list(setup["outputs"].values())))
    fmu.terminate()
    fmu.freeInstance()
    return rows


def simulated(setup):
    """Let `simulate_fmu` do everything, from a table of input signals."""
    step, steps = setup["step"] / 1e9, setup["steps"]
    variables = fmpy.read_model_description(setup["fmu"]).modelVariables
    names = {v.valueReference: v.name for v in variables if v.type == "Real"}
    booleans = [v.name for v in variables if v.causality == "input" and v.type == "Boolean"]
    held = {names[v.valueReference]: v for v in variables if v.type == "Real" and v.causality == "input"}
    inputs = [names[reference] for reference, _ in setup["inputs"]]
    held = {name: float(v.start) for name, v in held.items() if name not in inputs}
    types = [("time", np.float64)] + [(name, np.float64) for name in [*inputs, *held]]
    signals = np.array(
        [
            (tick * step, *moved(setup["inputs"], tick), *held.values(), *(False for _ in booleans))
            for tick in range(steps + 1)
        ],
        dtype=[*types, *((name, np.bool_) for name in booleans)],
    )
    result = fmpy.simulate_fmu(
        setup["fmu"],
        stop_time=steps * step,
        output_interval=step,
        input=signals,
        output=list(setup["outputs"]),
    )
    return [[row[name] for name in setup["outputs"]] for row in result[1:]]


def main(given, saved):
    """Run what `given` says."""
    setup = json.loads(Path(given).read_text(encoding="utf-8"))
    rows = simulated(setup) if setup["way"] == "simulate_fmu" else low_level(setup)
    save(saved, list(setup["outputs"]), rows)
    sys.stdout.flush()


if __name__ == "__main__":
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    main(*sys.argv[1:])
