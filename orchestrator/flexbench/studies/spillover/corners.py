"""What is required of a robust design: corners at which it must be stable, and its fine pointing."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product

from scipy.stats import qmc

from flexsat.parameters import ALL_MODES, ARCSECOND, ConfigurationName
from flexsat.spacecraft.variation import ModelErrors

from ..margins.real_plant import MODE_COUNTS, Corner

GAINS = (0.5, 2.0)  # 6 dB
PHASE = 30.0  # deg
DELAY: dict[ConfigurationName, float] = {"centralised": 0.020, "distributed": 0.010}  # s
POINTING: dict[ConfigurationName, float] = {"centralised": 0.02 * ARCSECOND, "distributed": 0.03 * ARCSECOND}  # rad
TORQUE: dict[ConfigurationName, float] = {"centralised": 0.02, "distributed": 0.06}  # N.m, of the sum over the wheels
DEFORMATION: dict[ConfigurationName, float] = {"centralised": 0.10e-6, "distributed": 0.14e-6}  # m; not the first
SMALL_INERTIA = (0.01, 0.02, 0.05)
LESS_DAMPING = (0.0, -0.25, -0.5)
ERRORS = ModelErrors(frequency=0.05, damping=0.5, inertia=0.1)


def required_corners(name: ConfigurationName, modes: int = ALL_MODES) -> Iterator[Corner]:
    """Yield the corners at which a robust design must be stable: mode counts, margins, and all errors together."""
    yield from (Corner(modes=count) for count in MODE_COUNTS if count <= modes)
    yield from (Corner(modes=modes, gain=gain) for gain in GAINS)
    yield from (Corner(modes=modes, phase=sign * PHASE) for sign in (-1.0, 1.0))
    yield from (Corner(modes=modes, delay=share * DELAY[name]) for share in (0.25, 0.5, 0.75, 1.0))
    both = (-1.0, 1.0)
    for count in sorted({25, 28, modes}):
        for frequency, damping, inertia in product(both, both, both):
            yield Corner(
                modes=count,
                errors=ModelErrors(
                    frequency=frequency * ERRORS.frequency,
                    damping=damping * ERRORS.damping,
                    inertia=inertia * ERRORS.inertia,
                ),
            )


def points_between(modes: int = ALL_MODES) -> Iterator[Corner]:
    """Yield points between the corners, which do not bound them: little inertia more, with the damping and with less.

    The modes carry nearly all inertia, so that a little more of the bus moves their coupled frequencies far: 2 % about
    each axis moves the centralised layout's first bending mode from 1.71 to 1.49 Hz, 10 % to 1.00 Hz.
    """
    for inertia, damping in product(SMALL_INERTIA, LESS_DAMPING):
        yield Corner(modes=modes, errors=ModelErrors(inertia=inertia, damping=damping))


def drawn_points(modes: int = ALL_MODES, count: int = 64, seed: int = 1) -> Iterator[Corner]:
    """Yield points within the errors of the model, as scrambled Sobol points; `count` is a power of two."""
    for share in 2.0 * qmc.Sobol(3, rng=seed).random(count) - 1.0:
        frequency, damping, inertia = (share * (ERRORS.frequency, ERRORS.damping, ERRORS.inertia)).tolist()
        yield Corner(modes=modes, errors=ModelErrors(frequency=frequency, damping=damping, inertia=inertia))
