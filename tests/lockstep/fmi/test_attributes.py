"""Every attribute of a model description that the master relies on, read from a file of each version of FMI.

In these files no attribute has its default, so that one that is not read is noticed.
"""

import zipfile

import pytest

from lockstep import Component, InputError
from lockstep.check.dynamic.experiment import read_experiment, read_other_experiment
from lockstep.fmi.model_description import read_description
from lockstep.fmi.platforms import PLATFORMS
from lockstep.system.units import Unit

UNITS = """<UnitDefinitions>
  <Unit name="odd"><BaseUnit kg="1" m="2" s="-3" A="4" K="-5" mol="6" cd="-7" rad="8" factor="0.5" offset="2"/></Unit>
  <Unit name="m"><BaseUnit m="1"/></Unit></UnitDefinitions>"""
REAL = 'unit="odd" min="-3" max="4" nominal="7"'
HEAD2 = """<fmiModelDescription fmiVersion="2.0" modelName="model" guid="token">
<CoSimulation modelIdentifier="file" canBeInstantiatedOnlyOncePerProcess="true" canGetAndSetFMUstate="1"
  canSerializeFMUstate="true" canHandleVariableCommunicationStepSize="true"/>"""
FMI2 = f"""{HEAD2}
{UNITS}<TypeDefinitions>
  <SimpleType name="Difference"><Real {REAL} relativeQuantity="true"/></SimpleType>
  <SimpleType name="Count"><Integer min="-5" max="6"/></SimpleType>
  <SimpleType name="Mode"><Enumeration><Item name="off" value="2"/><Item name="on" value="5"/></Enumeration>
  </SimpleType>
</TypeDefinitions>
<LogCategories><Category name="first"/></LogCategories>
<DefaultExperiment startTime="1.5" stopTime="9" tolerance="1e-7" stepSize="0.25"/>
<ModelVariables>
  <ScalarVariable name="own" valueReference="11" causality="input" variability="discrete" description="text">
    <Real {REAL} relativeQuantity="true" start="1.5"/></ScalarVariable>
  <ScalarVariable name="typed" valueReference="12" causality="parameter" variability="tunable">
    <Real declaredType="Difference" start="2.5"/></ScalarVariable>
  <ScalarVariable name="own before type" valueReference="13" causality="input">
    <Real declaredType="Difference" relativeQuantity="false" unit="m" min="1" max="2" start="1"/></ScalarVariable>
  <ScalarVariable name="whole" valueReference="14" causality="parameter" variability="fixed">
    <Integer declaredType="Count" start="3"/></ScalarVariable>
  <ScalarVariable name="flag" valueReference="15" causality="input" variability="discrete"><Boolean start="true"/>
  </ScalarVariable>
  <ScalarVariable name="text" valueReference="16" causality="input" variability="discrete"><String start="ab c"/>
  </ScalarVariable>
  <ScalarVariable name="mode" valueReference="17" causality="parameter" variability="fixed">
    <Enumeration declaredType="Mode" start="5"/></ScalarVariable>
  <ScalarVariable name="state" valueReference="18" causality="local" variability="continuous" initial="approx">
    <Real start="0"/></ScalarVariable>
  <ScalarVariable name="result" valueReference="19" causality="output" initial="calculated"><Real/></ScalarVariable>
</ModelVariables>
<ModelStructure><Outputs><Unknown index="9" dependencies="1
   3" dependenciesKind="dependent  dependent"/></Outputs></ModelStructure></fmiModelDescription>"""

FMI3 = f"""<fmiModelDescription fmiVersion="3.0" modelName="model" instantiationToken="token">
<CoSimulation modelIdentifier="file" canBeInstantiatedOnlyOncePerProcess="true" canGetAndSetFMUState="1"
  canSerializeFMUState="true" canHandleVariableCommunicationStepSize="true"/>
{UNITS}<TypeDefinitions>
  <Float64Type name="Difference" {REAL} relativeQuantity="true"/><UInt8Type name="Count" min="5" max="6"/>
  <EnumerationType name="Mode"><Item name="off" value="2"/><Item name="on" value="5"/></EnumerationType>
</TypeDefinitions>
<DefaultExperiment startTime="1.5" stopTime="9" tolerance="1e-7" stepSize="0.25"/>
<ModelVariables>
  <Float64 name="own" valueReference="11" causality="input" variability="discrete" description="text" {REAL}
    relativeQuantity="true" start="1.5"><Alias name="alias"/></Float64>
  <Float32 name="typed" valueReference="12" causality="parameter" variability="tunable" declaredType="Difference"
    start="2.5"/>
  <Float64 name="own before type" valueReference="13" causality="input" declaredType="Difference"
    relativeQuantity="false" unit="m" min="1" max="2" start="1"/>
  <UInt16 name="whole" valueReference="14" causality="parameter" min="3" max="9" start="3"/>
  <UInt8 name="small" valueReference="20" causality="parameter" declaredType="Count" start="5"/>
  <Int64 name="long" valueReference="21" causality="parameter" min="-7" max="8" start="5"/>
  <Boolean name="flag" valueReference="15" causality="input" start="true"/>
  <String name="text" valueReference="16" causality="input"><Dimension start="2"/><Start value="ab c"/>
    <Start value="d"/></String>
  <Enumeration name="mode" valueReference="17" causality="parameter" declaredType="Mode" start="5"/>
  <UInt64 name="rows" valueReference="22" causality="structuralParameter" start="2"/>
  <Float64 name="grid" valueReference="23" causality="input" start="1 2 3 4"><Dimension valueReference="22"/>
    <Dimension start="2"/></Float64>
  <Float64 name="state" valueReference="18" causality="local" initial="approx" start="0"/>
  <Float64 name="result" valueReference="19" causality="output" initial="calculated"/>
  <Float64 name="time" valueReference="24" causality="independent"/>
</ModelVariables>
<ModelStructure><Output valueReference="19" dependencies="11
   13" dependenciesKind="dependent  dependent"/></ModelStructure></fmiModelDescription>"""

FMI1 = f"""<fmiModelDescription fmiVersion="1.0" modelName="model" modelIdentifier="file" guid="token"
  numberOfContinuousStates="0" numberOfEventIndicators="0">
<UnitDefinitions><BaseUnit unit="odd"/></UnitDefinitions><TypeDefinitions>
  <Type name="Difference"><RealType {REAL} relativeQuantity="true"/></Type>
  <Type name="Mode"><EnumerationType><Item name="off"/><Item name="on"/></EnumerationType></Type></TypeDefinitions>
<DefaultExperiment startTime="1.5" stopTime="9" tolerance="1e-7"/>
<ModelVariables>
  <ScalarVariable name="own" valueReference="11" causality="input" variability="discrete" description="text">
    <Real {REAL} relativeQuantity="true" start="1.5"/></ScalarVariable>
  <ScalarVariable name="typed" valueReference="12" causality="internal" variability="parameter">
    <Real declaredType="Difference" start="2.5"/></ScalarVariable>
  <ScalarVariable name="mode" valueReference="17" causality="internal" variability="parameter">
    <Enumeration declaredType="Mode" start="2"/></ScalarVariable>
  <ScalarVariable name="unused" valueReference="11" causality="input" variability="discrete"><Integer start="3"/>
  </ScalarVariable>
  <ScalarVariable name="result" valueReference="19" causality="output"><Real/>
    <DirectDependency><Name>own</Name></DirectDependency></ScalarVariable>
  <ScalarVariable name="opposite" valueReference="19" causality="output" alias="negatedAlias"><Real/></ScalarVariable>
</ModelVariables>
<Implementation><CoSimulation_StandAlone><Capabilities canBeInstantiatedOnlyOncePerProcess="true"
  canHandleVariableCommunicationStepSize="true"/></CoSimulation_StandAlone></Implementation></fmiModelDescription>"""

ODD = ("odd", (1, 2, -3, 4, -5, 6, -7, 8), 0.5, 2.0)


def packed(folder, version, xml):
    """Write an FMU of a description and an empty library, zipped and as a folder; return both."""
    path, library = folder / "m.fmu", f"binaries/{PLATFORMS[version]}/file.so"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("modelDescription.xml", '<?xml version="1.0" encoding="UTF-8"?>\n' + xml)
        archive.writestr(library, b"")
        archive.extractall(folder / "m")
    return path, folder / "m"


def described(path):
    """Return the description of an FMU."""
    return read_description(Component(name="m", source=path, period=1))


@pytest.fixture(scope="module", params=["1.0", "2.0", "3.0"])
def read(request, tmp_path_factory):
    """Return a version, the description and the experiment that are read from its file."""
    version = request.param
    folder = tmp_path_factory.mktemp("attributes")
    path, unpacked = packed(folder, version, {"1.0": FMI1, "2.0": FMI2, "3.0": FMI3}[version])
    description = described(path)
    if version == "2.0":
        return version, description, read_experiment(unpacked)
    return version, description, read_other_experiment(unpacked, description)


def test_model_and_capabilities(read):
    version, description, experiment = read

    assert (description.model, description.guid, description.identifier) == ("model", "token", "file")
    assert (description.version, description.once_per_process, experiment.once_per_process) == (version, True, True)
    assert description.saves_state is (version != "1.0")
    assert experiment.any_step
    if version == "2.0":
        assert (experiment.saves_state, experiment.serialises_state, experiment.categories) == (True, True, ("first",))


def test_default_experiment(read):
    version, description, experiment = read

    assert description.step_size == (None if version == "1.0" else "0.25")
    assert experiment.step == (0.001 if version == "1.0" else 0.25)
    assert experiment.start_time == 1.5
    assert (description.tolerance, experiment.tolerance) == ((None, None) if version == "1.0" else (1e-7, 1e-7))


@pytest.mark.parametrize("name", ["own", "typed"])
def test_real_with_attributes_of_its_own_and_of_its_type(read, name):
    version, description, experiment = read
    variable = description.variables[name]
    unit = variable.unit

    assert (unit.name, unit.exponents, unit.factor, unit.offset) == (("odd", None, 1, 0) if version == "1.0" else ODD)
    assert (variable.relative, variable.minimum, variable.maximum) == (True, -3.0, 4.0)
    assert variable.start == {"own": "1.5", "typed": "2.5"}[name]
    if name == "own":
        assert (variable.causality, variable.variability, variable.description) == ("input", "discrete", "text")
        assert variable.nominal == 7.0
        port = next(port for port in experiment.inputs if port.name == "own")
        assert (port.start, port.minimum, port.maximum, port.nudge) == (1.5, -3.0, 4.0, 0.07)
    else:
        assert (variable.causality, variable.nominal) == ("parameter", 7.0)
        assert variable.variability == ("fixed" if version == "1.0" else "tunable")


def test_own_attributes_go_before_those_of_the_type(read):
    version, description, _ = read
    if version != "1.0":
        variable = description.variables["own before type"]
        assert (variable.relative, variable.unit.name, variable.minimum, variable.maximum) == (False, "m", 1.0, 2.0)


def test_value_references(read):
    version, description, _ = read
    references = {name: v.array if version == "3.0" else v.reference for name, v in description.variables.items()}

    assert (references["own"], references["typed"], references["result"]) == (11, 12, 19)


def test_items_of_an_enumeration(read):
    version, description, _ = read

    assert description.variables["mode"].items == ({"off": 1, "on": 2} if version == "1.0" else {"off": 2, "on": 5})


def test_bounds_of_integers(read):
    version, description, _ = read
    bounds = {name: (v.minimum, v.maximum) for name, v in description.variables.items()}
    if version == "2.0":
        assert bounds["whole"] == (-5, 6)
    if version == "3.0":
        assert (bounds["whole"], bounds["small"], bounds["long"]) == ((3, 9), (5, 6), (-7, 8))


def test_initial_decides_what_can_be_set(read):
    version, description, _ = read
    variables = description.variables

    assert variables["own"].settable
    assert variables["typed"].settable
    assert not variables["result"].settable
    if version != "1.0":
        assert variables["state"].initial == "approx"
        assert variables["state"].settable


def test_declared_dependencies(read):
    version, _, experiment = read
    result = next(port for port in experiment.outputs if port.name == "result")

    fed = {"1.0": ("own",), "2.0": ("own", "own before type"), "3.0": ("own", "alias", "own before type")}

    assert result.feeds == fed[version]


def test_start_values_of_other_types_and_of_arrays(read):
    version, description, _ = read
    starts = {name: variable.start for name, variable in description.variables.items()}
    if version == "2.0":
        assert (starts["whole"], starts["flag"], starts["text"], starts["mode"]) == ("3", "true", "ab c", "5")
    if version == "3.0":
        assert (starts["whole"], starts["flag"], starts["mode"]) == ("3", "true", "5")
        assert (starts["text[1]"], starts["text[2]"]) == ("ab c", "d")
        assert [starts[f"grid[{row},{column}]"] for row in (1, 2) for column in (1, 2)] == ["1", "2", "3", "4"]


def test_alias_of_fmi_3_has_the_attributes_of_its_variable(read):
    version, description, _ = read
    if version == "3.0":
        alias = description.variables["alias"]
        assert (alias.relative, alias.minimum, alias.maximum, alias.array) == (True, -3.0, 4.0, 11)


def test_negated_alias_of_fmi_1_is_refused_by_name(read):
    version, description, _ = read
    if version == "1.0":
        message = "m.opposite: is a negated alias of FMI 1.0, which is not converted; use result, whose sign is the"
        assert "opposite" not in description.variables
        assert description.lacks("m", "opposite", "output").startswith(message)


@pytest.mark.parametrize("text", ["0", "-1", "INF"])
def test_declared_tolerance_that_is_no_positive_number_is_not_passed(tmp_path, text):
    assert described(packed(tmp_path, "2.0", FMI2.replace("1e-7", text))[0]).tolerance is None


def test_parameters_without_a_variability_are_read_as_fixed_with_a_warning(tmp_path):
    xml = FMI2.replace(' causality="parameter" variability="tunable"', ' causality="parameter"')
    description = described(packed(tmp_path, "2.0", xml)[0])

    assert description.variables["typed"].variability == "fixed"
    (problem,) = description.problems
    assert problem.endswith('has an illegal combination of causality="parameter" and variability="continuous".')


@pytest.mark.parametrize(
    ("version", "old", "new", "message"),
    [
        ("2.0", 'min="-3"', 'min="abc"', "attribute 'min': 'abc' is not a valid value"),
        ("2.0", 'value="2"', 'value="b"', "attribute 'value': 'b' is not a valid value"),
        (
            "2.0",
            'valueReference="11"',
            'valueReference="-11"',
            "attribute 'valueReference': '-11' is not a valid value",
        ),
        ("3.0", 'start="1.5">', 'start="abc">', "attribute 'start': 'abc' is not a valid value"),
        ("3.0", 'start="1 2 3 4"', 'start="1 2"', "grid: 2 start values for 4 elements"),
    ],
)
def test_numbers_that_are_none_are_refused_in_one_line(tmp_path, version, old, new, message):
    xml = {"2.0": FMI2, "3.0": FMI3}[version]
    assert old in xml
    path = packed(tmp_path, version, xml.replace(old, new))[0]

    with pytest.raises(InputError, match="has a bad model description") as caught:
        described(path)
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("factor", ["0", "INF", "NaN"])
def test_unit_with_a_factor_that_converts_nothing_is_known_by_its_name_alone(tmp_path, factor):
    path = packed(tmp_path, "2.0", FMI2.replace('factor="0.5"', f'factor="{factor}"'))[0]

    assert described(path).variables["own"].unit == Unit(name="odd")
