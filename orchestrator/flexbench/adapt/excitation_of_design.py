"""Derive from a design the attitude and rate errors that excite a controller, and the response that is expected."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from flexsat.closed_loop import PORTS, port_values
from flexsat.ports.table import Port
from lockstep import InputError
from lockstep.adapter.bind import bind
from lockstep.check.adapted_findings import variables_of
from lockstep.check.contract import Contract, named
from lockstep.fmi.model_description import read_description
from lockstep.system.adapter_file import Adapter
from lockstep.system.component import Component

from ..loop.systems import NANOSECOND, scalar_names
from .contracts import contracts, design_named
from .excitation import Excitation

_SHARE = 0.02  # of a wheel's torque limit: expected for each error, far from saturation even if it is taken for degrees


def excitation_for(adapter: Adapter, fmu: Path, like: str) -> Excitation:
    """Return the excitation of the variant of flexsat's controller that an adapter fits."""
    variables = read_description(Component(name="fmu", source=fmu, period=1)).variables
    asked = [contract for contract in named(contracts(like), like) if contract.component == "controller"]
    if not asked:
        raise InputError(f"--like {like}: only a controller can be excited; write controller or controller:centralised")
    reasons = []
    for contract in asked:
        try:
            bind(adapter, variables_of(contract), variables)
        except InputError as error:
            reasons.append(error)
            continue
        return excitation_of(contract)
    raise reasons[0]


def excitation_of(contract: Contract) -> Excitation:
    """Return the numbers of one spacecraft: measurements at rest, axes, and the LQG's static response."""
    design = design_named(contract.variant)
    model = design.controller
    ports: dict[str, Port] = {port.name: port for port in PORTS["controller"](model)}
    values = port_values("controller", tuple(ports.values()), {"star_tracker.valid": True})
    nominal = {
        scalar: float(value)
        for port in ports.values()
        if port.causality == "input"
        for scalar, value in zip(scalar_names(port), np.atleast_1d(values[port.name]), strict=True)
    }
    rates = slice(3 + model.modes, 6 + model.modes)
    axes = model.c[: model.gyros, rates]
    # the state is the MRP, a quarter of a small angle; a wheel's torque acts on the body with the other sign
    body = model.wheel_axis.T @ model.feedback
    stiffness, damping = -body[:, :3] / 4.0, -body[:, rates]
    expected = _SHARE * model.torque_limit * float(model.torque_limit_factor.min())
    x, y, z = scalar_names(ports["star_tracker.mrp"])
    gyros = zip(scalar_names(ports["gyro.rate"]), axes, strict=True)
    return Excitation(
        component=contract.name,
        ports=variables_of(contract),
        period=round(model.period / NANOSECOND),
        nominal=nominal,
        attitude=(x, y, z),
        rate={gyro: (float(axis[0]), float(axis[1]), float(axis[2])) for gyro, axis in gyros},
        torque=tuple(scalar_names(ports["wheel.torque"])),
        wheel_axis=model.wheel_axis,
        stiffness=stiffness,
        damping=damping,
        angle=expected / float(np.max(np.abs(stiffness))),
        speed=expected / float(np.max(np.abs(damping))),
    )
