"""Which variables are differences, to which a unit's offset does not apply: those whose type says so."""

import zipfile

import pytest

from lockstep import Component
from lockstep.fmi.model_description import PLATFORM, read_description

MODEL = """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="m" guid="g"><CoSimulation modelIdentifier="m"/>
<UnitDefinitions><Unit name="degC"><BaseUnit K="1" offset="273.15"/></Unit></UnitDefinitions>
<TypeDefinitions>
  <SimpleType name="Difference"><Real unit="degC" relativeQuantity="true"/></SimpleType>
  <SimpleType name="Temperature"><Real unit="degC"/></SimpleType>
</TypeDefinitions>
<ModelVariables><ScalarVariable name="u" valueReference="0" causality="input"><Real start="0" {attributes}/>
</ScalarVariable></ModelVariables><ModelStructure/></fmiModelDescription>"""


@pytest.mark.parametrize(
    ("attributes", "relative"),
    [
        ('unit="degC"', False),
        ('declaredType="Difference"', True),
        ('declaredType="Temperature"', False),
    ],
)
def test_difference_is_declared_by_the_type_of_a_variable(tmp_path, attributes, relative):
    path = tmp_path / "m.fmu"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("modelDescription.xml", MODEL.format(attributes=attributes))
        archive.writestr(f"binaries/{PLATFORM}/m.so", b"")

    variable = read_description(Component(name="m", source=path, period=1)).variables["u"]

    assert variable.unit.offset == 273.15
    assert variable.relative is relative
