"""Run the experiments of a component through its own shell, and write them as FMI-LS-REF files.

FMI-LS-REF 1.0.0-beta.1: a manifest of related files in extra/org.fmi-standard.fmi-ls-ref/; experiments in the format of
the Modelica Association's harmonised specification (MIME type application/x-ma-hs-experiments), parameters as SSP 1.0
parameter sets, stimuli and reference results as CSV.
"""

from __future__ import annotations

import hashlib
import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Element, SubElement

import numpy as np
from numpy.typing import NDArray

from ...ports.table import KINDS, Causality, FmiVersion, PortTable, Scalar, Variable
from .experiments import Experiment
from .fixed_order_run import use_fixed_order
from .xml_text import xml_bytes

FOLDER = "extra/org.fmi-standard.fmi-ls-ref"
MANIFEST, EXPERIMENTS = "fmi-ls-manifest.xml", "experiments.exp"
MANIFEST_NAMESPACE = "http://fmi-standard.org/fmi-ls-manifest"
LAYER = {
    "fmi-ls-name": "org.fmi-standard.fmi-ls-ref",
    "fmi-ls-version": "1.0.0-beta.1",
    "fmi-ls-description": "Layered Standard providing information on related files included in an FMU.",
}
SSV = "http://ssp-standard.org/SSP1/SystemStructureParameterValues"
EXPERIMENTS_TYPE, PARAMETERS_TYPE, CSV_TYPE = (
    "application/x-ma-hs-experiments",
    "application/x-ssp-parameter-set",
    "text/csv",
)
_TAGS = {"real": "Real", "integer": "Integer", "boolean": "Boolean", "string": "String"}

ResultRow = list[Any]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Run:
    """The inputs and outputs of an experiment, in the order of the component's variables.

    Attributes
    ----------
    inputs : value references and kinds are those of the table's inputs; a row a step, time first
    outputs : a row each `record_every` steps, the start included, time first
    """

    experiment: Experiment
    inputs: list[ResultRow]
    outputs: list[ResultRow]


def run_experiments(
    shell: Callable[..., Any],
    resources: Mapping[str, bytes],
    experiments: Sequence[Experiment],
    *,
    fixed_order: bool = True,
) -> tuple[PortTable, list[Run]]:
    """Run experiments through a shell as a plain Python class.

    Parameters
    ----------
    shell : the class, of which only the calls that the wrapper makes are used
    resources : files it reads
    fixed_order : so that results are the same bits on every processor; without it, those of the FMU on this one

    Raises
    ------
    ValueError
        If the component refuses an experiment.
    """
    with tempfile.TemporaryDirectory(prefix="flexsat_reference_") as folder:
        for file, content in resources.items():
            (Path(folder) / file).write_bytes(content)
        runs = []
        for experiment in experiments:
            slave = shell(instance_name=experiment.name, resources=folder)
            if fixed_order:
                use_fixed_order(slave)
            runs.append(_run(slave, experiment))
        return slave.table, runs


def reference_files(table: PortTable, runs: Sequence[Run], fmi: FmiVersion = "2.0") -> dict[str, bytes]:
    """Return the files of all experiments by their path in the archive, with the names of the table's naming.

    In FMI 3.0 a column of stimuli and results is a port; the elements of an array stand in it with blanks between.
    """
    files = {}
    for run in runs:
        name = run.experiment.name
        if run.experiment.parameters:
            files[f"{name}-parameters.ssv"] = _parameter_set(table, run.experiment)
        if run.experiment.stimuli is not None:
            files[f"{name}-stimuli.csv"] = _csv(table, run, "input", fmi)
        files[f"{name}-references.csv"] = _csv(table, run, "output", fmi)
    files[EXPERIMENTS] = _experiments(runs, files)
    files[MANIFEST] = _manifest(files)
    return {f"{FOLDER}/{name}": content for name, content in files.items()}


def parameter_values(table: PortTable, experiment: Experiment) -> list[tuple[Variable, Scalar]]:
    """Return the parameters an experiment sets, a value each scalar."""
    values = []
    for variable in table.variables:
        if variable.port.name in experiment.parameters:
            given = experiment.parameters[variable.port.name]
            values.append((variable, given[variable.element] if isinstance(given, tuple) else given))
    return values


def _run(slave: Any, experiment: Experiment) -> Run:
    """Call a slave as a host does: set, step, read at t + step."""
    table: PortTable = slave.table
    for variable, value in parameter_values(table, experiment):
        getattr(slave, f"set_{variable.port.kind}")([variable.value_reference], [value])
    rows = _input_rows(table, experiment)
    inputs, outputs = _of_causality(table, "input"), _of_causality(table, "output")
    slave.setup_experiment(0.0)
    slave.enter_initialization_mode()
    if experiment.stimuli is not None:
        _set(slave, inputs, rows[0][1:])
    slave.exit_initialization_mode()
    recorded = [[0.0, *_get(slave, outputs)]]
    for k in range(experiment.steps):
        if experiment.stimuli is not None:
            _set(slave, inputs, rows[k][1:])
        slave.do_step(experiment.time(k), experiment.step)
        if (k + 1) % experiment.record_every == 0:
            recorded.append([experiment.time(k + 1), *_get(slave, outputs)])
    slave.terminate()
    if slave.log_queue:
        raise ValueError(f"experiment {experiment.name}: {slave.log_queue[0].msg}")
    return Run(experiment=experiment, inputs=rows, outputs=recorded)


def _input_rows(table: PortTable, experiment: Experiment) -> list[ResultRow]:
    if experiment.stimuli is None:
        return []
    time = np.array([experiment.time(k) for k in range(experiment.steps)])
    given = experiment.stimuli(table, time)
    columns: list[NDArray[np.float64]] = [time[:, None]]
    for port in table:
        if port.causality == "input":
            still = np.array(port.starts, dtype=np.float64)
            values = given.pop(port.name, None)
            shape = (len(time), port.length)
            columns.append(np.broadcast_to(still, shape) if values is None else values.reshape(shape))
    if given:
        raise ValueError(f"experiment {experiment.name}: no such inputs: {', '.join(given)}")
    rows: list[ResultRow] = (np.hstack(columns) + 0.0).tolist()  # no negative zeros
    flags = [1 + i for i, variable in enumerate(_of_causality(table, "input")) if variable.port.kind == "boolean"]
    for row in rows:
        for place in flags:
            row[place] = bool(row[place])
    return rows


def _of_causality(table: PortTable, causality: str) -> list[Variable]:
    return [variable for variable in table.variables if variable.port.causality == causality]


def _set(slave: Any, variables: Sequence[Variable], values: ResultRow) -> None:
    for kind in KINDS:
        chosen = [(v.value_reference, x) for v, x in zip(variables, values, strict=True) if v.port.kind == kind]
        if chosen:
            getattr(slave, f"set_{kind}")([i for i, _ in chosen], [x for _, x in chosen])


def _get(slave: Any, variables: Sequence[Variable]) -> ResultRow:
    values = {}
    for kind in KINDS:
        references = [v.value_reference for v in variables if v.port.kind == kind]
        if references:
            values[kind] = dict(zip(references, getattr(slave, f"get_{kind}")(references), strict=True))
    return [values[v.port.kind][v.value_reference] for v in variables]


def _csv(table: PortTable, run: Run, causality: Causality, fmi: FmiVersion) -> bytes:
    """Write numbers so that reading them gives the same bits; booleans are 0 and 1."""
    arrays = fmi == "3.0"
    variables = _of_causality(table, causality)
    names = dict.fromkeys(v.port.name if arrays else v.name for v in variables)
    head = ",".join(f'"{name}"' for name in ("time", *names))
    marks = tuple(" " if arrays and v.element > 0 else "," for v in variables)
    return f"{head}\n{_lines(run, causality, marks)}".encode()


@lru_cache(maxsize=32)  # the FMUs of a component, flat and in C, have the same numbers
def _lines(run: Run, causality: Causality, marks: tuple[str, ...]) -> str:
    """Return a line for each row; `marks` stand before its values, but for the time."""
    rows = run.inputs if causality == "input" else run.outputs
    lines = [repr(row[0]) + "".join(mark + _number(x) for mark, x in zip(marks, row[1:], strict=True)) for row in rows]
    return "\n".join([*lines, ""])


def _number(value: Scalar) -> str:
    return repr(int(value)) if isinstance(value, bool) else repr(value)


def _parameter_set(table: PortTable, experiment: Experiment) -> bytes:
    root = Element("ssv:ParameterSet", {"xmlns:ssv": SSV, "version": "1.0", "name": experiment.name})
    group = SubElement(root, "ssv:Parameters")
    for variable, value in parameter_values(table, experiment):
        parameter = SubElement(group, "ssv:Parameter", {"name": variable.name})
        text = str(value).lower() if isinstance(value, bool) else repr(value)
        SubElement(parameter, f"ssv:{_TAGS[variable.port.kind]}", {"value": text})
    return xml_bytes(root)


def _experiments(runs: Sequence[Run], files: Mapping[str, bytes]) -> bytes:
    root = Element("Experiments", {"name": "Reference results", "description": "Short runs to compare an import with"})
    for run in runs:
        experiment = run.experiment
        what = {
            "name": experiment.name,
            "description": experiment.description,
            "startTime": "0.0",
            "stopTime": repr(experiment.stop_time),
            "stepSize": repr(experiment.step),
        }
        element = SubElement(root, "Experiment", what)
        for tag, file in (
            ("Parameters", f"{experiment.name}-parameters.ssv"),
            ("Stimuli", f"{experiment.name}-stimuli.csv"),
            ("References", f"{experiment.name}-references.csv"),
        ):
            if file in files:
                kind = PARAMETERS_TYPE if tag == "Parameters" else CSV_TYPE
                SubElement(element, tag, {"type": kind, "source": file})
    return xml_bytes(root)


def _manifest(files: Mapping[str, bytes]) -> bytes:
    head = {f"fmi-ls:{name}": value for name, value in LAYER.items()}
    root = Element("fmiReferences", {"xmlns:fmi-ls": MANIFEST_NAMESPACE, **head})
    roles = {
        ".exp": ("experiment/smoke-test", EXPERIMENTS_TYPE, "experiments to compare an import with"),
        ".ssv": ("parameter", PARAMETERS_TYPE, "parameters of experiment"),
        "-stimuli.csv": ("other", CSV_TYPE, "inputs of experiment"),
        "-references.csv": ("result", CSV_TYPE, "reference results of experiment"),
    }
    for file, content in files.items():
        ending = next(ending for ending in roles if file.endswith(ending))
        role, kind, text = roles[ending]
        description = text if ending == ".exp" else f"{text} {file.rsplit('-', 1)[0]}"
        SubElement(
            root,
            "Related",
            {
                "type": kind,
                "source": file,
                "role": role,
                "description": description,
                "checksum": hashlib.sha3_256(content).hexdigest(),
                "checksumType": "SHA3-256",
            },
        )
    document = {"type": "text/plain", "source": "../../documentation/fmi-ls-ref.txt", "role": "document"}
    SubElement(root, "Related", {**document, "description": "how to replay the experiments, and tolerances"})
    return xml_bytes(root)
