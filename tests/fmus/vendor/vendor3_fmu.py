"""Compile the foreign controller as FMI 3.0. Its adapter is that of FMI 2.0, but arrays count from 1 in the master."""

from __future__ import annotations

from pathlib import Path

from fmus.c_fmu import compile_library, pack_fmu, quoted
from fmus.vendor.vendor_fmu import ADAPTER, GUID, HERE, UNITS

ADAPTER3 = ADAPTER.replace("index_base = 0\n", "")

_ROWS = (  # name, type, causality, elements, unit, start
    ("q_IB", "Float64", "input", 4, "", "1 0 0 0"),
    ("w_meas", "Float32", "input", 3, "deg/s", "0"),
    ("whl_n", "Float64", "input", 6, "rpm", "0"),
    ("TauCmd", "Float64", "output", 6, "mN.m", ""),
    ("kp", "Float64", "parameter", 0, "", "0.02"),
    ("kd", "Float64", "parameter", 0, "", "0.2"),
    ("tau_max", "Float64", "parameter", 0, "mN.m", "4400"),
    ("q_ok", "Int8", "input", 0, "", "0"),
    ("Mode", "UInt8", "input", 0, "", "0"),
    ("StatusWord", "UInt64", "output", 0, "", ""),
)


def vendor3_fmu(folder: Path) -> Path:
    """Compile and zip the controller; return its path."""
    library = folder / "vendor.so"
    compile_library(library, [HERE / "vendor3.c"], fmi=3, defines=[quoted("TOKEN", GUID)])
    return pack_fmu(folder / "vendor.fmu", _description(), library, fmi=3)


def _description() -> str:
    rows, outputs = [], ""
    for reference, (name, kind, causality, count, unit, start) in enumerate(_ROWS):
        variability = "fixed" if causality == "parameter" else "discrete"
        more = (f' unit="{unit}"' if unit else "") + (f' start="{start}"' if start else "")
        inner = f'<Dimension start="{count}"/>' if count else ""
        rows.append(
            f'    <{kind} name="{name}" valueReference="{reference}" causality="{causality}" '
            f'variability="{variability}"{more}>{inner}</{kind}>'
        )
        if causality == "output":
            outputs += f'<Output valueReference="{reference}"/>'
    outputs += outputs.replace("Output", "InitialUnknown")
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        f'<fmiModelDescription fmiVersion="3.0" modelName="vendor" instantiationToken="{GUID}">\n'
        '  <CoSimulation modelIdentifier="vendor" canBeInstantiatedOnlyOncePerProcess="true" '
        f'fixedInternalStepSize="0.01"/>{UNITS}\n  <DefaultExperiment stepSize="0.01"/>\n  <ModelVariables>\n'
        + "\n".join(rows)
        + '\n    <Float64 name="time" valueReference="99" causality="independent" variability="continuous"/>\n'
        f"  </ModelVariables>\n  <ModelStructure>{outputs}</ModelStructure>\n</fmiModelDescription>\n"
    )
