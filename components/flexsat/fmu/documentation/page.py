"""The entry page of an FMU's documentation: one HTML file from the ports and the component's text, no network."""

from __future__ import annotations

from collections.abc import Sequence

from ...ports.table import FmiVersion, PortTable
from .component_text import FRAMES, PAPER, ComponentText
from .device_rows import DEVICE_COLUMNS, WHEEL_COLUMNS, DeviceRows
from .experiments import Experiment
from .native_notes import NativeNotes
from .port_rows import port_rows, unit_rows
from .render import fill
from .terminals import terminals_of

OLDEST_PYTHON = "3.11"  # the sources need it; CPython's stable ABI lets the binary load any newer one


def page(
    table: PortTable,
    text: ComponentText,
    experiments: Sequence[Experiment],
    *,
    file: str,
    model_name: str,
    configuration: str,
    devices: DeviceRows,
    version: str,
    step: float,
    stop: float,
    execution_tool: bool = False,
    native: NativeNotes | None = None,
    fmi: FmiVersion = "2.0",
) -> bytes:
    """Return documentation/index.html: well-formed, self-contained, the same bytes for the same input.

    Parameters
    ----------
    table : the component's ports, in the naming of the FMU
    text : its words
    experiments : those that travel with reference results
    file : name with which the FMU is delivered
    configuration : one sentence on the layout of the wheels
    devices : wheels and sensors in the order of the arrays' elements
    step, stop : of the default experiment [s]
    execution_tool : whether the model description declares that a tool is needed
    native : of an FMU in C; None for one in Python
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
        devices=devices,
        wheel_columns=WHEEL_COLUMNS,
        device_columns=DEVICE_COLUMNS,
        file=file,
        model_name=model_name,
        version=version,
        naming=table.naming,
        step=f"{step:g}",
        step_size=step,
        stop_time=stop,
        output=output.name if fmi == "2.0" else output.port.name,
        oldest_python=OLDEST_PYTHON,
        execution_tool=execution_tool,
        native=native,
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


def external_dependencies(native: NativeNotes | None = None, fmi: FmiVersion = "2.0") -> bytes:
    """Return documentation/externalDependencies.txt: what a host must provide; arguments as of `page`."""
    if native is not None:
        return fill("externalDependencies_native.txt", native=native, major=fmi[0])
    return fill("externalDependencies.txt", oldest_python=OLDEST_PYTHON)


def replay_instructions(native: bool = False, fmi: FmiVersion = "2.0") -> bytes:
    """Return documentation/fmi-ls-ref.txt: how to replay the experiments, and the tolerance to compare with."""
    return fill("fmi-ls-ref.txt", native=native, fmi=fmi)
