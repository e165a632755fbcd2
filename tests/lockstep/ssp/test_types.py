"""Connectors of every type of SSP between FMUs of FMI 1.0, 2.0 and 3.0, through a system in between."""

import pytest

from lockstep import InputError
from lockstep.fmi.model_description import read_description
from lockstep.ssp.step_times import Timing

VALUES = {  # as written, and as recorded
    "Real": ("2.5", 2.5),
    "Integer": ("-7", -7),
    "Boolean": ("true", True),
    "String": ("Größe 1", "Größe 1"),
    "Enumeration": ("fine", 7),
}
MODE = """<ssd:Enumerations><ssc:Enumeration name="Mode"><ssc:Item name="off" value="0"/>
  <ssc:Item name="coarse" value="{}"/><ssc:Item name="fine" value="7"/></ssc:Enumeration>
  <ssc:Enumeration name="Old"><ssc:Item name="off" value="1"/><ssc:Item name="coarse" value="2"/>
  <ssc:Item name="fine" value="3"/></ssc:Enumeration></ssd:Enumerations>"""  # FMI 1.0 counts from 1


def port(type_, version):
    """Return how the feedthrough names what it puts through."""
    return {"Real": "Float64", "Integer": "Int32"}.get(type_, type_) if version == "3.0" else type_


def connectors(version, end):
    more = {"Enumeration": " name=Old" if version == "1.0" else " name=Mode"}
    return [f"{port(type_, version)}_{end} {end}put {type_}{more.get(type_, '')}" for type_ in VALUES]


@pytest.fixture
def chain(load, ssd, reference_fmu):
    """Return a function that reads two feedthroughs in a row, the second one in a system."""

    def read(first, second, coarse=3, mapping=""):
        one = ssd.component("one", reference_fmu("feedthrough", first), *connectors(first, "out"))
        two = ssd.component("two", reference_fmu("feedthrough", second), *connectors(second, "in"))
        names = [(f"{port(type_, first)}_out", f"{port(type_, second)}_in") for type_ in VALUES]
        inner = "".join(ssd.connection(f".{name}", f"two.{name}") for _, name in names)
        sub = ssd.system("sub", two, inner, connectors(second, "in"))
        wires = "".join(
            ssd.connection(f"one.{start}", f"sub.{end}", mapping if start == "Enumeration_out" else "")
            for start, end in names
        )
        values = ssd.values(*((f"one.{port(t, first)}_in", t, text) for t, (text, _) in VALUES.items()))
        top = ssd.system("top", one + sub, wires, bindings=ssd.bindings(ssd.binding(values)))
        return load(top, Timing(period=10_000_000), stop=0.03, enumerations=MODE.format(coarse))

    return read


@pytest.mark.parametrize(("first", "second"), [("1.0", "2.0"), ("2.0", "3.0"), ("3.0", "2.0")])
def test_every_type_is_exchanged_between_versions_of_fmi(chain, run, ssd, first, second):
    same = ssd.mapping("Enumeration", *((item, item) for item in ("off", "coarse", "fine")))
    system = chain(first, second, mapping=same if first == "1.0" else "")
    loose = {}
    for component in system.components:
        fed = {c.input for c in system.connections if c.to_component == component.name} | set(component.parameters)
        for variable in read_description(component).variables.values():
            if variable.causality == "input" and variable.name not in fed:
                loose[f"{component.name}.{variable.name}"] = variable.start or ""
    signals = run(system, overrides=loose)
    for type_, (_, value) in VALUES.items():
        assert signals[f"sub/two.{port(type_, second)}_out"][-1] == value, type_


def test_enumeration_with_other_numbers_is_refused(chain, run):
    message = r"one\.Enumeration_out: the file numbers the items of its Enumeration differently from the FMU"
    with pytest.raises(InputError, match=message):
        run(chain("2.0", "2.0", coarse=4))


def test_enumerations_with_other_items_are_not_connected_by_number(chain, run):
    message = (
        r"one\.Enumeration_out -> sub/two\.Enumeration_in: connects Enumerations of off = 1, coarse = 2, fine = 3 "
        r"and of off = 0, coarse = 3, fine = 7; an EnumerationMappingTransformation has to map them"
    )
    with pytest.raises(InputError, match=message):
        run(chain("1.0", "2.0"))
