"""The closed loop as another tool would write it: sensors and controller in a system of their own, no annotations.

The same FMUs step in the same order with the same values, so that every bit of the run is the same.
"""

import json
import zipfile

from lxml import etree

SSD = "http://ssp-standard.org/SSP1/SystemStructureDescription"
NS = {"ssd": SSD}
INNER = ("sensors", "controller")
RUN = """
from lockstep import load_system, read_signals, simulate
from lockstep.ssp.step_times import Timing
path, folder, kinds = given
system = load_system(path, Timing(kinds=json.loads(kinds)))
simulate(system, folder, stop_time=0.1, record=["all"], record_period=0.001)
result = {name: values.tolist() for name, values in read_signals(folder).columns.items()}
"""


def nested(root):
    """Move sensors and controller of our SSD into a system `aocs`, and all connections to them to its connectors."""
    for annotations in root.xpath("//ssd:Annotations", namespaces=NS):
        annotations.getparent().remove(annotations)
    elements, wires = (root.find(f"ssd:System/ssd:{name}", NS) for name in ("Elements", "Connections"))
    aocs = etree.SubElement(elements, f"{{{SSD}}}System", name="aocs")
    ports, parts, inner = (etree.SubElement(aocs, f"{{{SSD}}}{n}") for n in ("Connectors", "Elements", "Connections"))
    parts.extend([c for c in elements.findall("ssd:Component", NS) if c.get("name") in INNER])
    declared = set()
    for wire in list(wires):
        start, end = ((wire.get(f"{side}Element"), wire.get(f"{side}Connector")) for side in ("start", "end"))
        if start[0] in INNER and end[0] in INNER:
            inner.append(wire)
            continue
        kind = "output" if start[0] in INNER else "input"
        side, element = ("start", start) if kind == "output" else ("end", end)
        port = f"{element[0]}.{element[1]}"
        if port not in declared:
            declared.add(port)
            etree.SubElement(ports, f"{{{SSD}}}Connector", name=port, kind=kind)
            # from the connector to the element, although values go the other way: the kinds give the direction
            ends = {"startConnector": port, "endElement": element[0], "endConnector": element[1]}
            etree.SubElement(inner, f"{{{SSD}}}Connection", attrib=ends)
        wire.set(f"{side}Element", "aocs")
        wire.set(f"{side}Connector", port)
    return root


def test_our_loop_written_by_another_tool_runs_bitwise_the_same(tmp_path, fmus, python):
    original = fmus / "centralised" / "closed" / "fine_pointing.ssd"
    package = tmp_path / "foreign.ssp"
    with zipfile.ZipFile(original.with_suffix(".ssp")) as source, zipfile.ZipFile(package, "w") as target:
        for member in source.namelist():
            content = source.read(member)
            if member == "SystemStructure.ssd":
                content = etree.tostring(nested(etree.fromstring(content)))
            target.writestr(member, content)
    kinds = {f"aocs/{name}": "sampled" for name in INNER}  # their outputs are declared continuous, as FMI's default is
    before = python(f"import json\n{RUN}", original, tmp_path / "original", "{}")
    after = python(f"import json\n{RUN}", package, tmp_path / "foreign", json.dumps(kinds))
    assert len(before) > 200
    assert max(map(abs, before["controller.wheel.torque[1]"])) > 1e-3
    renamed = {("aocs/" if name.startswith(INNER) else "") + name: values for name, values in before.items()}
    assert after == renamed


def test_the_command_shows_and_draws_it(tmp_path, fmus, flexsat):
    folder = tmp_path / "foreign"
    with zipfile.ZipFile(fmus / "centralised" / "closed" / "fine_pointing.ssp") as source:
        source.extractall(folder)
    description = folder / "SystemStructure.ssd"
    description.write_bytes(etree.tostring(nested(etree.fromstring(description.read_bytes()))))
    done = flexsat("timeline", folder, "--ticks", "2", "--svg", tmp_path / "t.svg", "--sampled", "aocs/controller")
    assert (done.returncode, done.stderr) == (0, "")
    assert "aocs/controller  reads 52 from aocs/sensors" in done.stdout
    assert "aocs/controller" in (tmp_path / "t.svg").read_text()
    wrong = flexsat("run", folder, "--step-size", "controller=0.01", "--out", tmp_path / "no")
    assert wrong.returncode == 2
    assert wrong.stderr == (
        "flexsat: --step-size controller=0.01: controller: no such component; "
        "there are plant, aocs/sensors, aocs/controller; did you mean aocs/controller?\n"
    )
