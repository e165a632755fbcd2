"""FMPy's validation, which is spared the names that need none: with the same problems as without that."""

import itertools

import pytest
from fmpy.model_description import ModelDescription, ScalarVariable
from fmpy.validation import validate_fmu, validate_model_description

from fmus.bad.bad_fmus import XML, bad_fmu
from lockstep.fmi.description_corrections import is_plain, validation_problems

PLAIN = ("a", "_", "der", "a.b_1", "a[1]", "a[10,2].b", "der(a)", "der(a.b[1],2)")
OTHERS = ("", "1", "a b", "a.", ".a", "a[]", "a[x]", "a[1", "der(a", "der()", "der(a,)", "'a b'", "a\n", "ä", "a[1][2]")


def refused(name):
    """Return whether FMPy's grammar of structured names refuses a name."""
    model = ModelDescription()
    model.fmiVersion, model.variableNamingConvention = "2.0", "structured"
    variable = ScalarVariable(name=name, valueReference=0)
    variable.type, variable.causality, variable.variability, variable.initial = "Real", "output", "continuous", "exact"
    variable.start = "0"
    model.modelVariables = [variable]
    problems = validate_model_description(model, validate_variable_names=True)
    return any("is not a legal variable name" in problem for problem in problems)


def test_a_plain_name_is_one_of_the_grammar():
    assert all(map(is_plain, PLAIN))
    assert not any(map(refused, PLAIN))
    assert not any(map(is_plain, OTHERS))
    assert [name for name in OTHERS if not refused(name)] == ["'a b'"]  # in quotes, which FMPy is left to judge


def test_the_characters_of_plain_names_are_those_of_the_grammar():
    parts = ("a", "1", "[1]", ".", "der(", ")")
    names = {"".join(word) for count in (1, 2, 3) for word in itertools.product(parts, repeat=count)}
    plain = sorted(name for name in names if is_plain(name))

    assert len(plain) > 10
    assert not any(map(refused, plain))


@pytest.mark.parametrize("name", ["scaled", "sca led", "'sca led'"])
def test_the_problems_are_those_that_fmpy_finds(tmp_path, name):
    path = bad_fmu(tmp_path, xml=XML.replace('name="scaled"', f'name="{name}"'))

    assert validation_problems(path) == validate_fmu(str(path))
    assert bool(validation_problems(path)) == (name == "sca led")


def test_other_problems_than_names_are_found_with_plain_names(tmp_path):
    path = bad_fmu(tmp_path, xml=XML.replace("<Outputs>", '<Outputs><Unknown index="1"/>', 1))

    assert validation_problems(path) == validate_fmu(str(path)) != []
