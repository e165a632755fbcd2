"""Describe a verdict on an adapter for people: the measured response, and what to change."""

from __future__ import annotations

from pathlib import Path

from flexbench.adapt.attitude_words import MEASURED, quantities
from flexbench.adapt.excitation import Excitation
from flexbench.adapt.judge import AXES
from flexbench.adapt.verdict import Verdict
from lockstep.system.clock import seconds


def describe_verdict(verdict: Verdict, excitation: Excitation, fmu: Path, adapter: Path) -> list[str]:
    """Return a verdict as lines of text."""
    return [*describe_response(verdict, excitation, fmu, adapter), *describe_findings(verdict, fmu)]


def describe_response(verdict: Verdict, excitation: Excitation, fmu: Path, adapter: Path) -> list[str]:
    """Return the measured response as a table."""
    judgement = verdict.judgement
    lines = [
        f"{fmu} through {adapter} as {excitation.component}, steps of "
        f"{seconds(verdict.step):g} s; torque as a share of that of flexsat's LQG:",
        "  error about    attitude: torque x, y, z    rate: torque x, y, z",
    ]
    for k, axis in enumerate(AXES):
        attitude, rate = (
            " ".join(f"{value:8.3g}" for value in shares[:, k]) for shares in (judgement.attitude, judgement.rate)
        )
        lines.append(f"  {axis}              {attitude}    {rate}")
    return lines


def describe_findings(verdict: Verdict, fmu: Path) -> list[str]:
    """Return what was not judged, what is right or wrong, and what to change."""
    judgement = verdict.judgement
    lines = []
    if verdict.unseen:
        lines.append(f"constant, so not judged: {', '.join(verdict.unseen)}")
    unmeasured = [axis for axis, measured in zip(AXES, judgement.measured, strict=True) if not measured]
    if unmeasured:
        lines.append(f"no gyro measures the rate about {', '.join(unmeasured)}: the response to it is not judged")
    lines += _constants(verdict)
    if verdict.right:
        lines.append(
            f"right: the torque opposes each attitude and rate error about its own axis, with "
            f"{judgement.bandwidth:.2g} of the bandwidth and {judgement.damping:.2g} of the damping ratio of "
            "flexsat's LQG"
        )
        return lines
    lines += [f"measured: {problem}" for problem in judgement.problems]
    if verdict.axes:
        lines.append(f"wrong: {verdict.axes}")
    for number, changes in enumerate(verdict.cures):
        errors = ", and ".join(f"{change.error}: write {change.remedy}" for change in changes)
        lines.append(f"{'or' if number else 'wrong'}: {errors}")
    if len(verdict.cures) > 1:
        lines.append(
            "each of these corrections is right, the likeliest first; the FMU's documentation decides between them"
        )
    elif verdict.cures and [change.key for change in verdict.cures[0]] == ["sign"]:
        lines.append("a wrong sign of the torque has the same effect as wrong signs of both attitude and rate")
    elif judgement.silent:
        lines.append("wrong: no wheel responds to any error; a parameter or constant may be missing, such as a mode or "
                     f"a flag: flexsat probe-latency {fmu} shows which")  # fmt: skip
    elif not (verdict.cures or verdict.axes):
        lines.append("wrong: no change of one convention, or of two, is right; it may be no attitude controller, or "
                     "a parameter or constant may be missing")  # fmt: skip
    return lines


def _constants(verdict: Verdict) -> list[str]:
    """Name what the adapter feeds as constants, and which of it looks like a measurement."""
    if not verdict.constants:
        return []
    measured = [name for name in verdict.constants if quantities(name) & MEASURED]
    lines = [f"constants of the adapter: {', '.join(f'{name} = {value}' for name, value in verdict.constants.items())}"]
    if measured:
        lines.append(
            f"constant, though its name is that of a measurement: {', '.join(measured)}; give it an [[input]] entry"
        )
    return lines
