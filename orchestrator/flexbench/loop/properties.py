"""Describe a spacecraft in words and tables: `flexsat spacecraft`."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from flexsat.arrays import Array
from flexsat.description.configuration import Configuration
from flexsat.description.spacecraft_file import SpacecraftFile
from flexsat.parameters import DEFAULT_DESIGN, HERTZ, RPM
from flexsat.spacecraft.assembly import Spacecraft, build_spacecraft
from flexsat.spacecraft.properties import Envelope, ModeTable, envelope, mode_table
from flexsat.spacecraft.variation import modes_of_design
from flexsat.spacecraft.wheel_bands import choose_bands
from lockstep.errors import InputError

MODES_HEADER = ("mode", "clamped [Hz]", "mass x, y, z [%]", "inertia x, y, z [%]", "known", "free [Hz]",
                "wheels reach", "gyros see")  # fmt: skip
CANCELLED = 1e-3  # share of the wheels' momenta: less net momentum than this is none
ROUNDING = 1e-9  # share of the largest: less is none


@dataclass(frozen=True, slots=True, kw_only=True)
class Properties:
    """A spacecraft at its nominal wheel speeds."""

    config: Configuration
    craft: Spacecraft
    modes: ModeTable
    known: Sequence[int]  # modes of the clamped structure that the controller is designed with
    torque: Envelope  # of the wheels at their limits [N.m]
    momentum: Envelope  # of the wheels at the ends of their speed bands [N.m.s]
    nominal_speed: Array  # (n,) [rad/s]
    gap: Array | None  # (n, 2) [rad/s], crossings either side of each band, where bands avoid them
    net_momentum: Array  # (3,) [N.m.s], of all wheels at their nominal speeds


def properties_of(spacecraft: SpacecraftFile, name: str) -> Properties:
    """Return what a spacecraft is; raise InputError, which names it, if no nominal speeds can be chosen."""
    config = spacecraft.configurations[DEFAULT_DESIGN]
    try:
        banded = choose_bands(config, build_spacecraft(config))
    except ValueError as error:
        raise InputError(f"{name}: {error}") from None
    craft, nominal = banded.spacecraft, banded.response.nominal
    wheels = craft.wheel_set
    return Properties(
        config=config,
        craft=craft,
        modes=mode_table(craft),
        known=np.arange(craft.mode_count)[modes_of_design(craft, config.modes)].tolist(),
        torque=envelope(craft.wheels.axis * wheels.torque_limit[:, np.newaxis]),
        momentum=envelope(craft.wheels.axis * (wheels.inertia * wheels.speed_band)[:, np.newaxis]),
        nominal_speed=nominal,
        gap=banded.response.gap,
        net_momentum=net_momentum(craft, nominal),
    )


def net_momentum(craft: Spacecraft, nominal: Array) -> Array:
    """Return the momentum of all wheels at their nominal speeds, (3,) [N.m.s]."""
    return np.asarray((craft.wheel_set.inertia * nominal) @ craft.wheels.axis)


def bias_line(craft: Spacecraft, nominal: Array) -> str | None:
    """Return a line about net momentum of the wheels at their nominal speeds; None if it cancels."""
    net, most = net_momentum(craft, nominal), float(np.sum(craft.wheel_set.inertia * np.abs(nominal)))
    if float(np.linalg.norm(net)) <= CANCELLED * most:
        return None
    return (
        f"the wheels have a net momentum of {_vector(net)} N.m.s at their nominal speeds: slews and rates meet its"
        " gyroscopic torque; reverse axes of wheels so that it cancels, or set [slew] gyroscopic = true"
    )


def property_lines(found: Properties) -> Iterator[str]:
    """Yield lines about mass, wheels and envelopes."""
    config, craft, wheels = found.config, found.craft, found.craft.wheel_set
    sensors = f"{len(craft.gyros.axis)} gyros, {len(craft.accelerometers.axis)} accelerometers"
    yield f"{config.name}: {config.layout}; {sensors}"
    yield f"mass {craft.mass:.6g} kg, of which bus {config.bus.mass:.6g} kg"
    yield f"centre of mass {_vector(craft.centre)} m from the origin"
    moments, products = np.diag(craft.inertia), craft.inertia[[0, 0, 1], [1, 2, 2]]
    products = np.where(np.abs(products) < ROUNDING * moments.max(), 0.0, products)
    yield f"inertia about it xx, yy, zz {_vector(moments, 6)} kg.m2; xy, xz, yz {_vector(products, 6)}"
    speeds = found.nominal_speed / RPM
    band = _span(wheels.speed_band / RPM, 1)
    yield f"nominal wheel speeds {speeds.min():.1f} to {speeds.max():.1f} rpm, +-{band} rpm"
    yield from _gap_lines(found)
    yield f"net momentum of the wheels there {_vector(found.net_momentum)} N.m.s"
    for what, unit, reach in (("torque", "N.m", found.torque), ("momentum", "N.m.s", found.momentum)):
        yield (
            f"{what} about x, y, z {_vector(reach.about)} {unit}; in any direction {reach.weakest:.4g}"
            f" {unit}, weakest along {_vector(reach.direction)}"
        )
    if (line := bias_line(craft, found.nominal_speed)) is not None:
        yield f"note: {line}"
    modes = found.modes
    share = [_vector(100.0 * part.sum(axis=1)) for part in (modes.effective_mass, modes.effective_inertia)]
    yield f"all {craft.mode_count} modes: effective mass x, y, z {share[0]} %, effective inertia {share[1]} %"


def _gap_lines(found: Properties) -> Iterator[str]:
    """Yield a line for the wheels of each gap between crossings, where bands avoid them."""
    if found.gap is None:
        return
    bands, texts = found.craft.wheel_set.speed_band / RPM, dict[str, list[int]]()
    for k, (speed, gap) in enumerate(zip(found.nominal_speed / RPM, found.gap / RPM, strict=True)):
        text = f"{speed:.1f} +-{bands[k]:.1f} rpm, between {gap[0]:.1f} and {gap[1]:.1f} rpm"
        texts.setdefault(text, []).append(k + 1)
    for text, numbers in texts.items():
        yield f"wheel{'s' if len(numbers) > 1 else ''} {', '.join(map(str, numbers))}: {text}"


def mode_rows(found: Properties, count: int) -> Iterator[tuple[str, ...]]:
    """Yield the rows of the lowest modes; clamped and free ones stand in the order of their frequencies."""
    modes = found.modes
    for k in range(min(count, found.craft.mode_count)):
        yield (
            str(k + 1),
            f"{modes.clamped[k] / HERTZ:.4f}",
            _vector(100.0 * modes.effective_mass[:, k], 2),
            _vector(100.0 * modes.effective_inertia[:, k], 2),
            "yes" if k in found.known else "",
            f"{modes.free[k] / HERTZ:.4f}",
            _share(modes.controllability[k]),
            _share(modes.observability[k]),
        )


def _span(values: Array, digits: int) -> str:
    """Return numbers of all wheels as one, or as the least and the largest."""
    least, largest = (f"{value:.{digits}f}" for value in (values.min(), values.max()))
    return least if least == largest else f"{least} to {largest}"


def _share(value: float) -> str:
    return "0" if value < ROUNDING else f"{value:.2g}"


def _vector(values: Array, digits: int = 4) -> str:
    rounded = np.where(np.abs(values) < ROUNDING * max(1.0, float(np.max(np.abs(values)))), 0.0, values)
    return ", ".join(f"{value:.{digits}g}" for value in rounded.tolist())
