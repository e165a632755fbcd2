"""FMUs with flat names are those with structured names in everything but the names."""

import json
import zipfile
from xml.etree import ElementTree

import pytest

from flexsat.fmu.build import SHELLS
from flexsat.fmu.documentation.experiments import EXPERIMENTS
from flexsat.fmu.documentation.reference_results import run_experiments
from flexsat.fmu.python.load_matrices import MODEL_FILE
from fmus.toys.builds import python

COMPONENTS = ("plant", "sensors", "controller")
SIX = [(name, component) for name in ("centralised", "distributed") for component in COMPONENTS]


@pytest.fixture(params=SIX, ids="/".join)
def pair(request, delivered):
    """Return an FMU with structured names, and its flat twin."""
    name, component = request.param
    return delivered / name / f"{component}.fmu", delivered / name / "flat" / f"{component}.fmu"


def described(fmu):
    with zipfile.ZipFile(fmu) as archive:
        return ElementTree.fromstring(archive.read("modelDescription.xml"))


def as_flat(name):
    return name.replace(".", "_").replace("[", "_").removesuffix("]")


def test_nothing_but_names_and_identity_differs_in_the_model_description(pair):
    structured, flat = map(described, pair)
    names = [v.get("name") for v in flat.findall("ModelVariables/ScalarVariable")]

    assert (structured.get("variableNamingConvention"), flat.get("variableNamingConvention")) == ("structured", "flat")
    assert structured.get("guid") != flat.get("guid")
    assert len(set(names)) == len(names) > 100
    assert not [name for name in names if not name.isidentifier()]
    for root in (structured, flat):
        for attribute in ("modelName", "guid", "variableNamingConvention"):
            del root.attrib[attribute]
        root.find("CoSimulation").attrib.pop("modelIdentifier")
    for variable in structured.findall("ModelVariables/ScalarVariable"):
        variable.set("name", as_flat(variable.get("name")))
    assert ElementTree.tostring(structured) == ElementTree.tostring(flat)


def test_members_of_terminals_match_those_of_the_structured_names(pair):
    members = []
    for fmu in pair:
        with zipfile.ZipFile(fmu) as archive:
            root = ElementTree.fromstring(archive.read("terminalsAndIcons/terminalsAndIcons.xml"))
        members.append([
            (terminal.get("name"), member.get("memberName"), as_flat(member.get("variableName")))
            for terminal in root.iter("Terminal")
            for member in terminal
        ])  # fmt: skip

    assert members[0] == members[1]
    assert members[0]


BOTH = """
import json
from replay import *
from session import FMICallException, argument
path, other, own = argument(0), argument(1), argument(2)
first, second = check_experiments(path), check_experiments(other)
bits = lambda runs: [[[x.hex() for x in row] for row in rows] for rows in runs]
with open(own) as file:
    assert bits(first) == bits(second) == json.load(file)
# messages of an instance have its own names
with Session(other) as session:
    write(session, ["as_published"], [True])
    session.initialize()
    parameter = next(v for v in session.description.modelVariables if v.causality == "parameter" and "_" in v.name
                     and v.type == "Real")
    try:
        session.set(parameter.name, 0.5)
    except FMICallException as error:
        assert error.status == 3
    assert f"{parameter.name} is a fixed parameter" in session.messages[0][2], session.messages
"""


def test_both_replay_the_reference_results_in_one_process(pair, tmp_path):
    """Bitwise as the shell in plain Python, with the same numpy on this machine; the results that travel are rounded
    otherwise.
    """
    with zipfile.ZipFile(pair[0]) as archive:
        resources = {MODEL_FILE: archive.read(f"resources/{MODEL_FILE}")}
    component = pair[0].stem
    _, runs = run_experiments(SHELLS[component], resources, EXPERIMENTS[component], fixed_order=False)
    own = tmp_path / "own.json"
    own.write_text(json.dumps([[[float(x).hex() for x in row] for row in run.outputs] for run in runs]))

    python(BOTH, *pair, own)
