"""Build an FMU whose whole future depends on its state: a filter of its inputs with noise, see wanderer.c."""

from pathlib import Path

from fmus.c_fmu import compile_library, pack_fmu

HERE = Path(__file__).parent

PORTS = {  # name: type, causality, variability, value reference
    "u": ("Real", "input", "continuous", 0),
    "offset": ("Real", "input", "continuous", 1),
    "gain": ("Real", "parameter", "tunable", 2),
    "y": ("Real", "output", "continuous", 3),
    "began": ("Real", "output", "continuous", 4),
    "sleep": ("Real", "parameter", "fixed", 5),
    "number": ("Integer", "input", "discrete", 0),
    "steps": ("Integer", "output", "discrete", 1),
    "seed": ("Integer", "parameter", "fixed", 2),
    "sleep_at": ("Integer", "parameter", "fixed", 3),
    "flag": ("Boolean", "input", "discrete", 0),
    "odd": ("Boolean", "output", "discrete", 1),
}
STARTS = {"gain": "1", "seed": "1"}


def wanderer(folder: Path, name: str, *defines: str) -> Path:
    """Compile the FMU; another name makes another FMU with the same ports."""
    library = folder / f"{name}.so"
    compile_library(library, [HERE / "wanderer.c"], defines=defines, options=["-std=c11", "-ffp-contract=off"])
    able = str("MUTE" not in defines).lower()
    lines = []
    for port, (kind, causality, variability, reference) in PORTS.items():
        variability = "tunable" if port == "seed" and "RESEEDS" in defines else variability
        start = f' start="{STARTS.get(port, "0" if kind != "Boolean" else "false")}"' if causality != "output" else ""
        lines.append(
            f'<ScalarVariable name="{port}" valueReference="{reference}" causality="{causality}"'
            f' variability="{variability}"><{kind}{start}/></ScalarVariable>'
        )
    outputs = [k for k, port in enumerate(PORTS.values(), 1) if port[1] == "output"]
    unknowns = "".join(f'<Unknown index="{k}"/>' for k in outputs)
    xml = (
        f'<?xml version="1.0" encoding="UTF-8"?><fmiModelDescription fmiVersion="2.0" modelName="{name}" guid="{name}">'
        f'<CoSimulation modelIdentifier="{name}" canHandleVariableCommunicationStepSize="true"'
        f' canGetAndSetFMUstate="{able}" canSerializeFMUstate="{able}"/>'
        f"<ModelVariables>{''.join(lines)}</ModelVariables>"
        f"<ModelStructure><Outputs>{unknowns}</Outputs><InitialUnknowns>{unknowns}</InitialUnknowns></ModelStructure>"
        "</fmiModelDescription>"
    )
    return pack_fmu(folder / f"{name}.fmu", xml, library)
