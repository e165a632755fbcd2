"""The designed loop at its real rates and delays, as one linear periodic system: plant, sampling, filter, regulator."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np
from scipy.linalg import expm

from flexsat.arrays import Array
from flexsat.closed_loop import port_values
from flexsat.design.chain import Design
from flexsat.ports import controller as interface
from flexsat.runtime.controller import PreparedController, prepare
from flexsat.spacecraft.linear_model import LinearModel
from lockstep.errors import InputError

from .periodic_loop import PeriodicLoop, Phase
from .slow_filter import slow_filter

UNTOUCHED = 1e-9  # singular value, relative, below which the wheels do not reach a combination of states


@dataclass(frozen=True, slots=True, kw_only=True)
class Delays:
    """The real delays; those that the controller compensates are among its parameters."""

    samples: int = 0  # from sampling to the step of the controller that uses it, in controller steps
    actuation: float = 0.0  # s, from the controller's step to when the torque acts: any fraction of a step

    def __post_init__(self) -> None:
        if self.samples < 0 or not self.actuation >= 0.0:
            raise InputError(f"Delays: must be >= 0, got {self.samples} samples and {self.actuation!r} s")


@dataclass(frozen=True, kw_only=True)
class DesignedLoop:
    """A design with the parameters of a run, to be opened at the plant input for any delay.

    What does not depend on that delay is prepared once.

    `plant` is the linear model of the real spacecraft, with the sensors and wheels of the design; None for the model
    that the controller was designed on.
    """

    design: Design
    plant: LinearModel | None = None
    delays: Delays = Delays()
    parameters: Mapping[str, Any] = field(default_factory=lambda: {"star_tracker.fine": True})  # of the controller

    def at(self, extra_delay: float = 0.0) -> PeriodicLoop:
        """Return the open loop, with a further delay [s] at the plant input that the controller does not compensate.

        The plant is the linear model without the net momentum, which no wheel torque changes; it is sampled exactly,
        with the torque changing at the right moment within a step. The controller is the run-time object itself:
        its sampled model, its periodic gain and its prediction over known delays; without reference, limits and
        feed-forward of the jitter, which are not part of the linear loop.

        Raises
        ------
        InputError
            For a parameter that the controller does not have or refuses.
        """
        prepared = self.controller
        a, b, c = self._reached_model
        transition, over_period = self._sampled
        period, n, s = prepared.period, prepared.wheels, prepared.states
        lag, late = self.delays.samples, self.delays.actuation + extra_delay

        rows = _history_rows(prepared)
        applied = int(np.ceil(late / period - 1e-9))  # torques on their way
        slow = slow_filter(prepared)
        sizes = [len(a), lag * len(c), s, rows * n, applied * n, len(slow.a)]
        plant, sampled, estimate, history, on_way, errors = _spans(sizes)
        size = sum(sizes)

        b_loop = np.zeros((size, n))
        common = np.zeros((size, size))
        whole = int(np.floor(late / period + 1e-9))
        part = max(0.0, late - whole * period)
        held = _held(a, b, period - part)[1] if part > 1e-9 else over_period
        early = over_period - held  # of the torque before: over the whole step, without what the later one does
        common[plant, plant] = transition
        for steps_ago, matrix in ((whole, held), (whole + 1, early)):
            if steps_ago == 0:
                b_loop[plant] += matrix
            elif matrix.any():
                block = slice(on_way.start + (steps_ago - 1) * n, on_way.start + steps_ago * n)
                common[plant, block] += matrix
        _shift(common, on_way, n)
        if applied:
            b_loop[on_way.start : on_way.start + n] = np.eye(n)
        _shift(common, sampled, len(c))
        if lag:
            common[sampled.start : sampled.start + len(c), plant] = c

        measured = np.zeros((len(c), size))  # what the controller sees in this step
        if lag:
            measured[:, sampled.stop - len(c) : sampled.stop] = np.eye(len(c))
        else:
            measured[:, plant] = c
        phases, whole_delay = [], prepared.whole_delay
        for number, gain in enumerate(
            (prepared.gain[0], prepared.gain[1]) if prepared.phases > 1 else (prepared.gain[0],) * 2
        ):
            predicted = np.zeros((s, size))
            predicted[:, estimate] = prepared.predict[:, :s]
            predicted[:, history] = prepared.predict[:, s : s + rows * n]
            predicted[:, errors] = slow.enters
            known = np.zeros((len(slow.a), size))
            known[:, errors] = slow.a
            for ago, torques in ((whole_delay, slow.late), (whole_delay + 1, slow.early)):
                if ago < rows:
                    known[:, history.start + ago * n : history.start + (ago + 1) * n] = torques
            known += slow.gains[number] @ (measured - slow.seen @ known)
            corrected = predicted + gain @ (measured - prepared.c @ predicted - slow.known @ known)
            expected = corrected[: prepared.controlled]
            if prepared.delayed:
                expected = prepared.ahead[:, :s] @ corrected
                expected[:, history] += prepared.ahead[:, s : s + rows * n]
                expected += slow.ahead @ known
            returned = prepared.feedback @ expected - slow.against @ known
            step = common.copy()
            step[estimate], step[errors] = corrected, known
            _shift(step, history, n)
            step[history.start : history.start + n] = -returned
            phases.append(Phase(a=step, c=returned))
        return PeriodicLoop(first=phases[0], rest=phases[1], b=b_loop, steps=prepared.phases, period=period)

    @property
    def body_axes(self) -> tuple[Array, Array]:
        """Return how a body torque is shared among the wheels, (n, 3), and what body torque wheels make, (3, n)."""
        makes = -self.design.controller.wheel_axis.T
        return np.asarray(np.linalg.pinv(makes)), makes

    @cached_property
    def controller(self) -> PreparedController:
        """The controller of the run, prepared."""
        matrices = self.design.controller
        values = port_values("controller", interface.ports(matrices), self.parameters)
        return prepare(matrices, interface.parameters(matrices, values.__getitem__))

    @cached_property
    def _sampled(self) -> tuple[Array, Array]:
        """Transition of the plant over a step of the controller, and the input matrix of a torque held over it."""
        a, b, _ = self._reached_model
        return _held(a, b, self.controller.period)

    @cached_property
    def _reached_model(self) -> tuple[Array, Array, Array]:
        """Matrices a, b and c of the plant, of the states that the wheels reach."""
        model = self.design.model if self.plant is None else self.plant
        reached = _reached(np.hstack([model.a, model.b_torque]))
        return reached.T @ model.a @ reached, reached.T @ model.b_torque, model.c @ reached


def _history_rows(prepared: PreparedController) -> int:
    """Return how many past torques the controller's model really uses; the newest is always kept."""
    s, n = prepared.states, prepared.wheels
    used = np.abs(prepared.predict[:, s : s + (prepared.whole_delay + 2) * n]).max(axis=0)
    if prepared.delayed:
        used = used + np.abs(prepared.ahead[:, s:]).max(axis=0)
    return max(k for k in range(len(used)) if used[k] > 0.0) // int(n) + 1


def _reached(rows: Array) -> Array:
    """Return an orthonormal basis of the states that [a b] moves: without the conserved momentum and translation."""
    left, values, _ = np.linalg.svd(rows, full_matrices=False)
    return left[:, values > UNTOUCHED * values[0]]


def _held(a: Array, b: Array, period: float) -> tuple[Array, Array]:
    """Sample with the input held: the run-time's `zero_order_hold` is as exact, and slow for hundreds of states."""
    size, inputs = b.shape
    block = np.zeros((size + inputs, size + inputs))
    block[:size, :size], block[:size, size:] = period * a, period * b
    sampled = np.asarray(expm(block), np.float64)
    return sampled[:size, :size], sampled[:size, size:]


def _spans(sizes: list[int]) -> list[slice]:
    return [slice(start, end) for start, end in pairwise(np.cumsum([0, *sizes]).tolist())]


def _shift(matrix: Array, span: slice, width: int) -> None:
    """Shift a queue of blocks by one; the caller fills its first block."""
    matrix[span] = 0.0
    for start in range(span.start + width, span.stop, width):
        matrix[start : start + width, start - width : start] = np.eye(width)
