"""The entry page of an FMU's documentation: one HTML file from the ports and the component's text, no network."""

from __future__ import annotations

from collections.abc import Sequence

from ...ports.table import FmiVersion, PortTable
from .component_text import FRAMES, PAPER, ComponentText
from .experiments import Experiment
from .port_rows import port_rows, unit_rows
from .render import fill
from .terminals import terminals_of

OLDEST_PYTHON = "3.11"  # the sources need it; CPython's stable ABI lets the binary load any newer one


def page(
    table: PortTable,
    text: ComponentText,
    experiments: Sequence[Experiment],
    *,
    model_name: str,
    configuration: str,
    version: str,
    step: float,
    stop: float,
    execution_tool: bool = False,
    compile_command: str | None = None,
    fmi: FmiVersion = "2.0",
) -> bytes:
    """Return documentation/index.html: well-formed, self-contained, the same bytes for the same input.

    Parameters
    ----------
    table : the component's ports, in the naming of the FMU
    text : its words
    experiments : those that travel with reference results
    configuration : one sentence on the layout of the wheels
    step, stop : of the default experiment [s]
    execution_tool : whether the model description declares that a tool is needed
    compile_command : builds the library in the folder sources/; None for an FMU in Python
    """
    output = next(v for v in table.variables if v.port.causality == "output")
    return fill(
        "page.html",
        fmi=fmi,
        major=fmi[0],
        picture="../model.png" if fmi == "2.0" else "diagram.png",
        title=f"{text.title}: {model_name}",
        text=text,
        paper=PAPER,
        frames=FRAMES,
        configuration=configuration,
        model_name=model_name,
        version=version,
        naming=table.naming,
        step=f"{step:g}",
        step_size=step,
        stop_time=stop,
        output=output.name if fmi == "2.0" else output.port.name,
        oldest_python=OLDEST_PYTHON,
        execution_tool=execution_tool,
        compile_command=compile_command,
        inputs=port_rows(table, "input", fmi),
        outputs=port_rows(table, "output", fmi),
        parameters=port_rows(table, "parameter", fmi),
        tunable=any(port.variability == "tunable" for port in table),
        units=unit_rows(table),
        terminals=[(t.name, t.matching, t.description) for t in terminals_of(table)],
        experiments=[
            (e.name, e.description, f"{e.stop_time:g} s", f"{e.step:g} s", f"{e.record_every * e.step:g} s")
            for e in experiments
        ],
    )


def external_dependencies(compile_command: str | None = None, fmi: FmiVersion = "2.0") -> bytes:
    """Return documentation/externalDependencies.txt: what a host must provide; arguments as of `page`."""
    if compile_command is not None:
        platform = "linux64" if fmi == "2.0" else "x86_64-linux"
        return fill("externalDependencies_native.txt", compile_command=compile_command, major=fmi[0], platform=platform)
    return fill("externalDependencies.txt", oldest_python=OLDEST_PYTHON)


def replay_instructions(native: bool = False, fmi: FmiVersion = "2.0") -> bytes:
    """Return documentation/fmi-ls-ref.txt: how to replay the experiments, and the tolerance to compare with."""
    return fill("fmi-ls-ref.txt", native=native, fmi=fmi)
