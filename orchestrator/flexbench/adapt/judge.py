"""Judge a controller's static response: does its torque oppose each error about its own axis, by about as much?"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from flexbench.adapt.excitation import Excitation, Response
from flexsat.arrays import Array

AXES = "xyz"
_ALIGNED = 0.8  # cosine between the torque and the reference's
_AT_REST = 5.0  # times the torque expected for the errors: feedforward of jitter stays below
_BANDWIDTH = 0.75  # decades from the reference's: 5.6 times slower or faster
_DAMPING = 0.6  # decades of the damping ratio: 4 times
_SILENT = 1e-6  # of the reference: no response
_MEASURED = 0.99  # of a unit rate about an axis, as the gyros together see it: the axis is measured


@dataclass(frozen=True, slots=True, kw_only=True)
class Judgement:
    """Hold what is wrong, empty if nothing is, and the response as a share of the reference's, column k for axis k."""

    problems: tuple[str, ...]
    attitude: Array  # (3, 3), 1 on the diagonal is the reference
    rate: Array
    silent: bool  # no wheel responds to any error: no change of a convention mends that
    bandwidth: float  # over the reference's; nan without a response
    damping: float  # ratio, over the reference's
    measured: tuple[bool, ...] = (True, True, True)  # the gyros measure the rate about x, y, z; others are not judged

    @property
    def distance(self) -> float:
        """Deviation of bandwidth and damping from the reference [decades]."""
        return abs(float(np.log10(self.bandwidth))) + abs(float(np.log10(self.damping)))


def judge(response: Response, excitation: Excitation) -> Judgement:
    """Compare with the reference; describe what is wrong in the response, not its cause."""
    attitude: Array = np.asarray(np.linalg.solve(-excitation.stiffness, response.attitude), float)
    rate: Array = np.asarray(np.linalg.solve(-excitation.damping, response.rate), float)
    measured = _measured_axes(excitation)
    problems = [
        *_rest(response, excitation),
        *_pattern("attitude", attitude, (True, True, True)),
        *_pattern("rate", rate, measured),
    ]
    due = excitation.angle * float(np.max(np.abs(excitation.stiffness)))
    if np.max(np.abs([attitude, rate])) <= _SILENT < response.wheels / due:
        problems = [
            f"the wheels respond with up to {response.wheels:.3g} N.m, but their torques cancel on the body: a torque "
            "counts about the axis of its wheel, and some axes point the other way"
        ]
    bandwidth = damping = float("nan")
    stiffer = float(np.median(np.linalg.norm(attitude, axis=0)))
    harder = float(np.median(np.linalg.norm(rate[:, list(measured)], axis=0))) if any(measured) else stiffer**0.5
    if min(stiffer, harder) > _SILENT:
        bandwidth = stiffer**0.5
        damping = harder / bandwidth
        # a bandwidth b times the reference's has b^2 its stiffness and b its damping; units break that law
        if abs(np.log10(bandwidth)) > _BANDWIDTH or abs(np.log10(damping)) > _DAMPING:
            problems.append(f"its stiffness is {stiffer:.3g} times and its damping {harder:.3g} times the reference's")
    silent = response.wheels / due <= _SILENT
    return Judgement(
        problems=tuple(problems),
        attitude=attitude,
        rate=rate,
        silent=silent,
        bandwidth=bandwidth,
        damping=damping,
        measured=measured,
    )


def _measured_axes(excitation: Excitation) -> tuple[bool, ...]:
    """Return for each body axis whether the gyros measure a rate about it; about another a rate response takes long."""
    axes = np.array(list(excitation.rate.values())).reshape(-1, 3)
    seen = np.diag(np.linalg.pinv(axes) @ axes)
    return tuple(bool(value > _MEASURED) for value in seen)


def _rest(response: Response, excitation: Excitation) -> list[str]:
    due = min(
        excitation.angle * float(np.min(np.linalg.norm(excitation.stiffness, axis=0))),
        excitation.speed * float(np.min(np.linalg.norm(excitation.damping, axis=0))),
    )
    answered = max(
        excitation.angle * float(np.max(np.abs(response.attitude))),
        excitation.speed * float(np.max(np.abs(response.rate))),
    )
    if np.max(np.abs(response.rest)) <= _AT_REST * max(due, answered):
        return []
    values = ", ".join(f"{value:.3g}" for value in response.rest)
    return [f"without errors it commands a torque of ({values}) N.m; none is expected"]


def _pattern(what: str, shares: Array, judged: Sequence[bool]) -> list[str]:
    columns = [k for k in range(3) if judged[k]]
    if columns and np.max(np.abs(shares[:, columns])) <= _SILENT:
        return [f"no response to {what} errors about any axis"]
    found = []
    for k in columns:
        axis = AXES[k]
        column = shares[:, k]
        size = float(np.linalg.norm(column))
        if size <= _SILENT:
            found.append(f"no response to {what} errors about {axis}")
        elif column[k] < _ALIGNED * size:
            main = int(np.argmax(np.abs(column)))
            if main != k:
                found.append(
                    f"{what} error about {axis}: torque as for one about {'-' if column[main] < 0 else ''}{AXES[main]}"
                )
            elif column[k] < 0:
                found.append(f"{what} error about {axis}: the torque increases it instead of opposing it")
            else:
                found.append(f"{what} error about {axis}: torque about other axes too")
    return found


def axes_named(judgement: Judgement) -> str:
    """Describe a permutation or reversal of axes, if the response shows one; nothing otherwise."""
    patterns = [_signed(judgement.attitude), _signed(judgement.rate) if all(judgement.measured) else None]
    parts = [
        (what, pattern)
        for what, pattern in zip(("attitude", "rate"), patterns, strict=True)
        if pattern is not None and pattern != (1, 2, 3)
    ]
    if not parts or (len(parts) == 2 and parts[0][1] != parts[1][1]):
        return ""
    which = "torque, or both attitude and rate" if len(parts) == 2 else parts[0][0]
    axes = ", ".join(f"{axis} for {_axis(k, abs(k) - 1)}" for axis, k in zip(AXES, parts[0][1], strict=True))
    reversed_all = len(parts) == 1 and parts[0] == ("attitude", (-1, -2, -3))
    keys = "direction" if reversed_all else "order, sign, frame and body_frame"
    return f"permuted or reversed axes of {which}: {axes}; see {keys}"


def _signed(shares: Array) -> Sequence[int] | None:
    """Return for each axis the one it is taken for, counted from 1 and with its sign; None if there is no such."""
    sizes = np.linalg.norm(shares, axis=0)
    if np.min(sizes) <= _SILENT:
        return None
    main = np.argmax(np.abs(shares), axis=0)
    values = shares[main, range(3)]
    if sorted(main.tolist()) != [0, 1, 2] or np.any(np.abs(values) < _ALIGNED * sizes):
        return None
    return tuple(int(np.sign(value)) * (int(k) + 1) for value, k in zip(values, main, strict=True))


def _axis(sign: float, number: int) -> str:
    return f"{'-' if sign < 0 else ''}{AXES[number]}"
