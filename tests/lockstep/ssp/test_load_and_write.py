"""System files: what is written validates, what is read back is the same, what is wrong is refused by name."""

import zipfile
from dataclasses import replace
from pathlib import Path

import fmpy
import pytest
from lxml import etree

from lockstep import Component, Connection, InputError, System, Unit, load_system, write_ssd
from lockstep.system.transformation import Table

MS = 1_000_000
SCHEMA = Path(fmpy.__file__).parent / "ssp" / "schema" / "SystemStructureDescription.xsd"


def without_file(system):
    """Leave out what a system knows of the file it came from, and the connectors that writing filled in."""
    parts = tuple(
        replace(c, connectors=None, parameters=dict(c.parameters), units=dict(c.units)) for c in system.components
    )
    return replace(system, path=None, sha256=None, components=parts)


@pytest.fixture
def rich(loop):
    """Return a system that uses every field."""
    celsius = Unit(name="degC", exponents=(0, 0, 0, 0, 1, 0, 0, 0), offset=273.15)
    counter, echo, plant = loop.components
    values = {"gain": 0.1, "fail_at": -1}
    return replace(
        loop,
        components=(replace(counter, parameters=values, units={"gain": celsius}), replace(echo, offset=2 * MS), plant),
        connections=(
            replace(loop.connections[0], factor=2.5, offset=-1.0, convert_units=False),
            replace(loop.connections[1], table=Table(kind="Boolean", entries=((True, False), (False, True)))),
            replace(loop.connections[2], table=Table(kind="Integer", entries=((1, -1), (2, 7)))),
            loop.connections[3],
        ),
        record=("plant.*", "echo.y[1]"),
        record_period=2 * MS,
        tick=500_000,
    )


def test_a_written_file_reads_back_the_same_and_is_valid_ssp(rich, tmp_path):
    path = tmp_path / "some where ä.ssd"
    write_ssd(rich, path)
    etree.XMLSchema(etree.parse(SCHEMA)).assertValid(etree.parse(path))
    assert without_file(load_system(path)) == without_file(rich)


def test_a_value_is_written_in_the_type_that_the_fmu_declares(loop, tmp_path):
    counter = replace(loop.components[0], parameters={"gain": 2, "fail_at": "7"})
    write_ssd(replace(loop, components=(counter, *loop.components[1:])), tmp_path / "s.ssd")
    text = (tmp_path / "s.ssd").read_text()
    assert '<ssv:Real value="2.0"/>' in text
    assert '<ssv:Integer value="7"/>' in text
    wrong = replace(counter, parameters={"gian": 2})
    with pytest.raises(InputError, match=r"counter\.gian: no such parameter; .*did you mean gain"):
        write_ssd(replace(loop, components=(wrong, *loop.components[1:])), tmp_path / "s.ssd")


def test_sources_are_relative_and_escaped(loop, tmp_path):
    folder = tmp_path / "fmus of ä"
    folder.mkdir()
    fmu = folder / "a b.fmu"
    fmu.write_bytes(loop.components[0].source.read_bytes())
    system = System(name="s", tick=MS, components=(Component(name="a", source=fmu, period=MS, kind="sampled"),))
    write_ssd(system, tmp_path / "s.ssd")
    assert 'source="fmus%20of%20%C3%A4/a%20b.fmu"' in (tmp_path / "s.ssd").read_text()
    assert load_system(tmp_path / "s.ssd").components[0].source == fmu.resolve()


def test_a_folder_and_an_archive_are_read_like_a_file(loop, tmp_path):
    folder = tmp_path / "unpacked"
    (folder / "resources").mkdir(parents=True)
    parts = []
    for component in loop.components:
        fmu = folder / "resources" / component.source.name
        fmu.write_bytes(component.source.read_bytes())
        parts.append(replace(component, source=fmu))
    write_ssd(replace(loop, components=tuple(parts)), folder / "SystemStructure.ssd")
    archive = tmp_path / "packed.ssp"
    with zipfile.ZipFile(archive, "w") as packed:
        for file in folder.rglob("*"):
            packed.write(file, file.relative_to(folder))
    unpacked, packed = load_system(folder), load_system(archive)
    assert unpacked.connections == packed.connections == loop.connections
    assert packed.components[1].archive == archive
    assert packed.components[1].source == Path("resources/toy_echo.fmu")


@pytest.mark.parametrize("member", ["../evil.txt", "/etc/evil.txt", "a/../../evil.txt", "c:evil.txt"])
def test_an_archive_that_leaves_its_folder_is_refused(loop_ssd, tmp_path, member):
    archive = tmp_path / "slip.ssp"
    with zipfile.ZipFile(archive, "w") as packed:
        packed.write(loop_ssd, "SystemStructure.ssd")
        packed.writestr(member, "evil")
    with pytest.raises(InputError, match=r"slip\.ssp: holds the unsafe path"):
        load_system(archive)


def test_a_source_outside_the_archive_is_refused(loop_ssd, tmp_path):
    archive = tmp_path / "out.ssp"
    with zipfile.ZipFile(archive, "w") as packed:
        packed.write(loop_ssd, "SystemStructure.ssd")
    with pytest.raises(InputError, match=r"counter: source .* lies outside out\.ssp"):
        load_system(archive)


def edited(path, old, new):
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1))
    return path


REFUSALS = [
    ("</ssd:System>", "", "not readable XML"),
    ('kind="output"', 'kind="outlet"', r"line \d+: not valid SSP 1\.0: .*outlet"),
    ('tick="0.001"', 'tick="1e-10"', r"tick: 1e-10 s is not a whole number of nanoseconds"),
    ('tick="0.001"', 'tick="fast"', r"tick: 'fast' is not a number of seconds"),
    ('tick="0.001"', 'tick="0.001" ticks="2"', r"the system: annotation ticks: no such attribute; there are tick"),
    ('period="0.001" ', 'period="0" ', r"counter: period 0: must be > 0 s"),
    ('kind="sampled"', 'kind="sample"', r"counter: kind 'sample' must be sampled or continuous"),
    ('delay="2"', 'delay="-2"', r"counter\.count -> plant\.u: delay '-2' must be a whole number of ticks >= 0"),
    ('endElement="echo"', 'endElement="ecko"', r"ecko: no such component; .*did you mean echo\?"),
    (
        'endConnector="u[1]"',
        'endConnector="u[3]"',
        r"-> echo\.u\[3\]: echo declares no connector u\[3\]; it declares u\[1\]",
    ),
    ('endConnector="number"', 'endConnector="u[1]"', r"u\[1\]: the input is already connected to counter\.count"),
    ('startTime="0"', 'startTime="1e-10"', r"startTime: 1e-10 s is not a whole number of nanoseconds"),
    (
        'type="application/x-fmu-sharedlibrary"',
        'type="application/x-vendor"',
        r"counter: type application/x-vendor is not supported; use .*, .* or ",
    ),
    ('source="', 'source="https://example.org/', r"counter: source https://.* is not a file"),
    ("<ssd:ParameterBinding>", '<ssd:ParameterBinding source="no.ssv">', r"echo: .* has both source and ParameterVal"),
    ('name="x0"', 'name="x0"/><ssv:Parameter name="x0"', "not valid SSP"),
    ('<ssv:Real value="7.0"/>', '<ssv:Binary value="07"/>', r"echo\.u\[2\]: type Binary is not supported"),
    (
        'version="1.0" name="loop"',
        'version="3.0" name="loop"',
        r"version '3\.0' is not supported; write it as SSP 1\.0 or 2\.0",
    ),
    ('name="echo"', 'name="counter"', r"the system: element counter: declared twice"),
    ('name="u[1]" kind', 'name="flag" kind', r"echo: connector flag: declared twice"),
    ('source="', 'source="a%00.fmu" description="', r"counter: source 'a%00\.fmu' names no file"),
    ('source="', 'source="http://[1" description="', r"'http://\[1' is not a valid value of the atomic type"),
    ('source="', 'source="" description="', r"counter: source '' names no file"),
]


@pytest.mark.parametrize(("old", "new", "message"), REFUSALS)
def test_bad_file_is_refused_in_one_line(loop_ssd, old, new, message):
    with pytest.raises(InputError, match=message) as caught:
        load_system(edited(loop_ssd, old, new))
    assert "\n" not in str(caught.value)


def test_a_missing_file_and_a_broken_archive_are_refused(tmp_path):
    with pytest.raises(InputError, match=r"none\.ssd: no such file; give a system"):
        load_system(tmp_path / "none.ssd")
    (tmp_path / "broken.ssp").write_bytes(b"PK no zip")
    with pytest.raises(InputError, match=r"broken\.ssp: not a readable zip file"):
        load_system(tmp_path / "broken.ssp")
    with pytest.raises(InputError, match=r"SystemStructure\.ssd"):
        load_system(tmp_path)


SSV = """<?xml version="1.0"?>
<ssv:ParameterSet xmlns:ssv="http://ssp-standard.org/SSP1/SystemStructureParameterValues"
  xmlns:ssc="http://ssp-standard.org/SSP1/SystemStructureCommon" version="1.0" name="p">
  <ssv:Parameters>
    <ssv:Parameter name="u[2]"><ssv:Real value="3.5" unit="mm"/></ssv:Parameter>
    <ssv:Parameter name="flag"><ssv:Boolean value="1"/></ssv:Parameter>
  </ssv:Parameters>
  <ssv:Units><ssc:Unit name="mm"><ssc:BaseUnit m="1" factor="0.001"/></ssc:Unit></ssv:Units>
</ssv:ParameterSet>"""


def test_parameters_come_from_a_file_next_to_the_system(loop_ssd):
    (loop_ssd.parent / "p.ssv").write_text(SSV)
    text = loop_ssd.read_text()
    start, end = text.index("<ssd:ParameterBinding>"), text.index("</ssd:ParameterBinding>")
    text = text[:start] + '<ssd:ParameterBinding source="p.ssv"/>' + text[end + len("</ssd:ParameterBinding>") :]
    loop_ssd.write_text(text)
    echo = load_system(loop_ssd).component("echo")
    assert echo.parameters == {"u[2]": 3.5, "flag": True}
    assert echo.units["u[2]"] == Unit(name="mm", exponents=(0, 1, 0, 0, 0, 0, 0, 0), factor=0.001)


def test_parameters_of_the_system_reach_their_component(loop_ssd):
    values = SSV.replace('<?xml version="1.0"?>', "").replace('name="u[2]"', 'name="plant.x0"')
    values = values.replace('name="flag"', 'name="echo.flag"')
    binding = f"<ssd:ParameterBinding><ssd:ParameterValues>{values}</ssd:ParameterValues></ssd:ParameterBinding>"
    edited(loop_ssd, "<ssd:Elements>", f"<ssd:ParameterBindings>{binding}</ssd:ParameterBindings><ssd:Elements>")
    system = load_system(loop_ssd)
    assert system.component("echo").parameters == {"u[2]": 7.0, "flag": True}
    # SSP: "bindings at a system level take precedence over bindings at a sub-system or component level"
    assert system.component("plant").parameters == {"x0": 3.5}
    edited(loop_ssd, 'name="echo.flag"', 'name="ecko.flag"')
    with pytest.raises(InputError, match=r"ecko\.flag: no component ecko; .*did you mean echo\?"):
        load_system(loop_ssd)


def test_an_entity_is_not_expanded(loop_ssd):
    text = loop_ssd.read_text().split("\n", 1)[1]
    loop_ssd.write_text(
        f'<!DOCTYPE x [<!ENTITY e SYSTEM "file:///etc/hostname">]>\n{text}'.replace('name="loop"', 'name="&e;"')
    )
    with pytest.raises(InputError):
        load_system(loop_ssd)


def test_delays_and_periods_can_be_changed(loop):
    changed = loop.with_delay("counter", "echo", 4).with_period("echo", 10 * MS)
    assert [c.delay for c in changed.connections] == [4, 4, 4, 2]
    assert changed.component("echo").period == 10 * MS
    with pytest.raises(InputError, match="echo -> plant: no such connection"):
        loop.with_delay("echo", "plant", 1)
    with pytest.raises(InputError, match=r"plan: no such component.*did you mean plant"):
        loop.with_period("plan", MS)


def test_bad_connection_or_component_is_refused(loop):
    with pytest.raises(InputError, match=r"a\.y -> b\.u: delay -1 must be >= 0 ticks"):
        Connection(from_component="a", output="y", to_component="b", input="u", delay=-1)
    with pytest.raises(InputError, match="must not be empty nor hold a dot"):
        replace(loop.components[0], name="a.b")
    with pytest.raises(InputError, match="component counter is there twice"):
        replace(loop, components=(*loop.components, loop.components[0]))
