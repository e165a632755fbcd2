"""The entry page of an FMU's documentation: one HTML file from the ports and the component's text, no network."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

from ...ports.table import PortTable
from .experiments import Experiment
from .hosting import ERRORS_SECTION, hosting_section
from .tables import code, html_table, port_table, unit_table
from .terminals import terminals_of
from .text import FRAMES, PAPER, ComponentText, Equation

_STYLE = """\
body { font: 15px/1.5 system-ui, sans-serif; color: #222; background: #fff;
  margin: 2em auto; max-width: 76em; padding: 0 1em; }
h1, h2, h3 { line-height: 1.2; } h2 { margin-top: 2em; border-bottom: 1px solid #ccc; }
table { border-collapse: collapse; margin: 1em 0; font-size: 13px; }
th, td { border: 1px solid #ccc; padding: .25em .5em; text-align: left; vertical-align: top; }
th { background: #f0f0f0; } code, pre { font: 13px/1.4 ui-monospace, monospace; }
pre { background: #f6f6f6; padding: .8em; overflow-x: auto; }
.equation { font-size: 17px; } .source { color: #666; font-size: 13px; } img { max-width: 100%; }
.wide { overflow-x: auto; } .contents { columns: 3; max-width: 50em; } p, li { max-width: 60em; }
"""


def page(
    table: PortTable,
    text: ComponentText,
    experiments: Sequence[Experiment],
    *,
    model_name: str,
    configuration: str,
    version: str,
    step: float,
    stop: float,
) -> bytes:
    """Return documentation/index.html: well-formed, self-contained, the same bytes for the same input.

    Parameters
    ----------
    table : the component's ports, in the naming of the FMU
    text : its words
    experiments : those that travel with reference results
    configuration : one sentence on the layout of the wheels
    step, stop : of the default experiment [s]
    """
    output = next(v.name for v in table.variables if v.port.causality == "output")
    sections = {
        "What it models": _paragraphs(text.models) + _picture(text),
        "Equations": "".join(map(_equation, text.equations)) + f"<p class='source'>{escape(PAPER)}</p>\n",
        "Frames and conventions": _paragraphs(FRAMES) + _naming(table),
        "Timing": _paragraphs(text.timing),
        "Inputs": _wide(port_table(table, "input")),
        "Outputs": _wide(port_table(table, "output")),
        "Parameters": f"<p>{_when(table)}</p>\n" + _wide(port_table(table, "parameter")),
        "Units": unit_table(table),
        "Terminals": _terminals(table),
        "State": _paragraphs(text.state),
        "Errors": ERRORS_SECTION,
        "How to run it": hosting_section(f"{model_name}.fmu", step, stop, output),
        "How to check it": _checks(experiments),
        "Licences": _LICENCES,
    }
    contents = "".join(f"<li><a href='#{_anchor(name)}'>{escape(name)}</a></li>" for name in sections)
    body = "".join(f"<h2 id='{_anchor(name)}'>{escape(name)}</h2>\n{inside}" for name, inside in sections.items())
    title = f"{text.title}: {model_name}"
    return f"""\
<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8" />
<title>{escape(title)}</title>
<style>
{_STYLE}</style>
</head>
<body>
<h1>{escape(title)}</h1>
<p>{escape(text.summary)} {escape(configuration)}</p>
<p>FMI 2.0 for co-simulation, flexsat {escape(version)}, step {step:g} s recommended, names {table.naming}.</p>
<ul class='contents'>{contents}</ul>
{body}</body>
</html>
""".encode()


def _anchor(name: str) -> str:
    return name.lower().replace(" ", "-")


def _paragraphs(texts: Sequence[str]) -> str:
    return "".join(f"<p>{escape(text)}</p>\n" for text in texts)


def _wide(inside: str) -> str:
    return f"<div class='wide'>\n{inside}</div>\n" if inside else "<p>None.</p>\n"


def _picture(text: ComponentText) -> str:
    return f"<p><img src='../model.png' alt='{escape(text.title)}: the structure with its wheels and sensors' /></p>\n"


def _equation(equation: Equation) -> str:
    return (
        f"<p class='equation'>{equation.formula}</p>\n"
        f"<p>{escape(equation.meaning)}. <span class='source'>[{escape(equation.source)}]</span></p>\n"
    )


def _when(table: PortTable) -> str:
    """Tell when parameters may be set."""
    if any(port.variability == "tunable" for port in table):
        return "Those that are tunable may be set at any time, all others before initialisation ends."
    return "All are fixed: set them before initialisation ends."


def _naming(table: PortTable) -> str:
    if table.naming == "flat":
        text = (
            "Names in this FMU are flat: wheel_torque_1. The FMU with structured names, wheel.torque[1], has the same"
            " value references and gives the same bits. The text here names ports in the structured way."
        )
    else:
        text = (
            "Names are structured: wheel.torque[1], numbered from 1. For tools that make buses of such names there is"
            " the same FMU with flat ones, wheel_torque_1, the same value references and the same bits."
        )
    return f"<p>{escape(text)}</p>\n"


def _terminals(table: PortTable) -> str:
    rows = [[code(t.name), code(t.matching), escape(t.description)] for t in terminals_of(table)]
    return (
        f"<p>{code('terminalsAndIcons/terminalsAndIcons.xml')} groups the variables. Terminals of the same name in two"
        f" of these FMUs belong together; their members match by name.</p>\n"
        + html_table(("name", "rule", "what"), rows)
    )


def _checks(experiments: Sequence[Experiment]) -> str:
    rows = [
        [code(e.name), escape(e.description), f"{e.stop_time:g} s", f"{e.step:g} s", f"{e.record_every * e.step:g} s"]
        for e in experiments
    ]
    table = html_table(("experiment", "what", "stop", "step", "rows of the results"), rows)
    return (
        f"<p>{code('extra/org.fmi-standard.fmi-ls-ref/')} has experiments with parameters, stimuli and reference"
        f" results after FMI-LS-REF. <a href='fmi-ls-ref.txt'>fmi-ls-ref.txt</a> says how to replay them, and how near"
        f" the results must be.</p>\n{table}"
    )


_LICENCES = (
    f"<p>The model is under the BSD 3-Clause licence, the wrapper {code('pythonfmu')} under the MIT licence:"
    " <a href='licenses/license.txt'>licenses/license.txt</a>.</p>\n"
)
