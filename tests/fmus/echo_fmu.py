"""Build an FMU that gives each of its inputs back as `out.NAME` at the end of a step, and saves its state."""

from __future__ import annotations

from pathlib import Path

from fmus.c_fmu import compile_library, pack_fmu, quoted

GUID = "{f0a4f7a2-6b0c-4a52-9a53-8d3f5ac1b5a1}"
PORTS = (
    ("x", 0, "Real", 'variability="continuous"', 'start="0" unit="deg"'),
    ("h", 1, "Real", 'variability="discrete"', 'start="0"'),
    ("n", 0, "Integer", 'variability="discrete"', 'start="0" max="9"'),
    ("b", 0, "Boolean", 'variability="discrete"', 'start="false"'),
    ("s", 0, "String", 'variability="discrete"', 'start=""'),
)
SIDES = (("", 0, "input"), ("out.", 10, "output"))  # prefix, added to the value references, causality


def echo_fmu(folder: Path, *, outputs: bool = True) -> Path:
    """Compile and pack the FMU, with or without its outputs; return its path."""
    library = folder / "echo.so"
    compile_library(library, [Path(__file__).with_name("echo.c")], defines=[quoted("GUID", GUID)])
    variables = "".join(
        f'<ScalarVariable name="{prefix}{name}" valueReference="{reference + shift}" causality="{causality}" '
        f"{variability}>"
        f"<{kind} {start if causality == 'input' else ''}/></ScalarVariable>"
        for prefix, shift, causality in SIDES[: 2 if outputs else 1]
        for name, reference, kind, variability, start in PORTS
    ) + (
        '<ScalarVariable name="gain" valueReference="30" causality="parameter" variability="fixed"><Real start="3"/>'
        '</ScalarVariable><ScalarVariable name="inner" valueReference="31" causality="local"><Real/></ScalarVariable>'
    )
    unknowns = "".join(f'<Unknown index="{len(PORTS) + k + 1}"/>' for k in range(len(PORTS)))
    unknowns = f"<Outputs>{unknowns}</Outputs>" if outputs else ""
    unit = (
        '<UnitDefinitions><Unit name="deg"><BaseUnit rad="1" factor="0.017453292519943295"/></Unit></UnitDefinitions>'
    )
    description = (
        f'<?xml version="1.0" encoding="UTF-8"?><fmiModelDescription fmiVersion="2.0" modelName="echo" guid="{GUID}">'
        '<CoSimulation modelIdentifier="echo" canGetAndSetFMUstate="true" canSerializeFMUstate="true"/>'
        f"{unit}<ModelVariables>{variables}</ModelVariables>"
        f"<ModelStructure>{unknowns}</ModelStructure></fmiModelDescription>"
    )
    return pack_fmu(folder / "echo.fmu", description, library)
