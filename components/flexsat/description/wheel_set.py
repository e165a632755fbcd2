"""The wheels of a spacecraft as arrays: what each of them is, and as shares of the largest."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..arrays import Array, make_read_only
from ..parameters import Wheel


@dataclass(frozen=True, slots=True, kw_only=True)
class WheelSet:
    """Numbers of each wheel, (n,), as `Wheel` describes them."""

    inertia: Array  # kg.m2
    torque_limit: Array  # N.m
    speed_band: Array  # rad/s
    imbalance_force: Array  # N.s2/rad2
    imbalance_torque: Array  # N.m.s2/rad2
    broadband_force: Array  # N
    broadband_torque: Array  # N.m
    speed_limit: Array  # rad/s; 0: none
    full_torque_speed: Array  # rad/s; 0: the torque does not fall
    torque_step: Array  # N.m; 0: none
    friction_torque: Array  # N.m
    # (n, p): a row a wheel, filled up with harmonics of no size; p is the most that a wheel has
    harmonic_order: Array
    harmonic_force: Array  # N.s2/rad2
    harmonic_torque: Array  # N.m.s2/rad2
    harmonic_phase: Array  # rad

    def __post_init__(self) -> None:
        make_read_only(self)

    @classmethod
    def of(cls, wheels: Sequence[Wheel]) -> WheelSet:
        """Return the arrays of wheels in their order."""
        most = max((len(wheel.harmonics) for wheel in wheels), default=0)

        def table(name: str, fill: float) -> Array:
            rows = [[getattr(one, name) for one in wheel.harmonics] for wheel in wheels]
            return np.array([row + [fill] * (most - len(row)) for row in rows]).reshape(len(wheels), most)

        plain = ("inertia", "torque_limit", "speed_band", "imbalance_force", "imbalance_torque", "broadband_force",
                 "broadband_torque", "speed_limit", "full_torque_speed", "torque_step", "friction_torque")  # fmt: skip
        return cls(
            **{name: np.array([getattr(wheel, name) for wheel in wheels]) for name in plain},
            harmonic_order=table("order", 1.0),
            harmonic_force=table("force", 0.0),
            harmonic_torque=table("torque", 0.0),
            harmonic_phase=table("phase", 0.0),
        )

    @property
    def imbalance(self) -> Array:
        """First harmonic over speed squared, (4 n,), ordered as jitter: force a, force b, torque a, torque b."""
        return np.concatenate([self.imbalance_force] * 2 + [self.imbalance_torque] * 2)

    @property
    def broadband(self) -> Array:
        """Deviations of the broadband jitter, (4 n,), in the same order [N], [N.m]."""
        return np.concatenate([self.broadband_force] * 2 + [self.broadband_torque] * 2)

    @property
    def kinds(self) -> str:
        """The wheels in words, of each kind how many: "4 of 4.62 kg.m2 and 4.4 N.m"."""
        numbers = list(zip(self.inertia.tolist(), self.torque_limit.tolist(), strict=True))
        return ", ".join(
            f"{numbers.count(kind)} of {kind[0]:.3g} kg.m2 and {kind[1]:.3g} N.m" for kind in dict.fromkeys(numbers)
        )

    def torque_at(self, speed: Array) -> Array:
        """Return the motors' torque limits (n,) [N.m] at wheel speeds (n,) [rad/s], away from speed zero."""
        falling = self.speed_limit - self.full_torque_speed
        left = np.where(self.speed_limit > 0.0, self.speed_limit - np.abs(speed), np.inf)
        with np.errstate(divide="ignore", invalid="ignore"):
            share = np.where((self.full_torque_speed > 0.0) & (falling > 0.0), left / falling, np.sign(left))
        return np.asarray(self.torque_limit * np.clip(share, 0.0, 1.0))


def over_largest(values: Array) -> tuple[float, Array]:
    """Return the largest of values (n,) that are not negative, and their shares of it: ones where all are zero."""
    largest = float(values.max())
    return largest, values / largest if largest > 0.0 else np.ones_like(values)
