"""Write a system with adapters as a standard .ssp: adapter entries become connections, parameters and a mapping."""

from __future__ import annotations

from collections.abc import Mapping

from lockstep.adapter.as_ssp import AsSsp, Mapped, without_adapter
from lockstep.errors import InputError
from lockstep.ssp.write_package import MappingEntry, ParameterFile, package
from lockstep.system.system import System


def standard_package(system: System, sources: Mapping[str, tuple[str, str]]) -> tuple[bytes, tuple[str, ...]]:
    """Return the .ssp of a system without its adapters, and a line for each adapter entry that it lacks.

    Raises
    ------
    InputError
        If an adapter does not fit, a source is not there, or an FMU cannot be read.
    """
    files: list[ParameterFile] = []
    problems: list[str] = []
    adapted = [component.name for component in system.components if component.adapter is not None]
    if sources and not adapted:
        raise InputError(f"--source {next(iter(sources))}: needs --replace and --adapter as well")
    for name in adapted:
        translated = without_adapter(system, name, sources)
        system = translated.system
        problems += translated.problems
        files += _files(translated)
    return package(system, files), tuple(problems)


def _files(translated: AsSsp) -> list[ParameterFile]:
    """Return the values of FMU variables, and those of interface ports with the mapping from one to the other.

    Later bindings win, so the second file is the one to edit. The first has the resulting values, for tools that read
    no mapping: libcosim and ecos apply the parameter set with the usual name.
    """
    name = translated.component
    resolved = translated.values | {one.variable: one.resolved for one in translated.mapped}
    return [
        ParameterFile(
            component=name, name=f"{name}_variables", values={key: (value, None) for key, value in resolved.items()}
        ),
        ParameterFile(
            component=name,
            name=f"{name}_ports",
            set_name="valuesOfPorts",
            values={one.port: (one.value, one.unit) for one in translated.mapped},
            mapping=tuple(_entry(one) for one in translated.mapped),
        ),
    ]


def _entry(one: Mapped) -> MappingEntry:
    pair = one.pair
    return MappingEntry(source=one.port, target=one.variable, factor=pair.factor, offset=pair.offset, table=pair.table)
