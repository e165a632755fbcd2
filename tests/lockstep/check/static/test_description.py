"""Each static check of the model description finds its defect, and no other check reports it."""

import pytest

from ..conftest import XML, Find, Make, bad, text_of

TORQUE = 'name="torque" valueReference="2"'

# edit, what must not pass, and what the first of these says
DEFECTS = {
    "no co-simulation": (
        ('<CoSimulation modelIdentifier="good" ', '<ModelExchange modelIdentifier="good" '),
        ("static.kind", "model exchange only"),
    ),
    "fmi version": (('fmiVersion="2.0"', 'fmiVersion="4.0"'), ("static.kind", "4.0, not 1.0, 2.0 or 3.0")),
    "attribute that the schema lacks": (
        ('stepSize="0.01"', 'stepSize="0.01" solver="euler"'),
        ("static.schema static.fmpy", "line 8: "),
    ),
    "unit not defined": (
        ('<Real unit="rad" start', '<Real unit="deg" start'),
        ("static.units static.fmpy", "'deg' is used"),
    ),
    "stale unit": (
        ("</UnitDefinitions>", '<Unit name="V"><BaseUnit kg="1" m="2" s="-3" A="-1"/></Unit></UnitDefinitions>'),
        ("static.units", "'V' (line 7) is defined but not used"),
    ),
    "port without unit": (('<Real unit="rad" start', "<Real start"), ("static.units", "attitude[2]")),
    "display unit not defined": (
        ('displayUnit="deg"', 'displayUnit="arcsec"'),
        ("static.units static.fmpy", "'arcsec' of attitude[1]"),
    ),
    "display factor inverted": (
        ('factor="57.29577951308232"', 'factor="0.017453292519943295"'),
        ("static.units", "inverse"),
    ),
    "display factor zero": (('factor="57.29577951308232"', 'factor="0"'), ("static.units", "are not valid")),
    "base units of another unit": (('m="2" s="-2"', 'm="1" s="-2"'), ("static.units", "not what its name says")),
    "unit defined twice": (
        ("</UnitDefinitions>", '<Unit name="N.m"><BaseUnit/></Unit></UnitDefinitions>'),
        ("static.units", "defined twice (lines 6 and 7), differently"),
    ),
    "output not listed": (
        ('      <Unknown index="5" dependencies=""/>\n', ""),
        ("static.unknowns static.fmpy", "Outputs lacks 1 of 2: count"),
    ),
    "output listed twice": (
        ('<Unknown index="5" dependencies=""/>', '<Unknown index="5" dependencies=""/><Unknown index="5"/>'),
        ("static.unknowns", "count more than once"),
    ),
    "initial unknown not listed": (
        ('      <Unknown index="6" dependencies="4"/>\n', ""),
        ("static.unknowns static.fmpy", "InitialUnknowns lacks 1 of 2: size"),
    ),
    "known listed as initial unknown": (
        ('<Unknown index="6" dependencies="4"/>', '<Unknown index="4"/><Unknown index="6" dependencies="4"/>'),
        ("static.unknowns static.fmpy", "InitialUnknowns lists gain"),
    ),
    "initial unknowns out of order": (
        (
            XML[XML.index('      <Unknown index="3" dependencies="1 2 4"') : XML.index("    </InitialUnknowns>")],
            '<Unknown index="6"/><Unknown index="3"/>\n',
        ),
        ("static.unknowns", "order"),
    ),
    "index out of range": (
        ('<Unknown index="6"', '<Unknown index="7"'),
        ("static.unknowns static.fmpy", "'7' is not in 1 to 6"),
    ),
    "dependency out of range": (
        ('index="5" dependencies=""', 'index="5" dependencies="9"'),
        ("static.unknowns static.fmpy", "9"),
    ),
    "kinds of another number": (
        (
            'dependencies="1 2" dependenciesKind="dependent dependent"',
            'dependencies="1 2" dependenciesKind="dependent"',
        ),
        ("static.unknowns static.fmpy", "2 dependencies, but 1 dependenciesKind"),
    ),
    "kind of a later phase": (
        ('dependenciesKind="dependent dependent dependent"', 'dependenciesKind="dependent dependent fixed"'),
        ("static.unknowns", "fixed is not allowed here"),
    ),
    "depends on an output": (
        ('index="5" dependencies=""', 'index="5" dependencies="3"'),
        ("static.unknowns", "torque"),
    ),
    "feedthrough not declared": (('index="5" dependencies=""', 'index="5"'), ("static.unknowns", "every input")),
    "name twice": (
        ('name="attitude[2]"', 'name="attitude[1]"'),
        ("static.names static.fmpy", "attitude[1]: more than one"),
    ),
    "name not structured": (
        ('name="attitude[2]"', 'name="attitude(2)"'),
        ("static.names static.fmpy", "attitude(2) (line 13)"),
    ),
    "names alike": (('name="attitude[2]"', 'name="Torque"'), ("static.names", "Torque and torque")),
    "port without description": ((f'{TORQUE} description="commanded"', TORQUE), ("static.descriptions", "torque")),
    "input with initial": (
        (
            'causality="input" variability="continuous">\n      <Real unit="rad" start',
            'causality="input" variability="continuous" initial="exact">\n      <Real unit="rad" start',
        ),
        ("static.variables", "initial=exact for a continuous input"),
    ),
    "continuous parameter": (
        ('causality="parameter" variability="fixed"', 'causality="parameter" variability="continuous"'),
        ("static.variables static.fmpy", "causality parameter with variability continuous"),
    ),
    "continuous integer": (
        (
            'causality="output" variability="discrete" initial="exact"',
            'causality="output" variability="continuous" initial="exact"',
        ),
        ("static.variables static.fmpy", "Integer cannot be continuous"),
    ),
    "variability left out of an integer": (
        ('causality="output" variability="discrete" initial="exact"', 'causality="output" initial="exact"'),
        ("static.variables static.fmpy", "count: no variability"),
    ),
    "input without start": (
        ('<Real unit="rad" start="0"/>', '<Real unit="rad"/>'),
        ("static.variables static.fmpy", "attitude[2]"),
    ),
    "start of a calculated value": (
        ('<Real unit="N.m"/>', '<Real unit="N.m" start="1"/>'),
        ("static.variables static.fmpy", "start=1"),
    ),
    "start outside of its range": (('start="2"', 'start="7"'), ("static.variables", "7 is outside of 0 to 5")),
    "empty range": (('min="0" max="5"', 'min="5" max="0"'), ("static.variables", "min=5 is above max=0")),
    "start not finite": (('start="2"', 'start="NaN"'), ("static.variables", "not finite")),
    "aliases of two inputs": (
        ('name="attitude[2]" valueReference="1"', 'name="attitude[2]" valueReference="0"'),
        ("static.aliases", "set from outside"),
    ),
    "alias": ((TORQUE, 'name="torque" valueReference="0"'), ("static.aliases", "units differ")),
    "fixed step not declared": ((' stepSize="0.01"', ""), ("static.experiment", "stepSize is not declared")),
    "step of zero": (('stepSize="0.01"', 'stepSize="0"'), ("static.experiment", "not above zero")),
    "ends before it begins": (('startTime="0"', 'startTime="2"'), ("static.experiment", "not after")),
    "step longer than the experiment": (('stepSize="0.01"', 'stepSize="2"'), ("static.experiment", "longer")),
    "step between nanoseconds": (('stepSize="0.01"', 'stepSize="0.0333333333"'), ("static.experiment", "nanoseconds")),
    "serialises without get and set": (('canGetAndSetFMUstate="true" ', ""), ("static.functions", "without")),
    "one instance a process": (
        ("<CoSimulation ", '<CoSimulation canBeInstantiatedOnlyOncePerProcess="true" '),
        ("static.instances", "process each"),
    ),
    "tool that is not named": (
        ("<CoSimulation ", '<CoSimulation needsExecutionTool="true" '),
        ("static.dependencies", "names the tool"),
    ),
}
INFOS = {"feedthrough not declared", "step between nanoseconds", "one instance a process"}
WARNINGS = {
    "stale unit", "port without unit", "display factor inverted", "base units of another unit", "depends on an output",
    "names alike", "port without description", "variability left out of an integer", "start outside of its range",
    "empty range", "start not finite", "fixed step not declared", "step longer than the experiment",
    "tool that is not named",
}  # fmt: skip


def test_good_fmu_passes_every_static_check(make: Make, found: Find) -> None:
    findings = found(make())

    assert bad(findings) == {}
    assert len(findings) == 18


@pytest.mark.parametrize("defect", DEFECTS)
def test_each_defect_is_found_by_its_check_alone(make: Make, found: Find, defect: str) -> None:
    (old, new), (checks, says) = DEFECTS[defect]
    assert XML.count(old) >= 1
    findings = found(make(xml=XML.replace(old, new, 1)))

    first = checks.split()[0]
    skipped = {check for check, finding in findings.items() if finding.status == "skipped"}
    expected = "info" if defect in INFOS else "warning" if defect in WARNINGS else "error"
    assert findings[first].status == expected
    assert says in text_of(findings[first])
    if first != "static.kind":
        assert set(bad(findings)) == set(checks.split())
        assert not skipped


def test_description_of_a_model_exchange_fmu_is_checked(make: Make, found: Find) -> None:
    xml = XML.replace("<CoSimulation ", "<ModelExchange ").replace('name="torque"', 'name="gain"')
    findings = found(make(xml=xml))

    assert findings["static.names"].status == "error"
    assert findings["static.platforms"].status == findings["static.functions"].status == "skipped"


@pytest.mark.parametrize("name", ["a", "der(a.b[1])", "der(x,2)", "a.'b c'[1,2].d", "_x1", "'\\n'"])
def test_structured_names_are_accepted(make: Make, found: Find, name: str) -> None:
    findings = found(make(xml=XML.replace('"attitude[2]"', f'"{name}"')))

    assert findings["static.names"].status == "pass"


@pytest.mark.parametrize("name", ["1a", "a[i]", "a..b", "a b", "a[1", "der(a", "a.", "é"])
def test_unstructured_names_are_reported(make: Make, found: Find, name: str) -> None:
    findings = found(make(xml=XML.replace('"attitude[2]"', f'"{name}"')))

    assert findings["static.names"].status == "error"


def test_flat_names_are_accepted_where_declared(make: Make, found: Find) -> None:
    xml = XML.replace('variableNamingConvention="structured"', "").replace('"attitude[2]"', '"the second attitude"')
    findings = found(make(xml=xml))

    assert findings["static.names"].status == "info"  # attitude[1] looks like an array, which flat names do not make


@pytest.mark.parametrize("xml", ["", "<a", "<?xml version='1.0'?><fmi/>", "\0", XML[:900]])
def test_unreadable_description_is_a_finding(make: Make, found: Find, xml: str) -> None:
    findings = found(make(xml=xml))

    assert findings["static.kind"].status == "error"
    assert findings["static.archive"].status == "pass"
    assert "static.schema" in bad(findings)


def test_entities_are_not_expanded(make: Make, found: Find) -> None:
    bomb = '<!DOCTYPE x [<!ENTITY a "aaaaaaaa"><!ENTITY b SYSTEM "file:///etc/passwd">]>'
    xml = XML.replace("?>\n", f"?>\n{bomb}\n", 1).replace("measured", "&b;&a;", 1)
    findings = found(make(xml=xml))

    assert "root:" not in "".join(text_of(finding) for finding in findings.values())


@pytest.mark.parametrize("value", ["", "INF", "nan", "x", "\u00b2", "-1", "9" * 30])
@pytest.mark.parametrize("attribute", ['kg="1"', 'index="5"', 'factor="57.29577951308232"', 'stepSize="0.01"'])
def test_bad_number_is_a_finding(make: Make, found: Find, attribute: str, value: str) -> None:
    name = attribute.partition("=")[0]
    findings = found(make(xml=XML.replace(attribute, f'{name}="{value}"', 1)))

    assert bad(findings)
    assert findings["static.kind"].status == "pass"
