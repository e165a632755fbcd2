"""What a model description declares in every version of FMI: names, units, enumerations, ranges, times, feedthrough."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from xml.etree import ElementTree as ET

from lockstep.bundle.contents import Contents
from lockstep.bundle.ports import Port
from lockstep.fmi.declared_units import DisplayUnit
from lockstep.system.clock import seconds, seconds_text
from lockstep.system.units import BASES, Unit

_IDENTIFIER = r"[A-Za-z_]\w*(\[\d+(,\d+)*\])?"
_STRUCTURED = re.compile(rf"{_IDENTIFIER}(\.{_IDENTIFIER})*", re.ASCII)
TRUE, FALSE = "true", "false"
LOG_CATEGORIES = ("logStatusError", "logStatusDiscard")
Items = tuple[tuple[str, int], ...]  # of an enumeration


def identifier(name: str) -> str:
    """Return the name of a system as an identifier of C, which names the library."""
    text = re.sub(r"\W+", "_", name, flags=re.ASCII).strip("_")
    return text if text and not text[0].isdigit() else f"system_{text}".rstrip("_")


def naming(names: Iterable[str]) -> str:
    """Return FMI's name of the convention that names follow."""
    return "structured" if all(map(_STRUCTURED.fullmatch, names)) else "flat"


def summary(contents: Contents) -> str:
    """Return the description of a bundle."""
    names = [component.name for component in contents.system.components]
    step = seconds_text(contents.system.tick * contents.step_ticks)
    return f"System of {len(names)} FMUs ({', '.join(names)}); its steps are multiples of {step} s"


def capabilities(contents: Contents) -> dict[str, str]:
    """Return what every component has, by the name of FMI 3.0; that of FMI 2.0 may differ."""
    inner = [contents.descriptions[component.name] for component in contents.system.components]
    flags = {
        "needsExecutionTool": any(one.needs_tool for one in inner),
        "canBeInstantiatedOnlyOncePerProcess": any(one.once_per_process for one in inner),
        "canGetAndSetFMUState": all(one.keeps_state for one in inner),
        "canSerializeFMUState": all(one.saves_state for one in inner),
        "canHandleVariableCommunicationStepSize": False,
    }
    return {name: TRUE if value else FALSE for name, value in flags.items()}


def unit_names(ports: Iterable[Port]) -> tuple[dict[str, Unit], dict[str, str]]:
    """Return units by the names that they have in the bundle, and the names by port.

    Units of one name that differ get the name of the component too.
    """
    units: dict[str, Unit] = {}
    names: dict[str, str] = {}
    for port in ports:
        unit = port.unit
        if unit is None or not unit.name or port.variable.type != "Real":
            continue
        name = unit.name
        if units.setdefault(name, unit) != unit:
            name = f"{unit.name} ({port.ends[0].component})"
            units.setdefault(name, unit)
        names[port.name] = name
    return units, names


def add_units(root: ET.Element, units: Mapping[str, Unit], ports: Iterable[Port]) -> None:
    """Add units by name, with the display units of ports."""
    shown: dict[str, dict[str, DisplayUnit]] = {}
    for port in ports:
        display = display_unit(port)
        if display is not None and port.unit is not None:
            shown.setdefault(port.unit.name, {})[port.variable.display_unit] = display
    if not units:
        return
    definitions = ET.SubElement(root, "UnitDefinitions")
    for name, unit in units.items():
        element = ET.SubElement(definitions, "Unit", name=name)
        if unit.exponents is not None:
            base = {b: str(e) for b, e in zip(BASES, unit.exponents, strict=True) if e}
            base |= {"factor": repr(unit.factor)} if unit.factor != 1.0 else {}
            base |= {"offset": repr(unit.offset)} if unit.offset else {}
            ET.SubElement(element, "BaseUnit", base)
        for text, display in shown.get(name, {}).items():
            factor = 1.0 / display.gain
            more = {"offset": repr(-display.bias * factor)} if display.bias else {}
            ET.SubElement(element, "DisplayUnit", {"name": text, "factor": repr(factor), **more})


def display_unit(port: Port) -> DisplayUnit | None:
    """Return the display unit of a port; None where it has none, or another unit than its variable."""
    variable = port.variable
    if port.unit is None or variable.unit is None or port.unit != variable.unit:
        return None
    return variable.declared_units.display.get(variable.unit.name, {}).get(variable.display_unit)


def enumerations(ports: Iterable[Port]) -> dict[Items, str]:
    """Return the names of types of enumerations by their items."""
    types: dict[Items, str] = {}
    for port in ports:
        if port.variable.type == "Enumeration":
            types.setdefault(items_of(port), f"enumeration{len(types) + 1}")
    return types


def items_of(port: Port) -> Items:
    """Return name and value of each item of an enumeration."""
    return tuple(port.variable.items.items())


def add_log_categories(root: ET.Element) -> None:
    """Add the categories of messages."""
    categories = ET.SubElement(root, "LogCategories")
    for category in LOG_CATEGORIES:
        ET.SubElement(categories, "Category", name=category)


def add_experiment(root: ET.Element, contents: Contents) -> None:
    """Add the default experiment: the times of the system, and the smallest step."""
    system = contents.system
    times = {"startTime": repr(seconds(system.start_time))}
    if system.stop_time is not None:
        times["stopTime"] = repr(seconds(system.stop_time))
    times["stepSize"] = repr(seconds(system.tick * contents.step_ticks))
    ET.SubElement(root, "DefaultExperiment", times)


def real_attributes(port: Port, unit: str | None) -> dict[str, str]:
    """Return the attributes of a Real: unit, display unit, and, if it is not converted, range and nominal value."""
    variable = port.variable
    typed = {} if unit is None else {"unit": unit}
    if display_unit(port) is not None:
        typed["displayUnit"] = variable.display_unit
    if variable.relative:
        typed["relativeQuantity"] = TRUE
    if (port.ends[0].gain, port.ends[0].bias) == (1.0, 0.0):
        limits = {"min": variable.minimum, "max": variable.maximum}
        typed |= {key: repr(value) for key, value in limits.items() if value is not None}
        typed |= {"nominal": repr(variable.nominal)} if variable.nominal != 1.0 else {}
    return typed


def integer_attributes(port: Port) -> dict[str, str]:
    """Return the range of an Integer."""
    limits = {"min": port.variable.minimum, "max": port.variable.maximum}
    return {key: str(int(value)) for key, value in limits.items() if value is not None}


def start_text(port: Port) -> str:
    """Return the start value as it is written."""
    if port.variable.type == "Boolean":
        return TRUE if port.start else FALSE
    if port.variable.type == "String":
        return str(port.start)
    number = port.start
    assert isinstance(number, int | float)
    return repr(float(number)) if port.variable.type == "Real" else str(int(number))


def causality_attributes(port: Port) -> dict[str, str]:
    """Return causality, variability and initial."""
    what = {"causality": port.kind, "variability": _variability(port)}
    return what if port.kind == "input" else what | {"initial": "exact" if port.kind == "parameter" else "calculated"}


def written(root: ET.Element) -> bytes:
    """Return the bytes of a file."""
    ET.indent(root)
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{ET.tostring(root, encoding="unicode")}\n'.encode()


def _variability(port: Port) -> str:
    if port.kind == "parameter":
        return "tunable" if port.variable.variability == "tunable" else "fixed"
    return "continuous" if port.variable.type == "Real" and port.variable.variability == "continuous" else "discrete"


def reaching_inputs(contents: Contents) -> dict[str, list[int]]:
    """Return, by sampled component, the inputs, from 1, that reach it in the tick of a sample."""
    late = {task.name for task in contents.layout.schedule.tasks if task.after_row}
    found: dict[str, set[int]] = {name: set() for name in late}
    for number, port in enumerate(contents.ports):
        reached = {end.component for end in port.ends} & late if port.kind == "input" else set()
        while reached:
            name = reached.pop()
            found[name].add(number + 1)
            reached |= {
                c.to_component
                for c in contents.system.connections
                if c.delay == 0 and c.from_component == name and c.to_component in late
                and number + 1 not in found[c.to_component]
            }  # fmt: skip
    return {name: sorted(numbers) for name, numbers in found.items()}
