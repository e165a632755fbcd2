"""Adapters for our components: what excites a controller, as numbers of the design, and the commands."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from flexbench.adapt.excitation import Excitation
from flexbench.adapt.judge import AXES
from flexbench.adapt.verdict import Verdict
from flexsat.closed_loop import PORTS, port_values
from flexsat.design.chain import Design, build_design
from flexsat.parameters import ConfigurationName, configuration
from flexsat.ports.table import Port
from lockstep import InputError
from lockstep.adapter.bind import Ports, bind
from lockstep.adapter.draft import draft_adapter
from lockstep.check.contract import Contract, named
from lockstep.fmi.model_description import Variable, read_description
from lockstep.system.adapter_file import Adapter
from lockstep.system.component import Component

from ..loop.systems import NANOSECOND, scalar_names
from .contracts import contracts

_SHARE = 0.02  # of a wheel's torque limit: what turns and rates call for, also in degrees far from saturation


def draft_for(fmu: Path, like: str) -> tuple[str, Sequence[str]]:
    """Return a first adapter of an FMU for a component, and what remains undecided."""
    drafts = []
    for contract in named(contracts(), like):
        needed = [port.name for port in contract.ports if port.needed]
        drafts.append(draft_adapter(fmu, variables_of(contract), needed, contract.name))
    return min(drafts, key=lambda draft: len(draft[1]))


def excitation_for(adapter: Adapter, fmu: Path, like: str) -> Excitation:
    """Return the excitation of the variant of our controller that an adapter fits."""
    theirs = read_description(Component(name="fmu", source=fmu, period=1)).variables
    asked = [contract for contract in named(contracts(), like) if contract.component == "controller"]
    if not asked:
        raise InputError(f"--like {like}: only a controller can be excited; write controller or controller:centralised")
    reasons = []
    for contract in asked:
        try:
            bind(adapter, variables_of(contract), theirs)
        except InputError as error:
            reasons.append(error)
            continue
        return excitation_of(contract)
    raise reasons[0]


def variables_of(contract: Contract) -> Ports:
    """Return the ports of a contract as variables."""
    return {
        port.name: Variable(name=port.name, reference=number, type=port.type, causality=port.causality, unit=port.unit)
        for number, port in enumerate(contract.ports)
    }


def excitation_of(contract: Contract) -> Excitation:
    """Return the numbers of one configuration: measurements at rest, axes, and what the LQG answers with."""
    name: ConfigurationName = "distributed" if contract.variant == "distributed" else "centralised"
    design: Design = build_design(configuration(name))
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
    call = _SHARE * model.torque_limit
    x, y, z = scalar_names(ports["star_tracker.mrp"])
    gyros = zip(scalar_names(ports["gyro.rate"]), axes, strict=True)
    return Excitation(
        component=contract.name,
        ours=variables_of(contract),
        period=round(model.period / NANOSECOND),
        nominal=nominal,
        attitude=(x, y, z),
        rate={gyro: (float(axis[0]), float(axis[1]), float(axis[2])) for gyro, axis in gyros},
        torque=tuple(scalar_names(ports["wheel.torque"])),
        wheel_axis=model.wheel_axis,
        stiffness=stiffness,
        damping=damping,
        angle=call / float(np.max(np.abs(stiffness))),
        speed=call / float(np.max(np.abs(damping))),
    )


def describe_verdict(verdict: Verdict, excitation: Excitation, fmu: Path, adapter: Path) -> list[str]:
    """Return the verdict as lines."""
    judgement = verdict.judgement
    lines = [
        f"{fmu} through {adapter} as {excitation.component}, steps of "
        f"{verdict.step * NANOSECOND:g} s; shares of the torque that our LQG would answer with:",
        "  about    a turn answered in x, y, z    a rate answered in x, y, z",
    ]
    for k, axis in enumerate(AXES):
        turn, rate = (
            " ".join(f"{value:8.3g}" for value in shares[:, k]) for shares in (judgement.attitude, judgement.rate)
        )
        lines.append(f"  {axis}       {turn}    {rate}")
    if verdict.unseen:
        lines.append(f"held still, so not judged: {', '.join(verdict.unseen)}")
    if verdict.right:
        lines.append(
            f"right: every turn and rate is opposed on its own axis, with {judgement.bandwidth:.2g} of the bandwidth "
            f"and {judgement.damping:.2g} of the damping ratio of our LQG"
        )
        return lines
    lines += [f"seen: {problem}" for problem in judgement.problems]
    if verdict.axes:
        lines.append(f"wrong: {verdict.axes}")
    for number, changes in enumerate(verdict.cures):
        errors = ", and ".join(f"{change.error}: write {change.remedy}" for change in changes)
        lines.append(f"{'or' if number else 'wrong'}: {errors}")
    if len(verdict.cures) > 1:
        lines.append("each of these makes it right, the likeliest first; the FMU's documentation must tell them apart")
    elif verdict.cures and [change.key for change in verdict.cures[0]] == ["sign"]:
        lines.append("a torque of wrong sign cannot be told from an attitude and a rate that are both inverted")
    elif not (verdict.cures or verdict.axes):
        lines.append("wrong: no single convention, nor two, makes it right; it may not be a controller of attitude, or "
                     "another parameter or constant may be missing")  # fmt: skip
    return lines
