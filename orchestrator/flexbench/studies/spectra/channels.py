"""What spectra are taken of: four quantities of a run, as histories whose mean square means something."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from flexsat.arrays import Array
from flexsat.parameters import ARCSECOND, DEGREE
from lockstep import Signals
from lockstep.errors import InputError

from ...runs import histories
from ...runs.run_folder import Run
from ..budget.evaluate import since_default
from .welch import LEVEL, RESOLUTION, Spectrum, estimate


@dataclass(frozen=True, slots=True, kw_only=True)
class Channel:
    """One quantity: how it is called and shown."""

    name: str
    label: str
    unit: str  # SI
    display_unit: str
    display_scale: float  # SI value of the display unit
    components: Sequence[str]  # shown on their own; empty where only the sum says anything


CHANNELS: tuple[Channel, ...] = (
    Channel(name="pointing_error", label="Pointing error", unit="rad", display_unit="arcsec",
            display_scale=ARCSECOND, components=("x", "y", "z")),
    Channel(name="rate_error", label="Rate error", unit="rad/s", display_unit="deg/s", display_scale=DEGREE,
            components=("x", "y", "z")),
    Channel(name="deformation", label="Deformation", unit="m", display_unit="µm", display_scale=1e-6, components=()),
    Channel(name="torque", label="Wheel torque", unit="N.m", display_unit="N.m", display_scale=1.0, components=()),
)  # fmt: skip
DEFINITIONS = (
    "Pointing and rate error: x, y, z in body axes, and their sum. Deformation: the sum over the modes of the density"
    " of eta / sqrt(mass), whose integral is the mean square of the RMS deformation; that of the norm itself would"
    " show every line at twice its frequency. Torque: the sum over the wheels."
)


def channel_history(signals: Signals, channel: str, mass: float) -> Array:
    """Return a channel's components over time, (rows, k), in SI.

    Parameters
    ----------
    signals : of a run
    channel : name
    mass : of the spacecraft [kg]
    """
    match channel:
        case "pointing_error":
            return histories.pointing_error_vector(signals)
        case "rate_error":
            return np.asarray(signals["plant.rate"] - signals["controller.reference.rate"])
        case "deformation":
            return np.asarray(signals["plant.modal.displacement"] / np.sqrt(mass))
        case "torque":
            return signals[histories.TORQUE]
    raise InputError(f"channel {channel!r}: no such channel; there are {', '.join(c.name for c in CHANNELS)}")


@dataclass(frozen=True, slots=True, kw_only=True)
class RunSpectra:
    """The spectra of one run, by channel."""

    start: float  # s
    duration: float  # s
    spectra: Mapping[str, Spectrum]


def run_spectra(
    run: Run, since: float | None = None, resolution: float | None = None, level: float = LEVEL
) -> RunSpectra:
    """Return the spectra of a run from `since` [s] on; None as in `budget.steady_error`.

    Without `resolution` [Hz] it is 0.05 Hz, or what gives seven segments of a shorter history.

    Raises
    ------
    InputError
        If the run is too short, or a signal was not recorded.
    """
    signals = run.samples()
    settled = None if since is not None else run.steady_since(run.loop())
    start, first, interval = since_default(run, signals.time, since, settled)
    duration = (len(signals.time) - first) * interval
    if resolution is None:
        resolution = max(RESOLUTION, 6.0 / duration)
    mass = run.flown.mass
    spectra = {
        channel.name: estimate(channel_history(signals, channel.name, mass)[first:], interval, resolution, level)
        for channel in CHANNELS
    }
    return RunSpectra(start=start, duration=duration, spectra=spectra)
