"""Terminals: named groups of ports, so that a tool can connect two components group by group.

FMI 3.0, section 2.4.9 (terminals and icons); FMI 2.0.4 takes the same file over as it is.
"""

from __future__ import annotations

from dataclasses import dataclass
from xml.etree.ElementTree import Element, SubElement

from ...ports.plant import JITTER
from ...ports.sensors import MEASUREMENTS, TRUTH
from ...ports.table import FmiVersion, Port, PortTable
from .xml_text import xml_bytes

FORMAT = "3.0"  # of the file, whatever the version of the FMU
ICON_SIZE = 100.0  # of the coordinate system; an icon fills it
MILLIMETRES = 0.2  # a unit of the coordinate system


@dataclass(frozen=True, slots=True, kw_only=True)
class Terminal:
    """A group of ports. `plug` means: the other side has the same members; `bus`: those that both have."""

    name: str
    description: str
    matching: str
    ports: tuple[str, ...]


# In the order of drawing. A component has those whose ports it has, all of them.
TERMINALS = (
    Terminal(name="wheels", description="torque of every wheel, from the controller to the plant", matching="plug",
             ports=("wheel.torque",)),
    Terminal(name="jitter", description="jitter of the wheels on their mounts, from the sensors to the plant",
             matching="plug", ports=JITTER),
    Terminal(name="truth", description="what the sensors sense, from the plant to the sensors", matching="plug",
             ports=TRUTH),
    Terminal(name="measurements", description="measurements, from the sensors to the controller",
             matching="plug", ports=MEASUREMENTS),
    Terminal(name="external", description="external force and torque on the spacecraft", matching="bus",
             ports=("external.force", "external.torque")),
    Terminal(name="command", description="slew command to the controller", matching="bus",
             ports=("command.rotation", "command.start_time")),
    Terminal(name="applied", description="torque of the controller in command, to a controller in shadow",
             matching="bus", ports=("applied.wheel.torque", "applied.valid")),
    Terminal(name="motion", description="motion and deformation of the plant, for recording", matching="bus",
             ports=("attitude.mrp", "rate", "velocity", "modal.displacement", "modal.velocity", "rms_deformation",
                    "angular_momentum", "energy")),
    Terminal(name="reference", description="reference of the slew, for recording", matching="bus",
             ports=("reference.mrp", "reference.modal.displacement", "reference.rate", "reference.modal.velocity",
                    "reference.wheel.speed", "reference.torque")),
    Terminal(name="estimate", description="estimate of the filter, for recording", matching="bus",
             ports=("estimate.mrp", "estimate.modal.displacement", "estimate.rate", "estimate.modal.velocity",
                    "estimate.wheel.speed")),
)  # fmt: skip


def terminals_of(table: PortTable) -> tuple[Terminal, ...]:
    """Return the terminals whose ports a component has."""
    names = {port.name for port in table if port.causality != "parameter"}
    return tuple(terminal for terminal in TERMINALS if names.issuperset(terminal.ports))


def terminals_xml(table: PortTable, fmi: FmiVersion = "2.0") -> bytes:
    """Return terminalsAndIcons.xml. Members are named in the structured way, so that flat and structured FMUs match.

    In FMI 3.0 a member is a whole port: terminals of FMUs of the same version match.
    """
    root = Element("fmiTerminalsAndIcons", {"fmiVersion": FORMAT})
    graphics = SubElement(root, "GraphicalRepresentation")
    corners = {"x1": str(-ICON_SIZE), "y1": str(-ICON_SIZE), "x2": str(ICON_SIZE), "y2": str(ICON_SIZE)}
    SubElement(graphics, "CoordinateSystem", {**corners, "suggestedScalingFactorTo_mm": str(MILLIMETRES)})
    SubElement(graphics, "Icon", corners)
    group = SubElement(root, "Terminals")
    for terminal in terminals_of(table):
        what = {"name": terminal.name, "matchingRule": terminal.matching, "description": terminal.description}
        element = SubElement(group, "Terminal", what)
        for name in terminal.ports:
            for member in _members(table[name], table, fmi):
                SubElement(element, "TerminalMemberVariable", member)
    return xml_bytes(root)


def _members(port: Port, table: PortTable, fmi: FmiVersion) -> list[dict[str, str]]:
    if fmi == "3.0":
        return [{"variableName": port.name, "memberName": port.name, "variableKind": "signal"}]
    return [
        {
            "variableName": port.scalar_name(i, table.naming),
            "memberName": port.scalar_name(i),
            "variableKind": "signal",
        }
        for i in range(port.length)
    ]
