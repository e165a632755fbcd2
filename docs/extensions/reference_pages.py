"""Pages written before Sphinx reads, from the code: commands, models with equations, the interface document."""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import click
from sphinx.application import Sphinx

from flexbench.campaign import campaign_file
from flexbench.cli.parser import PROGRAM
from flexbench.loop import mission_file
from flexbench.studies.budget import requirements
from flexsat.fmu.documentation.component_text import FRAMES, PAPER, ComponentText
from flexsat.fmu.documentation.content import TEXTS
from lockstep.__main__ import PROGRAM as LOCKSTEP
from lockstep.adapter import read as adapter_read
from lockstep.cli.program import CommandGroup
from lockstep.faults import HELP

_MISSING = (
    "The interface document is written by `flexsat build --missions`; it was not there when these pages were built.\n"
)


def command_page(program: CommandGroup, title: str) -> str:
    """Return the help of all commands of a program as a page, a section a command."""
    return "\n".join([f"# {title}\n", *_sections(program)])


def _sections(program: CommandGroup) -> Iterator[str]:
    context = click.Context(program, info_name=program.name, **program.context_settings)
    for name in program.list_commands(context):
        command = program.get_command(context, name)
        inner = click.Context(command, info_name=name, parent=context, max_content_width=100, terminal_width=100)
        yield f"## {name}\n\n```text\n{command.get_help(inner)}\n```\n"


def models_page() -> str:
    """Return what each component models: the text, with equations and sources, that its FMU carries."""
    parts = [
        "# Models and equations",
        "The same text stands in `documentation/index.html` of each FMU.",
        PAPER,
        *FRAMES,
    ]
    for text in TEXTS.values():
        parts += [f"## {text.title}", text.summary, *text.models, "### Equations", *_equations(text)]
        parts += ["### Timing", *text.timing, "### State", *text.state]
    return "\n\n".join(parts) + "\n"


def _equations(text: ComponentText) -> list[str]:
    return [f"<p>{one.formula}<br/>\n{one.meaning} ({one.source}).</p>" for one in text.equations]


def files_page() -> str:
    """Return the keys of every kind of TOML file, from the modules that read them and refuse all others."""
    parts = [
        "# TOML files",
        "Keys as the code that reads each file accepts them; any other is refused by its name.",
        "## Spacecraft",
        "[The spacecraft file](../spacecraft_file.md) lists tables, keys, units, defaults and ranges.",
        "## Campaign",
        "[Campaigns](../campaigns.md) says what each means.",
        *_keys(campaign_file.FILE_KEYS),
        "## Adapter",
        "[Foreign controllers](../foreign_controllers.md) says what each means.",
        *_keys(adapter_read.FILE_KEYS),
        "## Mission",
        "[Missions](../missions.md) has an example.",
        *_keys(mission_file.FILE_KEYS),
    ]
    for title, text in (("Requirements on pointing", requirements.__doc__), ("Faults", HELP)):
        parts += [f"## {title}", f"```text\n{str(text).strip()}\n```"]
    return "\n\n".join(parts) + "\n"


def _keys(tables: Mapping[str, Sequence[str]]) -> Iterator[str]:
    rows = [f"| `{table}` | {', '.join(f'`{key}`' for key in keys)} |" for table, keys in tables.items()]
    yield "\n".join(["| table | keys |", "|---|---|", *rows])


def _on_builder(app: Sphinx) -> None:
    folder = Path(app.srcdir) / "reference"
    folder.mkdir(exist_ok=True)
    pages = {
        "flexsat_commands.md": command_page(PROGRAM, "Commands of flexsat"),
        "lockstep_commands.md": command_page(LOCKSTEP, "Commands of lockstep"),
        "models.md": models_page(),
        "files.md": files_page(),
        "ports.md": _interface(Path(app.config.interface_document)),
        "mission_ports.md": _interface(
            Path(app.config.interface_document).parent / "centralised" / "missions" / "ICD.md", "Ports of missions"
        ),
    }
    for name, text in pages.items():
        path = folder / name
        if not path.exists() or path.read_text(encoding="utf-8") != text:  # else each build would read it again
            path.write_text(text, encoding="utf-8")


def _interface(document: Path, title: str = "Ports") -> str:
    if not document.is_file():
        return f"# {title}\n\n{_MISSING}"
    lines = document.read_text(encoding="utf-8").splitlines()
    return "\n".join(line for line in lines if not line.startswith("![")) + "\n"  # the timeline stands below as text


def setup(app: Sphinx) -> dict[str, Any]:
    """Register with Sphinx."""
    app.add_config_value("interface_document", "", "env")
    app.connect("builder-inited", _on_builder)
    return {"parallel_read_safe": True}
