"""Make FMUs that show what the host passes before initialization: start values and tolerance."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from fmus.c_fmu import compile_library, pack_fmu

HERE = Path(__file__).parent
XML2 = """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="setup" guid="g" variableNamingConvention="structured">
  <CoSimulation modelIdentifier="setup" canGetAndSetFMUstate="true" canSerializeFMUstate="true"
    canHandleVariableCommunicationStepSize="true"/>
  <DefaultExperiment stepSize="0.01"{tolerance}/>
  <ModelVariables>
    <ScalarVariable name="p" valueReference="0" causality="parameter" variability="fixed"><Real start="0.5"/>
    </ScalarVariable>
    <ScalarVariable name="u" valueReference="1" causality="input"><Real start="0"/></ScalarVariable>
    <ScalarVariable name="y" valueReference="2" causality="output"><Real/></ScalarVariable>
    <ScalarVariable name="v" valueReference="3" causality="output"><Real/></ScalarVariable>
    <ScalarVariable name="tolerance" valueReference="4" causality="output"><Real/></ScalarVariable>
    <ScalarVariable name="whole" valueReference="0" causality="parameter" variability="tunable"><Integer start="3"/>
    </ScalarVariable>
    <ScalarVariable name="shown" valueReference="0" causality="output" variability="discrete"><Integer/>
    </ScalarVariable>
  </ModelVariables>
  <ModelStructure>
    <Outputs><Unknown index="3"/><Unknown index="4"/><Unknown index="5"/><Unknown index="7"/></Outputs>
    <InitialUnknowns><Unknown index="3"/><Unknown index="4"/><Unknown index="5"/><Unknown index="7"/></InitialUnknowns>
  </ModelStructure>
</fmiModelDescription>
"""
XML3 = """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="3.0" modelName="setup" instantiationToken="g">
  <CoSimulation modelIdentifier="setup"/>
  <DefaultExperiment stepSize="0.01"{tolerance}/>
  <ModelVariables>
    <Float64 name="p" valueReference="0" causality="parameter" variability="fixed" start="0.5"/>
    <Float64 name="y" valueReference="1" causality="output"/>
    <Float64 name="tolerance" valueReference="2" causality="output"/>
    <Float64 name="time" valueReference="9" causality="independent"/>
  </ModelVariables>
  <ModelStructure><Output valueReference="1"/><Output valueReference="2"/><InitialUnknown valueReference="1"/>
    <InitialUnknown valueReference="2"/></ModelStructure>
</fmiModelDescription>
"""


def setup_fmu(
    folder: Path,
    *,
    fmi: int = 2,
    resets: str = "RESETS",
    tolerance: str | None = None,
    edits: Mapping[str, str] | None = None,
) -> Path:
    """Compile and zip an FMU of FMI 2.0 or 3.0 that declares this tolerance, or none; return its path.

    `resets` says when that of FMI 2.0 loses start values: RESETS, RESETS_LATE or nothing. `edits` are texts of the
    model description and what is there instead.
    """
    folder.mkdir(exist_ok=True)
    library = folder / "setup.so"
    source = HERE / ("setup.c" if fmi == 2 else "setup3.c")
    compile_library(library, [source], fmi=fmi, defines=[resets] if resets else [])
    declared = "" if tolerance is None else f' tolerance="{tolerance}"'
    xml = (XML2 if fmi == 2 else XML3).format(tolerance=declared)
    for old, new in (edits or {}).items():
        assert old in xml, old
        xml = xml.replace(old, new)
    return pack_fmu(folder / "setup.fmu", xml, library, fmi=fmi)
