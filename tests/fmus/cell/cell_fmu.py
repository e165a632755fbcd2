"""Build an FMU with inputs, outputs and parameters of all types, a noise of its own and a state; see cell.c."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from fmus.c_fmu import compile_library, pack_fmu, quoted

GUID = "{5a0e8f5c-6a50-4b3b-9a53-0c1f5ac1b5a1}"
_IN, _OUT, _P = 'causality="input"', 'causality="output"', 'causality="parameter"'
PORTS = (
    *((f"u[{k + 1}]", k, _IN, "Real", 'start="0" unit="deg"') for k in range(3)),
    *((f"y[{k + 1}]", 10 + k, _OUT, "Real", 'unit="rad"') for k in range(3)),
    ("gain", 20, f'{_P} variability="fixed"', "Real", 'start="0.5"'),
    ("trim", 21, f'{_P} variability="tunable"', "Real", 'start="0" unit="rad" min="-1" max="1"'),
    *((f"{what}_at", 22 + k, f'{_P} variability="fixed"', "Real", 'start="-1"')
      for k, what in enumerate(("fail", "end", "nan", "fatal"))),
    ("k", 0, _IN, "Integer", 'start="0"'),
    ("n", 10, _OUT, "Integer", ""),
    ("b", 0, _IN, "Boolean", 'start="false"'),
    ("flag", 10, _OUT, "Boolean", ""),
    ("label", 0, f'{_P} variability="fixed"', "String", 'start="cell"'),
    ("text", 10, _OUT, "String", ""),
)  # fmt: skip
UNITS = (
    '<UnitDefinitions><Unit name="deg"><BaseUnit rad="1" factor="0.017453292519943295"/></Unit>'
    '<Unit name="rad"><BaseUnit rad="1"/><DisplayUnit name="mrad" factor="1000"/></Unit></UnitDefinitions>'
)


def cell_fmu(folder: Path, *, flags: str = "", state: bool = True, options: Iterable[str] = ()) -> Path:
    """Compile and pack the FMU; `flags` are further attributes of CoSimulation, `options` those of gcc."""
    library = folder / "cell.so"
    source = Path(__file__).with_name("cell.c")
    compile_library(library, [source], defines=[quoted("GUID", GUID)], options=options)
    variables = "".join(
        f'<ScalarVariable name="{name}" valueReference="{reference}" {causality}{_discrete(causality, kind)}>'
        f"<{kind} {more}/></ScalarVariable>"
        for name, reference, causality, kind, more in PORTS
    )
    outputs = "".join(f'<Unknown index="{k + 1}"/>' for k, port in enumerate(PORTS) if port[2] == _OUT)
    able = 'canGetAndSetFMUstate="true" canSerializeFMUstate="true"' if state else ""
    description = (
        f'<?xml version="1.0" encoding="UTF-8"?><fmiModelDescription fmiVersion="2.0" modelName="cell" guid="{GUID}">'
        f'<CoSimulation modelIdentifier="cell" {able} {flags}/>{UNITS}'
        f"<ModelVariables>{variables}</ModelVariables><ModelStructure><Outputs>{outputs}</Outputs>"
        f"<InitialUnknowns>{outputs}</InitialUnknowns></ModelStructure></fmiModelDescription>"
    )
    files = {"documentation/licenses/license.txt": "free\n", "resources/table.txt": "1 2\n", "sources/unused.c": ""}
    return pack_fmu(folder / "cell.fmu", description, library, files=files)


def _discrete(causality: str, kind: str) -> str:
    return ' variability="discrete"' if kind != "Real" and "variability" not in causality else ""
