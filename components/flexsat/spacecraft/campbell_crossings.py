"""Crossings of the Campbell diagram: wheel speeds at which a harmonic of the imbalance meets a mode.

Modes are those of the free spacecraft, for the gyroscopic terms with all wheels at one common speed.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arrays import Array, make_read_only
from .assembly import RIGID, Spacecraft
from .wheel_speeds import harmonic_imbalance, imbalance_response

REDUCED = 2.0  # modes further away than this factor change a frequency by less than 2e-4 of it
GRID = 24  # speeds at which modes are computed; their frequencies are taken as straight between


def modal_frequencies(spacecraft: Spacecraft, speed: Array, highest: float = np.inf) -> Array:
    """Return the damped frequencies of the flexible modes of the free spacecraft, (m, k) [rad/s], lowest first.

    Parameters
    ----------
    spacecraft : of one configuration
    speed : (k,) [rad/s], of all wheels
    highest : [rad/s]; modes that are slower at rest are returned, computed with those up to REDUCED times as fast
    """
    from scipy.linalg import eigh  # takes longer to load than a short run takes

    stiffness = np.concatenate([np.zeros(RIGID), spacecraft.frequency**2])
    square, shapes = eigh(np.diag(stiffness), spacecraft.mass_matrix)
    at_rest = np.sqrt(square[RIGID:])
    kept = RIGID + int(np.searchsorted(at_rest, REDUCED * highest))
    count = int(np.searchsorted(at_rest, highest))
    shapes = shapes[:, :kept]
    restoring = np.diag(np.concatenate([np.zeros(RIGID), square[RIGID:kept]]))
    damping = np.diag(np.concatenate([np.zeros(RIGID), spacecraft.damping]))
    found = np.empty((count, len(speed)))
    for k, w in enumerate(speed.tolist()):
        gyroscopic = spacecraft.gyroscopic_matrix(spacecraft.wheel_set.inertia * w)
        velocity = shapes.T @ (damping + gyroscopic) @ shapes
        state = np.block([[np.zeros((kept, kept)), np.eye(kept)], [-restoring, -velocity]])
        # rigid motion and precession are slower
        found[:, k] = np.sort(np.linalg.eigvals(state).imag)[RIGID - kept :][:count]
    return found


@dataclass(frozen=True, slots=True, kw_only=True)
class Crossings:
    """Where harmonics of the wheels meet modes; in no order."""

    speed: Array  # (c,) [rad/s]
    response: Array  # (n, c): of each wheel there, as of WheelResponse.response; 0: the wheel does not excite it

    def __post_init__(self) -> None:
        make_read_only(self)

    def of_wheel(self, wheel: int, share: float) -> Array:
        """Return the speeds [rad/s] at which a wheel excites a mode by more than a share of its strongest, rising."""
        response = self.response[wheel]
        return np.sort(self.speed[response > share * response.max(initial=0.0)])


def crossings(spacecraft: Spacecraft, lowest: float, highest: float) -> Crossings:
    """Return the crossings of every harmonic of the wheels with every mode, for speeds from lowest to highest [rad/s].

    The response is that of the modal velocities at the mode's frequency at rest, times speed squared: the peak that the
    harmonic has there.
    """
    grid, orders = np.linspace(lowest, highest, GRID), _imbalance_by_order(spacecraft)
    found = modal_frequencies(spacecraft, grid, max(orders) * highest)
    at_rest = modal_frequencies(spacecraft, grid[:1] * 0.0, max(orders) * highest)[:, 0]
    speeds, responses = [np.zeros(0)], [np.zeros((spacecraft.wheel_count, 0))]
    for order, imbalance in orders.items():
        above = found - order * grid  # (m, k)
        mode, k = np.nonzero((above[:, :-1] > 0.0) != (above[:, 1:] > 0.0))
        share = above[mode, k] / (above[mode, k] - above[mode, k + 1])
        speed = grid[k] + share * (grid[k + 1] - grid[k])
        speeds.append(speed)
        responses.append(imbalance_response(spacecraft, at_rest[mode], imbalance) * (speed / (2.0 * np.pi)) ** 2)
    return Crossings(speed=np.concatenate(speeds), response=np.hstack(responses))


def _imbalance_by_order(spacecraft: Spacecraft) -> dict[float, Array]:
    """Return the imbalance (4 n,) of each harmonic by its order, the first always among them."""
    wheels = spacecraft.wheel_set
    found = {order: harmonic_imbalance(wheels, order) for order in {1.0, *wheels.harmonic_order.ravel().tolist()}}
    found[1.0] = np.hypot(found[1.0], wheels.imbalance)
    return found
