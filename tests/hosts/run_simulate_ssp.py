"""Run an SSP in FMPy's `simulate_ssp` and save what the outputs are after each step, or after every so many.

`simulate_ssp` returns connectors only; other outputs are read through its own instances, after their steps. It applies
no parameter values of the package: they are passed in by its caller, with numbers for booleans.
"""

import json
import os
import sys
import zipfile
from itertools import chain
from pathlib import Path
from types import SimpleNamespace

import fmpy.ssp.simulation
from hosting import save
from lxml import etree

DO_STEP = fmpy.ssp.simulation.do_step


def package_values(package):
    """Return the parameter values inside a package by `component.parameter`, as numbers."""
    with zipfile.ZipFile(package) as archive:
        root = etree.fromstring(archive.read("SystemStructure.ssd"))
    values = {}
    for component in root.iter("{*}Component"):
        for parameter in component.iter("{*}Parameter"):
            text = parameter[0].get("value")
            name = f"{component.get('name')}.{parameter.get('name')}"
            values[name] = float({"true": 1, "false": 0}.get(text, text))
    return values


def main(given, saved):
    """Run what `given` says."""
    setup = json.loads(Path(given).read_text(encoding="utf-8"))
    references = {name: list(outputs.values()) for name, outputs in setup["references"].items()}
    every, step = setup.get("every", 1), setup["tick"] / 1e9
    values = package_values(setup["package"])
    for name, given in setup.get("parameters", {}).items():
        values |= {f"{name}.{parameter}": value for parameter, value in given.items()}
    parameters = [SimpleNamespace(name=name, value=value) for name, value in values.items()]
    steps = dict.fromkeys(references, 0)
    columns = {name: [] for name in references}

    def watched(component, time, step_size):
        DO_STEP(component, time, step_size)
        name = component.name
        if name in references:
            steps[name] += 1
            if steps[name] % every == 0:
                columns[name].append(component.fmu.getReal(references[name]))

    fmpy.ssp.simulation.do_step = watched
    fmpy.ssp.simulation.simulate_ssp(
        setup["package"],
        # half a step less: it adds up its time and would otherwise make a step more or not
        stop_time=(setup["ticks"] - 0.5) * step,
        step_size=step,
        parameter_set=SimpleNamespace(parameters=parameters),
    )
    rows = [list(chain(*parts)) for parts in zip(*columns.values(), strict=True)]
    save(saved, [f"{name}.{output}" for name, outputs in setup["references"].items() for output in outputs], rows)
    sys.stdout.flush()


if __name__ == "__main__":
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    for given, saved in zip(sys.argv[1::2], sys.argv[2::2], strict=True):
        main(given, saved)
