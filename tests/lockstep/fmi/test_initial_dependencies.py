"""Long lists of dependencies of initial unknowns are not read; a fault in them, or beside them, is found as ever."""

import io
import re
import zipfile

import pytest

from lockstep.fmi.description_corrections import read_with_fmpy
from lockstep.fmi.model_description import parse_description

COUNT = 160  # outputs, each of which depends on as many parameters at the start: 70,000 characters


def fmu(known="", kinds="dependent", end=""):
    """Return an FMU of a description whose initial unknowns depend on these variables; one output on two inputs."""
    parameters = [
        f'<ScalarVariable name="p{k}" valueReference="{k}" causality="parameter"\n variability="tunable">'
        '<Real start="1"/></ScalarVariable>'
        for k in range(1, COUNT + 1)
    ]
    outputs = [
        f'<ScalarVariable name="y{k}" valueReference="{k}" causality="output"><Real/></ScalarVariable>'
        for k in range(COUNT + 1, 2 * COUNT + 1)
    ]
    unknowns = [
        f'<Unknown index="{k}" dependencies="{known}" dependenciesKind="{" ".join([kinds] * len(known.split()))}"/>'
        for k in range(COUNT + 1, 2 * COUNT + 1)
    ]
    listed = "".join(f'<Unknown index="{k}" dependencies="1 2"/>' for k in range(COUNT + 1, 2 * COUNT + 1))
    xml = f"""<fmiModelDescription fmiVersion="2.0" modelName="m" guid="g"><CoSimulation modelIdentifier="m"/>
<ModelVariables>{"".join(parameters + outputs)}{end}</ModelVariables>
<ModelStructure><Outputs>{listed}</Outputs><InitialUnknowns>{"".join(unknowns)}</InitialUnknowns></ModelStructure>
</fmiModelDescription>"""
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        archive.writestr("modelDescription.xml", xml)
    stream.seek(0)
    return stream


ALL = " ".join(str(k) for k in range(1, COUNT + 1))


def test_what_is_read_is_the_same_but_for_the_dependencies_of_initial_unknowns():
    many, few = (read_with_fmpy(fmu(known), validate=True)[0] for known in (ALL, "1 2 3"))

    assert variables(many) == variables(few)
    assert {tuple(v.name for v in unknown.dependencies) for unknown in many.outputs} == {("p1", "p2")}
    assert [unknown.variable.name for unknown in many.initialUnknowns] == [
        f"y{k}" for k in range(COUNT + 1, 2 * COUNT + 1)
    ]
    assert {unknown.dependencies is None for unknown in many.initialUnknowns} == {True}
    assert {len(unknown.dependencies) for unknown in few.initialUnknowns} == {3}


def variables(model):
    """Return what is read of the variables of a description."""
    return [(v.name, v.valueReference, v.causality, v.variability, v.type, v.start) for v in model.modelVariables]


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"known": f"{ALL} {2 * COUNT + 1}"}, "list index out of range"),
        ({"known": f"{ALL} x"}, "'x' is not a valid value"),
        ({"known": ALL, "kinds": "often"}, "'often' is not an element of the set"),
        # behind tags on two lines each: the line is that of the file
        ({"known": ALL, "end": "\n<ScalarVariable/>"}, f"(line {COUNT + 3}, column 0)"),
    ],
)
def test_a_fault_in_long_lists_or_beside_them_is_said_of_the_file_itself(changes, message):
    with pytest.raises(ValueError, match=re.escape(message)):
        parse_description(fmu(**changes))
