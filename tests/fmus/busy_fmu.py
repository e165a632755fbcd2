"""Build the FMU whose steps take as long as its parameter says, and that can fail in several ways: `busy.c`."""

from __future__ import annotations

from pathlib import Path

from fmus.c_fmu import compile_library, pack_fmu, quoted

GUID = "{3e0a8a0e-6a3b-4f0f-8f7e-41d2b7a0c9d4}"
NOTHING, WARN, FAIL, END_BEFORE, END_AFTER, NOT_A_NUMBER = range(6)  # what `trouble` means
_PARAMETERS = {"gain": 2.0, "work": 0.0, "at": -1.0, "trouble": 0.0}


def busy_fmu(folder: Path) -> Path:
    """Compile and pack the FMU; return its path."""
    library = folder / "busy.so"
    compile_library(library, [Path(__file__).with_name("busy.c")], defines=[quoted("GUID", GUID)])
    parameters = "".join(
        f'<ScalarVariable name="{name}" valueReference="{2 + k}" causality="parameter" variability="fixed">'
        f'<Real start="{start}"/></ScalarVariable>'
        for k, (name, start) in enumerate(_PARAMETERS.items())
    )
    description = (
        f'<?xml version="1.0" encoding="UTF-8"?><fmiModelDescription fmiVersion="2.0" modelName="busy" guid="{GUID}">'
        '<CoSimulation modelIdentifier="busy"/><ModelVariables>'
        '<ScalarVariable name="u" valueReference="0" causality="input"><Real start="0.5"/></ScalarVariable>'
        '<ScalarVariable name="y" valueReference="1" causality="output"><Real/></ScalarVariable>'
        f'{parameters}</ModelVariables><ModelStructure><Outputs><Unknown index="2"/></Outputs>'
        '<InitialUnknowns><Unknown index="2"/></InitialUnknowns></ModelStructure></fmiModelDescription>'
    )
    return pack_fmu(folder / "busy.fmu", description, library)
