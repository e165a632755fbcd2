"""Write the documentation page of a bundle."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape

from lockstep.bundle.contents import Contents
from lockstep.bundle.ports import Port
from lockstep.system.clock import seconds_text

_STYLE = "body{font-family:sans-serif;max-width:60em;margin:2em auto;padding:0 1em}table{border-collapse:collapse}"
_CELLS = "td,th{border:1px solid #bbb;padding:.2em .6em;text-align:left;vertical-align:top}"


def documentation(contents: Contents, platforms: Sequence[str], version: str) -> bytes:
    """Return documentation/index.html."""
    system = contents.system
    tick = seconds_text(system.tick)
    step = seconds_text(system.tick * contents.step_ticks)
    early = contents.early
    rows = []
    for task in contents.layout.schedule.tasks:
        component = system.component(task.name)
        seen = (
            "at the communication point" if task.continuous or task.name in early else "in the step that begins there"
        )
        period, offset = seconds_text(component.period), seconds_text(component.offset)
        rows.append((component.name, component.source.name, f"{period} s from {offset} s", component.kind, seen))
    body = [
        f"<h1>{escape(system.name)}</h1>",
        f"<p>A system of {len(rows)} FMUs as one FMU for co-simulation (FMI {version}). Its library calls the FMUs in "
        "<code>resources/</code>, each at its own period, and transfers their values with the delays of the system."
        "</p>",
        _table(("component", "FMU", "steps", "kind", "outputs are new"), rows),
        "<h2>Time</h2>",
        f"<p>The tick is {tick} s. A step of this FMU must be a multiple of {step} s and begin where the last one "
        "ended. Inputs are held over a step. After a step to the time <i>t</i> the outputs of continuous components "
        "are true at <i>t</i>. Sampled components that no input of this FMU reaches have taken their sample at "
        "<i>t</i>; the others take it in the step that begins at <i>t</i>, since their inputs are set there, and show "
        "the sample before it until then.</p>",
        "<h2>Variables</h2>",
        *_ports("Inputs", (port for port in contents.ports if port.kind == "input")),
        *_ports("Outputs", (port for port in contents.ports if port.kind == "output")),
        *_ports("Parameters", (port for port in contents.ports if port.kind == "parameter")),
        "<h2>Needs</h2>",
        f"<p>Binaries: {escape(', '.join(platforms))}. {escape(_needs(contents))}</p>",
    ]
    page = f'<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8"><title>{escape(system.name)}</title>'
    return f"{page}<style>{_STYLE}{_CELLS}</style></head>\n<body>\n{chr(10).join(body)}\n</body></html>\n".encode()


def _needs(contents: Contents) -> str:
    needing = [c.name for c in contents.system.components if contents.descriptions[c.name].needs_tool]
    if needing:
        return f"{', '.join(needing)}: needs a tool that is not in the FMU, see resources/ and its own documentation."
    return "Nothing else is needed: no Python and no other tool."


def _ports(title: str, ports: Iterable[Port]) -> list[str]:
    rows = [
        (port.name, port.unit.name if port.unit else "", _origin(port), port.variable.description) for port in ports
    ]
    return [f"<h3>{title}</h3>", _table(("name", "unit", "variable", "description"), rows)] if rows else []


def _origin(port: Port) -> str:
    return ", ".join(f"{end.component}.{end.variable.name}" for end in port.ends)


def _table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    def line(cells: Sequence[str], kind: str) -> str:
        return f"<tr>{''.join(f'<{kind}>{escape(cell)}</{kind}>' for cell in cells)}</tr>"

    return "\n".join(("<table>", line(head, "th"), *(line(row, "td") for row in rows), "</table>"))
