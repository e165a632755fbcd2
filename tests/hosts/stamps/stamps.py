"""Build the FMU of `stamps.c`, and systems of it in which a fast and a slow component hand stamps to each other."""

from pathlib import Path

from flexsat.fmu.reproducible_zip import zip_bytes
from fmus.c_fmu import compile_library, pack_fmu, quoted
from lockstep import Component, Connection, System, write_ssd
from lockstep.ssp.package_members import package_entries

HERE = Path(__file__).parent
GUID = "{f1c0a7be-stamps}"
OUTPUTS = {"stamp": 1, "least": 2, "largest": 3, "count": 4}
XML = """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="stamps" guid="{guid}">
  <CoSimulation modelIdentifier="stamps" canHandleVariableCommunicationStepSize="true"/>
  <ModelVariables>
    <ScalarVariable name="seen" valueReference="0" causality="input"><Real start="0"/></ScalarVariable>
    {outputs}
  </ModelVariables>
  <ModelStructure><Outputs>{unknowns}</Outputs></ModelStructure>
</fmiModelDescription>
"""


def build_stamps(folder: Path) -> Path:
    """Compile the FMU into a folder; return its path."""
    library = folder / "stamps.so"
    compile_library(library, [HERE / "stamps.c"], defines=[quoted("GUID", GUID)])
    variable = '<ScalarVariable name="{}" valueReference="{}" causality="output"><Real/></ScalarVariable>'
    outputs = "\n    ".join(variable.format(name, reference) for name, reference in OUTPUTS.items())
    unknowns = "".join(f'<Unknown index="{reference + 1}"/>' for reference in OUTPUTS.values())
    description = XML.format(guid=GUID, outputs=outputs, unknowns=unknowns)
    return pack_fmu(folder / "stamps.fmu", description, library)


def stamps_package(fmu: Path, fast: int, slow: int) -> Path:
    """Write an .ssp beside the FMU in which `fast` feeds `slow_reader`, and `slow` feeds `fast_reader`.

    Parameters
    ----------
    fmu : what `build_stamps` made
    fast, slow : periods [ns]

    Returns
    -------
    its path
    """
    periods = {"fast": fast, "slow": slow, "slow_reader": slow, "fast_reader": fast}
    system = System(
        name="stamps",
        tick=fast,
        stop_time=10**9,
        components=tuple(
            Component(
                name=name,
                source=fmu,
                period=period,
                kind="sampled",
                parameters={} if name.endswith("reader") else {"seen": 0.0},
                isolated=False,
            )
            for name, period in periods.items()
        ),
        connections=tuple(
            Connection(from_component=source, output="stamp", to_component=target, input="seen")
            for source, target in (("fast", "slow_reader"), ("slow", "fast_reader"))
        ),
    )
    path = fmu.with_name(f"stamps_{fast}_{slow}.ssd")
    write_ssd(system, path)
    package = path.with_suffix(".ssp")
    package.write_bytes(zip_bytes(package_entries(path), compress=False))
    return package
