"""Run-time thrusters: pulses of at least a minimum impulse at a fixed rate, noise, a first-order lag. numpy alone.

The outputs of a step are means over it, so that the sum of output times step is the impulse, without any error.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...arrays import Array, make_read_only
from ..periods import whole_multiple

STREAM = 3  # a component's own random stream: plant, sensors and thrusters may be given the same seed
WHOLE = 1.0 - 1e-9  # of the minimum impulse: a command of just that fires, whatever its rounding


@dataclass(frozen=True, slots=True, kw_only=True)
class ThrusterParameters:
    """Parameters of one run. Named as the ports are: messages reach those who set them."""

    position: Array  # (k, 3) [m], body
    direction: Array  # (k, 3): of the force on the spacecraft, body, any length
    most_thrust: float  # N
    minimum_impulse: float  # N.s, of a pulse
    period: float  # s, between pulses
    lag: float  # s, time constant; 0: none
    noise: float  # standard deviation of a pulse's thrust, over the thrust
    seed: int
    step: float  # s

    def __post_init__(self) -> None:
        if not self.most_thrust > 0.0:
            raise ValueError(f"thrust.maximum must be > 0, got {self.most_thrust!r}")
        whole_multiple("thrust.period", self.period, self.step)
        for k, direction in enumerate(self.direction):
            if not np.linalg.norm(direction) > 1e-6:
                first, last = 3 * k + 1, 3 * k + 3
                raise ValueError(f"thruster.direction[{first}] to [{last}] must be a direction, got no length")
        if not self.minimum_impulse <= self.most_thrust * self.period:
            raise ValueError(
                f"thrust.minimum_impulse must be at most thrust.maximum times thrust.period,"
                f" {self.most_thrust * self.period:g} N.s, got {self.minimum_impulse!r}"
            )


@dataclass(frozen=True, slots=True, kw_only=True)
class PreparedThrusters:
    """Numbers that no step changes."""

    wrench: Array  # (6, k): force and torque of a unit of thrust
    most_thrust: float  # N
    minimum_impulse: float  # N.s
    period: float  # s
    steps: int  # in a period
    step: float  # s
    decay: float  # of the lag over a step
    mean: float  # of the lag's memory over a step
    noise: float
    seed: int

    def __post_init__(self) -> None:
        make_read_only(self)


@dataclass(slots=True, kw_only=True)
class ThrusterState:
    """What thrusters remember between steps."""

    count: int  # steps done
    open_time: Array  # (k,) [s]: of the present pulse, from its begin
    level: Array  # (k,) [N]: thrust while it is open
    thrust: Array  # (k,) [N]: behind the lag
    pulses: Array  # (k,): fired
    impulse: float  # N.s, of all
    angular_impulse: Array  # (3,) [N.m.s], body axes
    noise: np.random.Generator


def wrench_of(position: Array, direction: Array) -> Array:
    """Return force and torque about the body origin, (6, k), of a unit of thrust of each of k thrusters."""
    along = direction / np.linalg.norm(direction, axis=1)[:, np.newaxis]
    return np.vstack([along.T, np.cross(position, along).T])


def prepare(parameters: ThrusterParameters) -> PreparedThrusters:
    """Sample the lag at the step."""
    h, lag = parameters.step, parameters.lag
    decay = float(np.exp(-h / lag)) if lag > 0.0 else 0.0
    return PreparedThrusters(
        wrench=wrench_of(parameters.position, parameters.direction),
        most_thrust=parameters.most_thrust,
        minimum_impulse=parameters.minimum_impulse,
        period=parameters.period,
        steps=whole_multiple("thrust.period", parameters.period, h),
        step=h,
        decay=decay,
        mean=lag / h * (1.0 - decay),
        noise=parameters.noise,
        seed=parameters.seed,
    )


def init(prepared: PreparedThrusters) -> ThrusterState:
    """Return the state before the first step: all closed."""
    k = prepared.wrench.shape[1]
    (stream,) = np.random.SeedSequence([prepared.seed, STREAM]).spawn(1)
    return ThrusterState(
        count=0,
        open_time=np.zeros(k),
        level=np.zeros(k),
        thrust=np.zeros(k),
        pulses=np.zeros(k, np.int64),
        impulse=0.0,
        angular_impulse=np.zeros(3),
        noise=np.random.default_rng(stream),
    )


def step(prepared: PreparedThrusters, state: ThrusterState, command: Array) -> Array:
    """Return the mean thrust (k,) [N] of each thruster over the coming step.

    Parameters
    ----------
    prepared, state : the state is updated in place
    command : (k,) [N], wanted on average over a period; sampled where a period begins. A pulse has full thrust, for as
        long as its impulse takes. A command of less than the minimum impulse gives no pulse
    """
    place = state.count % prepared.steps
    if place == 0:
        draw = state.noise.standard_normal(len(command))
        wanted = prepared.period * np.clip(command, 0.0, prepared.most_thrust)
        fired = (wanted > 0.0) & (wanted >= WHOLE * prepared.minimum_impulse)
        state.open_time[:] = np.where(fired, wanted / prepared.most_thrust, 0.0)
        state.level[:] = prepared.most_thrust * (1.0 + prepared.noise * draw)
        state.pulses += fired
    share = np.clip((state.open_time - place * prepared.step) / prepared.step, 0.0, 1.0)
    valve = state.level * share
    mean = valve + prepared.mean * (state.thrust - valve)
    state.thrust[:] = valve + prepared.decay * (state.thrust - valve)
    state.impulse += prepared.step * float(np.sum(mean))
    state.angular_impulse += prepared.step * (prepared.wrench[3:] @ mean)
    state.count += 1
    return np.asarray(mean)
