"""Build the plant and the controller of `known_loop.c`, connect them, and state their loop's margins."""

from pathlib import Path

import numpy as np

from fmus.c_fmu import compile_library, pack_fmu, quoted
from lockstep import Component, Connection, System, write_ssd

HERE = Path(__file__).parent
GUID = "{8c6a4f1e-known-loop}"
STEP = 0.01  # s, of both
KP, KI, GAIN, LAG = 0.9, 0.05, 2.0, 0.05  # as in known_loop.c
XML = """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="known_{kind}" guid="{guid}">
  <CoSimulation modelIdentifier="known" canHandleVariableCommunicationStepSize="true"/>
  <ModelVariables>
    <ScalarVariable name="input" valueReference="0" causality="input"><Real start="0"/></ScalarVariable>
    <ScalarVariable name="output" valueReference="1" causality="output"><Real/></ScalarVariable>
    <ScalarVariable name="noise" valueReference="2" causality="parameter" variability="fixed"><Real start="0"/>
    </ScalarVariable>
  </ModelVariables>
  <ModelStructure><Outputs><Unknown index="2"/></Outputs></ModelStructure>
</fmiModelDescription>
"""


def build_known_loop(folder: Path) -> Path:
    """Compile both FMUs into a folder, and write their system; return its path."""
    for kind in ("plant", "controller"):
        library = folder / kind / "known.so"
        defines = [quoted("GUID", GUID), *(["PLANT"] if kind == "plant" else [])]
        compile_library(library, [HERE / "known_loop.c"], defines=defines)
        pack_fmu(folder / f"{kind}.fmu", XML.format(kind=kind, guid=GUID), library)
    period = round(STEP * 1e9)
    system = System(
        name="known",
        tick=period,
        stop_time=10**9,
        components=(
            Component(name="controller", source=folder / "controller.fmu", period=period, kind="sampled"),
            Component(name="plant", source=folder / "plant.fmu", period=period, kind="continuous"),
        ),
        connections=(
            Connection(from_component="controller", output="output", to_component="plant", input="input"),
            Connection(from_component="plant", output="output", to_component="controller", input="input", delay=2),
        ),
    )
    write_ssd(system, folder / "known.ssd")
    return folder / "known.ssd"


def known_response(frequency: np.ndarray) -> np.ndarray:
    """Return L at frequencies [Hz], from the difference equations; what the controller sees is a step old."""
    back = np.exp(-2j * np.pi * frequency * STEP)
    a = np.exp(-STEP / LAG)
    return (KP + KI / (1.0 - back)) * (1.0 - a) * GAIN * back**2 / (1.0 - a * back)
