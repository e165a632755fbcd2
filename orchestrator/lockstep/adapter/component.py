"""Replace a component by a foreign FMU: the ports that it then shows, its slave, and the system with it."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path

from lockstep.adapter.bind import Binding, adapted, bind
from lockstep.adapter.read import read_adapter
from lockstep.adapter.slave import AdaptedSlave
from lockstep.errors import InputError, compact
from lockstep.fmi.model_description import Description, read_description
from lockstep.fmi.slave import Slave
from lockstep.results.signal_patterns import matching, split_kind
from lockstep.system.adapter_file import Adapter
from lockstep.system.component import Component
from lockstep.system.system import System


def shown_description(component: Component) -> Description:
    """Read the FMU of a component; with an adapter, return the ports that it then has. Raises InputError."""
    fmu = read_description(component)
    if component.adapter is None:
        return fmu
    return adapted(_binding(component, fmu), fmu)


def with_adapter(component: Component, slave: Slave) -> Slave:
    """Return the slave, inside the adapter of its component if there is one."""
    if component.adapter is None:
        return slave
    return AdaptedSlave(slave, _binding(component, read_description(component)))


def _binding(component: Component, fmu: Description) -> Binding:
    assert component.adapter is not None
    assert component.stands_for is not None
    return bind(component.adapter, read_description(component.stands_for).variables, fmu.variables)


def replace_component(system: System, name: str, fmu: Path, adapter: Adapter | None) -> System:
    """Return the system in which another FMU replaces a component.

    Without an adapter the FMU needs the same ports. With one, connections to inputs, start values and recordings that
    the adapter does not serve are left out, and the adapter's step becomes the component's period.

    Raises
    ------
    InputError
        If the adapter fits neither side, or serves too little.
    """
    old = system.component(name)
    if adapter is None:
        same = replace(old, source=fmu.absolute(), archive=None, sums=None)
        _check_ports(system, same)
        return _with(system, same)
    new = Component(
        name=name,
        source=fmu.absolute(),
        period=adapter.step or old.period,
        offset=old.offset if old.offset < (adapter.step or old.period) else 0,
        kind=adapter.kind or old.kind,
        adapter=adapter,
        stands_for=old,
    )
    shown = shown_description(new).variables
    needed = [c.output for c in system.connections if c.from_component == name and c.output not in shown]
    if needed:
        raise InputError(
            f"{adapter.path.name}: the system needs {compact(needed)} of {name}; add an [[output]], or [substitutes]"
        )
    ports = read_description(old).variables
    kept = {key: value for key, value in old.parameters.items() if key in shown and key in ports}
    kept = {key: value for key, value in kept.items() if shown[key].causality == ports[key].causality}
    new = replace(new, parameters=kept, units={key: unit for key, unit in old.units.items() if key in kept})
    names = [f"{name}.{v.name}" for v in shown.values()]
    return replace(
        _with(system, new),
        connections=tuple(c for c in system.connections if c.to_component != name or c.input in shown),
        record=tuple(p for p in system.record if not _is_of(p, name) or matching(split_kind(p)[1], names)) or ("all",),
    )


def _check_ports(system: System, new: Component) -> None:
    """Refuse an FMU that lacks connected ports: its own may have other names, which is what adapters are for."""
    has = read_description(new).variables
    ends = [c.input for c in system.connections if c.to_component == new.name]
    ends += [c.output for c in system.connections if c.from_component == new.name]
    missing = [name for name in dict.fromkeys(ends) if name not in has]
    if missing:
        raise InputError(
            f"--replace {new.name}={new.source}: the FMU has no {compact(missing)}, which the system connects; give "
            f"--adapter FILE, which `adapt` drafts: flexsat adapt {new.source} --like {new.name} --out FILE"
        )


def _with(system: System, new: Component) -> System:
    return replace(system, components=tuple(new if c.name == new.name else c for c in system.components))


def _is_of(pattern: str, name: str) -> bool:
    return split_kind(pattern)[1].startswith(f"{name}.")


def with_replacements(system: System, texts: Iterable[str], adapters: Iterable[str]) -> System:
    """Return the system with replacements as COMPONENT=FMU, and adapters as FILE or COMPONENT=FILE."""
    fmus = replacements(texts, system)
    if adapters and not fmus:
        raise InputError(f"--adapter {next(iter(adapters))}: needs --replace COMPONENT=FMU as well")
    files: dict[str, Path] = {}
    for text in adapters:
        name, equals, path = text.partition("=")
        if not (equals and name in fmus):
            if len(fmus) > 1:
                raise InputError(f"--adapter {text}: write COMPONENT=FILE, with one of {', '.join(fmus)}")
            name, path = next(iter(fmus)), text
        if name in files:
            raise InputError(f"--adapter {text}: {name} has the adapter {files[name]} already")
        files[name] = Path(path)
    for name, fmu in fmus.items():
        system = replace_component(system, name, fmu, read_adapter(files[name]) if name in files else None)
    return system


def replacements(texts: Iterable[str], system: System) -> Mapping[str, Path]:
    """Return the FMUs of replacements given as COMPONENT=FMU, by component; or raise InputError."""
    found: dict[str, Path] = {}
    for text in texts:
        match = re.fullmatch(r"([^=.]+)=(.+)", text)
        if match is None:
            raise InputError(f"--replace {text}: write COMPONENT=FMU, for example controller=vendor.fmu")
        system.component(match[1])
        if match[1] in found:
            raise InputError(f"--replace {text}: {match[1]} is replaced already, by {found[match[1]]}")
        found[match[1]] = Path(match[2])
    return found
