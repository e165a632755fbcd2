"""Nominal wheel speeds: where a wheel's own imbalance excites the modes least."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy

from ..arrays import Array, Complex, Flags
from ..description.wheel_set import WheelSet
from ..parameters import RPM, SpeedSelection
from .assembly import Spacecraft

TIE = 1e-9  # relative difference of responses below which rounding would choose


@dataclass(frozen=True, slots=True, kw_only=True)
class WheelResponse:
    """Response of the modal velocities to each wheel's imbalance, over wheel speed."""

    speed: Array  # (k,) [rad/s]
    response: Array  # (n, k): peak modal velocity per unit (rad/s -> Hz)^2, [m sqrt(kg)/s Hz2]
    worst: Array  # (n, k): moving maximum over the band
    nominal: Array  # (n,) [rad/s]
    gap: Array | None = None  # (n, 2) [rad/s]: crossings either side of each band; None: they are not avoided


def imbalance_response(spacecraft: Spacecraft, frequency: Array, imbalance: Array | None = None) -> Array:
    """Return the largest singular value from a wheel's four imbalance inputs to the modal velocities, (n, k).

    Parameters
    ----------
    spacecraft : the configuration, wheels at rest (no gyroscopic terms)
    frequency : (k,) [rad/s]
    imbalance : (4 n,) of a harmonic, in the order of jitter; None: of the first
    """
    wheels, modes = spacecraft.wheel_count, spacecraft.mode_count
    mass = spacecraft.mass_matrix
    inputs = spacecraft.jitter_influence * (spacecraft.wheel_set.imbalance if imbalance is None else imbalance)
    resultant = inputs[:6].reshape(6, 4, wheels).transpose(2, 0, 1)  # (n, 6, 4)
    force, coupling = inputs[6:].reshape(modes, 4, wheels), mass[6:, :6]
    rate = 1j * frequency[:, None]
    impedance = spacecraft.frequency**2 / rate + spacecraft.damping + rate  # (k, m)

    # The modes couple to the rigid motion V alone: eta' = (force - rate coupling V) / impedance. Six equations for V
    # are left, and the squared response is made of sums over the modes that depend on frequency by a factor each.
    def summed(products: Array, factor: Array | Complex) -> Array | Complex:
        """Return sums over the modes of products (m, ...), each times a factor (k, m)."""
        return (factor @ products.reshape(modes, -1)).reshape(len(frequency), *products.shape[1:])

    own = np.einsum("miw,mjw->mwij", force, force)  # (m, n, 4, 4)
    shared = np.einsum("miw,mr->mwir", force, coupling)  # (m, n, 4, 6)
    rigid = np.einsum("mr,ms->mrs", coupling, coupling)  # (m, 6, 6)
    compliance, square = 1.0 / impedance, 1.0 / np.abs(impedance) ** 2
    w = rate[:, :, None]
    system = w * mass[:6, :6] - w**2 * summed(rigid, compliance)
    driven = resultant - w[..., None] * summed(shared, compliance).swapaxes(2, 3)  # (k, n, 6, 4)
    turned = w[..., None] * np.linalg.solve(system[:, None], driven)  # rate V of each wheel's four inputs
    crossed = summed(shared, square) @ turned  # (k, n, 4, 4)
    back = turned.conj().swapaxes(2, 3)
    squared = summed(own, square) - crossed - crossed.conj().swapaxes(2, 3)
    squared = squared + back @ summed(rigid, square)[:, None] @ turned
    # squared singular values are the eigenvalues of a 4 by 4 matrix
    return np.asarray(np.sqrt(np.linalg.eigvalsh(squared)[:, :, -1].T))


def speed_grid(selection: SpeedSelection) -> tuple[Array, int]:
    """Return the speeds that are compared, (k,) [Hz], and how many of them a band covers.

    Raises
    ------
    ValueError
        If there are no speeds between the limits, or the band is narrower than their spacing or wider than the range.
    """
    if not selection.lowest < selection.highest or selection.points < 2:
        raise ValueError(
            f"SpeedSelection: no speeds from {selection.lowest:g} to {selection.highest:g} Hz at {selection.points}"
            " points; set highest above lowest, and points to at least 2"
        )
    hertz = np.linspace(selection.lowest, selection.highest, selection.points)
    window = round(selection.window / (hertz[1] - hertz[0]))
    if not 0 < window < selection.points:
        raise ValueError(
            f"SpeedSelection.window must be at least the spacing of the speeds, {hertz[1] - hertz[0]:.4g} Hz, and less"
            f" than their range, got {selection.window:g} Hz; set points higher, or window to the width of a band"
        )
    return hertz, window


def select_speeds(
    spacecraft: Spacecraft, selection: SpeedSelection, allowed: Callable[[Array], Flags] | None = None
) -> WheelResponse:
    """Choose each wheel's nominal speed: the minimum of the response times speed squared, worst over its band.

    Source: P, section 4, and its release for the grid of 1000 speeds and the window of 50 rpm.

    Parameters
    ----------
    spacecraft : with all its modes
    selection : of speeds
    allowed : from speeds (k,) [rad/s] to which of them each wheel may have, (n, k); None: all. A wheel that may have
        none gets any

    Raises
    ------
    ValueError
        If no speed leaves a wheel's band below its speed limit.
    """
    hertz, window = speed_grid(selection)
    speed = 2.0 * np.pi * hertz
    response = _all_harmonics(spacecraft, hertz) * hertz**2
    worst = scipy.ndimage.maximum_filter1d(response, window, axis=1, mode="nearest")
    margin = int(np.ceil(window / 2)) - 1  # the band must lie inside the range
    inner = slice(margin, selection.points - margin)
    worst = _within_limits(spacecraft, speed, worst, inner)
    if allowed is not None:
        worst = np.where(allowed(speed), worst, np.inf)
    least = worst[:, inner].min(axis=1, keepdims=True)
    best = margin + np.argmax(worst[:, inner] <= (1.0 + TIE) * least, axis=1)  # the first of those alike
    return WheelResponse(speed=speed, response=response, worst=worst, nominal=speed[best])


def _all_harmonics(spacecraft: Spacecraft, hertz: Array) -> Array:
    """Return the root sum square of the responses to each harmonic, (n, k), for wheels at speeds (k,) [Hz]."""
    wheels, response = spacecraft.wheel_set, imbalance_response(spacecraft, 2.0 * np.pi * hertz)
    for order in sorted(set(wheels.harmonic_order.ravel().tolist())):
        imbalance = harmonic_imbalance(wheels, order)
        response = np.hypot(response, imbalance_response(spacecraft, order * 2.0 * np.pi * hertz, imbalance))
    return response


def harmonic_imbalance(wheels: WheelSet, order: float) -> Array:
    """Return the imbalance of the harmonics of an order beside the first, (4 n,), in the order of jitter."""
    force, torque = (
        np.sqrt(np.sum(np.where(wheels.harmonic_order == order, size, 0.0) ** 2, axis=1))
        for size in (wheels.harmonic_force, wheels.harmonic_torque)
    )
    return np.concatenate([force, force, torque, torque])


def _within_limits(spacecraft: Spacecraft, speed: Array, worst: Array, inner: slice) -> Array:
    """Return the responses (n, k), infinite at speeds (k,) [rad/s] whose band reaches a wheel's speed limit."""
    wheels = spacecraft.wheel_set
    limited = np.flatnonzero(wheels.speed_limit > 0.0)
    for k in limited.tolist():
        beyond = speed + wheels.speed_band[k] >= wheels.speed_limit[k]
        if beyond[inner].all():
            raise ValueError(
                f"Wheel.speed_limit of wheel {k + 1}, {wheels.speed_limit[k] / RPM:.4g} rpm, leaves no nominal speed:"
                f" the slowest that is considered is {speed[inner][0] / RPM:.4g} rpm, with a band of"
                f" {wheels.speed_band[k] / RPM:.4g} rpm either side; set it higher, or SpeedSelection.lowest lower"
            )
        worst = np.where((np.arange(len(worst)) == k)[:, None] & beyond, np.inf, worst)
    return worst
