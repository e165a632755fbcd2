"""Write system structure descriptions as other tools do: no `lockstep` annotations, connectors of systems, mappings."""

import os
import zipfile
from dataclasses import replace
from multiprocessing import Pipe
from pathlib import Path
from urllib.parse import quote

import pytest

from lockstep import load_system, read_signals, simulate
from lockstep.ssp.step_times import Timing

EACH_MS = Timing(period=1_000_000)  # ns

SSP = "http://ssp-standard.org/SSP1/SystemStructure"
SPACES = " ".join(
    f'xmlns:{short}="{SSP}{name}"'
    for short, name in (
        ("ssd", "Description"),
        ("ssc", "Common"),
        ("ssv", "ParameterValues"),
        ("ssm", "ParameterMapping"),
        ("ssb", "SignalDictionary"),
    )
)
UNITS = """<ssd:Units>
  <ssc:Unit name="rad"><ssc:BaseUnit rad="1"/></ssc:Unit>
  <ssc:Unit name="deg"><ssc:BaseUnit rad="1" factor="0.017453292519943295"/></ssc:Unit>
  <ssc:Unit name="K"><ssc:BaseUnit K="1"/></ssc:Unit>
  <ssc:Unit name="degC"><ssc:BaseUnit K="1" offset="273.15"/></ssc:Unit>
</ssd:Units>"""


class Text:
    """Pieces of an SSD. Connectors are texts such as `u[1] input Real unit=deg`; ends are `element.port` or `.port`."""

    def connectors(self, *texts):
        return "<ssd:Connectors>" + "".join(self._connector(*text.split()) for text in texts) + "</ssd:Connectors>"

    def _connector(self, name, kind, type_="Real", *attributes):
        more = "".join(f' {key}="{value}"' for key, value in (a.split("=") for a in attributes))
        return f'<ssd:Connector name="{name}" kind="{kind}"><ssc:{type_}{more}/></ssd:Connector>'

    def component(self, name, source, *connectors, inner="", **attributes):
        more = "".join(f' {key}="{value}"' for key, value in attributes.items())
        ports = self.connectors(*connectors) if connectors else ""
        return f'<ssd:Component name="{name}" source="{quote(str(source))}"{more}>{ports}{inner}</ssd:Component>'

    def system(self, name, elements, connections="", connectors=(), bindings="", id_=None):
        ports = self.connectors(*connectors) if connectors else ""
        wires = f"<ssd:Connections>{connections}</ssd:Connections>" if connections else ""
        elements = f"<ssd:Elements>{elements}</ssd:Elements>" if elements else ""
        more = f' id="{id_}"' if id_ else ""
        return f'<ssd:System name="{name}"{more}>{ports}{bindings}{elements}{wires}</ssd:System>'

    def dictionary(self, *entries):
        """Return a signal dictionary; entries are texts such as `angle Real unit=rad`."""
        found = ""
        for name, type_, *attributes in (entry.split() for entry in entries):
            more = "".join(f' {key}="{value}"' for key, value in (a.split("=") for a in attributes))
            found += f'<ssb:DictionaryEntry name="{name}"><ssc:{type_}{more}/></ssb:DictionaryEntry>'
        units = UNITS.replace("ssd:", "ssb:")
        return f'<ssb:SignalDictionary {SPACES} version="1.0">{found}{units}</ssb:SignalDictionary>'

    def reference(self, name, dictionary, *connectors):
        ports = self.connectors(*connectors)
        tag = "ssd:SignalDictionaryReference"
        return f'<{tag} name="{name}" dictionary="{dictionary}">{ports}</{tag}>'

    def connection(self, start, end, inner="", **attributes):
        ends = ""
        for which, text in (("start", start), ("end", end)):
            element, _, port = text.rpartition("/") if "/" in text else text.partition(".")
            ends += f' {which}Element="{element}"' if element else ""
            ends += f' {which}Connector="{port}"'
        more = "".join(f' {key}="{value}"' for key, value in attributes.items())
        return f"<ssd:Connection{ends}{more}>{inner}</ssd:Connection>"

    def linear(self, factor, offset=0.0):
        return f'<ssc:LinearTransformation factor="{factor}" offset="{offset}"/>'

    def mapping(self, kind, *pairs):
        entries = "".join(f'<ssc:MapEntry source="{a}" target="{b}"/>' for a, b in pairs)
        return f"<ssc:{kind}MappingTransformation>{entries}</ssc:{kind}MappingTransformation>"

    def values(self, *parameters, units=UNITS):
        """Return a parameter set of (name, type, value) or (name, type, value, unit)."""
        entries = ""
        for name, type_, value, *unit in parameters:
            more = f' unit="{unit[0]}"' if unit else ""
            entries += f'<ssv:Parameter name="{name}"><ssv:{type_} value="{value}"{more}/></ssv:Parameter>'
        units = units.replace("ssd:", "ssv:")
        head = f'<ssv:ParameterSet {SPACES} version="1.0" name="p">'
        return f"{head}<ssv:Parameters>{entries}</ssv:Parameters>{units}</ssv:ParameterSet>"

    def map(self, *entries):
        """Return a parameter mapping of (source, target) or (source, target, transformation, attributes)."""
        found = ""
        for source, target, *rest in entries:
            inner, more = (*rest, "", "")[:2]
            found += f'<ssm:MappingEntry source="{source}" target="{target}" {more}>{inner}</ssm:MappingEntry>'
        return f'<ssm:ParameterMapping {SPACES} version="1.0">{found}</ssm:ParameterMapping>'

    def bindings(self, *texts):
        return f"<ssd:ParameterBindings>{''.join(texts)}</ssd:ParameterBindings>"

    def binding(self, values="", mapping="", **attributes):
        more = "".join(f' {key}="{value}"' for key, value in attributes.items())
        inline = f"<ssd:ParameterValues>{values}</ssd:ParameterValues>" if values else ""
        inline += f"<ssd:ParameterMapping>{mapping}</ssd:ParameterMapping>" if mapping else ""
        return f"<ssd:ParameterBinding{more}>{inline}</ssd:ParameterBinding>"

    def document(self, system, stop=0.01, enumerations="", units=UNITS):
        experiment = f'<ssd:DefaultExperiment startTime="0" stopTime="{stop}"/>'
        head = f'<ssd:SystemStructureDescription {SPACES} version="1.0" name="foreign">'
        return f"{head}{system}{enumerations}{units}{experiment}</ssd:SystemStructureDescription>"


@pytest.fixture(scope="session")
def ssd() -> Text:
    """Return what makes the pieces of a description."""
    return Text()


MODES = """<TypeDefinitions><SimpleType name="Mode"><Enumeration>
  <Item name="off" value="1"/><Item name="coarse" value="2"/><Item name="fine" value="4"/>
</Enumeration></SimpleType></TypeDefinitions>"""


@pytest.fixture(scope="session")
def fmus(toys: Path, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Return the toy FMUs by name; `modes` is the echo with Enumerations in the place of its Integers."""
    modes = tmp_path_factory.mktemp("modes") / "modes.fmu"
    with zipfile.ZipFile(toys / "toy_echo.fmu") as source, zipfile.ZipFile(modes, "w") as target:
        for member in source.infolist():
            content = source.read(member)
            if member.filename == "modelDescription.xml":
                text = content.decode().replace("<Integer", '<Enumeration declaredType="Mode"')
                content = text.replace("<LogCategories>", f"{MODES}<LogCategories>").encode()
            target.writestr(member, content)
    return {path.stem.removeprefix("toy_"): path for path in (*toys.glob("*.fmu"), modes)}


@pytest.fixture
def load(tmp_path, ssd):
    """Return a function that reads a system without annotations, stepped every millisecond."""

    def load_text(system, timing=EACH_MS, **options):
        path = tmp_path / "foreign.ssd"
        path.write_text(ssd.document(system, **options))
        return load_system(path, timing)

    return load_text


@pytest.fixture
def run(tmp_path):
    """Return a function that simulates a system and returns its signals by name.

    It does so in a fork of this process: all FMUs of a system share it, which is quick, and several copies of one
    toy, which pythonfmu's wrapper may leave damaged, harm nobody.
    """

    def run_in_fork(system, **options):
        parts = tuple(replace(c, isolated=False) for c in system.components)
        folder = tmp_path / f"run{len(list(tmp_path.glob('run*')))}"
        here, there = Pipe()
        child = os.fork()
        if child == 0:
            try:
                simulate(replace(system, components=parts), folder, record=("all",), **options)
                there.send(None)
            except BaseException as error:
                there.send(error)
            finally:
                os._exit(0)
        there.close()
        failure = here.recv()  # EOFError if the child was killed
        os.waitpid(child, 0)
        if failure is not None:
            raise failure
        return read_signals(folder).columns

    return run_in_fork


@pytest.fixture(scope="session")
def pack():
    """Return a function that writes an archive."""

    def write(path, entries):
        with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
            for name, content in entries.items():
                archive.writestr(name, content)
        return path

    return write
