"""State the ports that an FMU needs to replace one of flexsat's components in the loop."""

from __future__ import annotations

from pathlib import Path

from flexsat.closed_loop import PORTS
from flexsat.description.built_in import CONFIGURATIONS, configuration
from flexsat.design.chain import Design, build_design, design_basis
from flexsat.parameters import ConfigurationName
from flexsat.ports.table import Port
from flexsat.ports.units import BASE_UNITS, unit_of
from lockstep.check.contract import Contract, ContractPort
from lockstep.system.units import Unit

from ..loop.chosen_spacecraft import designs_named
from ..loop.systems import WIRES, scalar_names

FMUS = Path("fmus")  # where spacecraft are that are named by a folder alone
_TYPES = {"real": "Real", "integer": "Integer", "boolean": "Boolean", "string": "String"}


def contracts(like: str | None = None) -> tuple[Contract, ...]:
    """Return the contract of every component of the spacecraft that `like` names, the built-in ones if it names none.

    `like` is component:spacecraft, where the spacecraft is a built-in name, a spacecraft's file or a folder of FMUs;
    InputError for none of these.
    """
    given = (like or "").partition(":")[2]
    names = CONFIGURATIONS if not given or given in CONFIGURATIONS else (given,)
    return tuple(contract for name in names for contract in contracts_of(name))


def contracts_of(name: ConfigurationName) -> tuple[Contract, ...]:
    """Return the contracts of one spacecraft: its sizes come from its design, without the gains."""
    design = design_basis(configuration(name)) if name in CONFIGURATIONS else design_named(name)
    found = []
    for component, ports in PORTS.items():
        needed = {port for source, _, names, _ in WIRES for port in names if source == component}
        scalars = tuple(
            scalar
            for port in ports(getattr(design, component))
            for scalar in _scalars(port, needed=port.causality == "output" and port.name in needed)
        )
        found.append(Contract(component=component, variant=name, ports=scalars))
    return tuple(found)


def design_named(name: ConfigurationName) -> Design:
    """Return the design of a spacecraft by what names it in a contract."""
    if name in CONFIGURATIONS:
        return build_design(configuration(name))
    return designs_named(name, FMUS).corrected


def _scalars(port: Port, needed: bool) -> list[ContractPort]:
    unit = _unit(port.unit) if port.kind == "real" else None
    return [
        ContractPort(name=name, type=_TYPES[port.kind], causality=port.causality, unit=unit, needed=needed)
        for name in scalar_names(port)
    ]


def _unit(name: str) -> Unit:
    exponents = unit_of(name).exponents
    return Unit(name=name, exponents=None if exponents is None else tuple(exponents.get(b, 0) for b in BASE_UNITS))
