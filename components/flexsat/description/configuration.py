"""One spacecraft as the design chain takes it: structure, devices, rates, and the weights of one controller."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import combinations

import numpy as np

from ..arrays import Array
from ..controller_weights import ConfigurationName, Weights
from ..parameters import Aperture, Modes, Plate, Rates, SensorErrors, SensorNoise, Slew, SpeedSelection, Wheel
from ..variants import AS_PUBLISHED, Variant
from .appendage import Appendage
from .placement import BUS, Bus, Device, Site, Vector
from .wheel_set import WheelSet

NAME = re.compile(r"[a-z][a-z0-9_]*")  # a folder of fmus/, and a part of the models' names
FLAT = "_flat"  # ends the names of models with flat variable names
SPANNED = 1e-6  # of the volume that three axes span: less is a plane
RELEASE = AS_PUBLISHED.name  # the table of a spacecraft's file with what its release has


@dataclass(frozen=True, slots=True, kw_only=True)
class Release:
    """Differences between a published release of the design and its description, for the matrices `as_published`."""

    modes: int  # number of modes of plant and controller
    mode_rows: tuple[str, ...]  # sites whose modal motion replaces that of the structure's sites, in order
    flexible_accelerometers: bool = True  # whether accelerometers sense the motion of the modes


@dataclass(frozen=True, slots=True, kw_only=True)
class Configuration:
    """Everything that defines one spacecraft with one controller.

    Raises ValueError for devices at unknown sites, wheels that give no torque about some axis, or no sensors.
    """

    name: ConfigurationName
    layout: str  # of the wheels, in words
    wheel: Wheel  # every wheel that has none of its own
    weights: Weights
    sites: tuple[Site, ...]  # beside the bus
    wheels: tuple[Device, ...]
    gyros: tuple[Device, ...]
    accelerometers: tuple[Device, ...]
    bus: Bus = field(default_factory=Bus)
    aperture: Aperture | None = field(default_factory=Aperture)  # None: there is none
    plate: Plate = field(default_factory=Plate)
    appendages: tuple[Appendage, ...] = ()
    modes: Modes = field(default_factory=Modes)
    noise: SensorNoise = field(default_factory=SensorNoise)
    sensor_errors: SensorErrors = field(default_factory=SensorErrors)
    rates: Rates = field(default_factory=Rates)
    slew: Slew = field(default_factory=Slew)
    speeds: SpeedSelection = field(default_factory=SpeedSelection)
    release: Release | None = None  # None: nothing of it was published

    def __post_init__(self) -> None:
        check_name(self.name)
        names = [site.name for site in self.sites]
        for name in names:
            if name == BUS or names.count(name) > 1:
                raise ValueError(f"Configuration.sites: two sites are called {name!r}; give each a name of its own")
        if self.aperture is None and not self.appendages:
            raise ValueError(
                "Configuration.appendages: there is neither an aperture nor an appendage; give one of them"
            )
        called = [one.name for one in self.appendages]
        for name in called:
            if called.count(name) > 1:
                raise ValueError(f"Configuration.appendages: two are called {name!r}; give each a name of its own")
        for kind in ("wheels", "gyros", "accelerometers"):
            self._check_devices(kind)
        axes = [device.axis for device in self.wheels]
        if max((abs(_volume(*three)) for three in combinations(axes, 3)), default=0.0) < SPANNED:
            raise ValueError(
                f"Configuration.wheels: {len(axes)} wheels give no torque about some axis; three axes at least that"
                " lie in no plane are needed"
            )
        for sensor in self.accelerometers:
            if self.site(sensor.site).on_plate and abs(sensor.axis[2]) < 1.0:
                raise ValueError(
                    f"Configuration.accelerometers: the one at {sensor.site} senses along {sensor.axis}; on the"
                    " aperture, which moves along z, they sense along +z or -z"
                )
        if self.release is not None:
            known = sorted(site.name for site in self.structure_sites)
            if sorted(self.release.mode_rows) != known:
                raise ValueError(
                    "Release.mode_rows must have each site of the structure once"
                    f" ({', '.join(known)}), got {', '.join(self.release.mode_rows)}"
                )

    def _check_devices(self, kind: str) -> None:
        devices: Sequence[Device] = getattr(self, kind)
        if kind != "gyros" and any(device.of_its_own for device in devices):
            raise ValueError(f"Configuration.{kind}: noise and mounting_error are of gyros; leave them out")
        if not devices:
            raise ValueError(f"Configuration.{kind} must be at least one, got none")
        for device in devices:
            try:
                self.site(device.site)
            except ValueError as error:
                raise ValueError(f"Configuration.{kind}: {error}") from None

    @property
    def wheel_set(self) -> WheelSet:
        """What each wheel is, as arrays in the order of the wheels."""
        return WheelSet.of([device.wheel or self.wheel for device in self.wheels])

    @property
    def gyro_noise(self) -> Array:
        """The standard deviation of a sample of each gyro, (g,) [rad/s]."""
        return np.array([self.noise.gyro if device.noise is None else device.noise for device in self.gyros])

    @property
    def structure_sites(self) -> tuple[Site, ...]:
        """The sites that are nodes of the structure, in their order."""
        return tuple(site for site in self.sites if site.on_bus is None)

    @property
    def all_sites(self) -> tuple[Site, ...]:
        """The bus, then the other sites."""
        return (Site(name=BUS, on_bus=(0.0, 0.0, 0.0)), *self.sites)

    @property
    def as_described(self) -> Release:
        """What a release would have that departs from nothing."""
        return Release(modes=self.modes.plant, mode_rows=tuple(site.name for site in self.structure_sites))

    def release_for(self, variant: Variant) -> Release:
        """Return what a variant has of a release; raise ValueError for that of a spacecraft without one."""
        if not variant.of_release:
            return self.as_described
        if self.release is None:
            raise ValueError(f"{variant.name}: {self.name} has no published release; it flies without it")
        return self.release

    def site(self, name: str) -> Site:
        """Return a site by name; raise ValueError if there is none."""
        for site in self.all_sites:
            if site.name == name:
                return site
        raise ValueError(f"site {name!r}: no such site; there are {', '.join(site.name for site in self.all_sites)}")


def check_name(name: str) -> None:
    """Refuse a name of a spacecraft that cannot be part of the names of files and models."""
    if not NAME.fullmatch(name) or name.endswith(FLAT):
        raise ValueError(
            f"Configuration.name must be small letters, digits and _, beginning with a letter and not ending in {FLAT},"
            f" got {name!r}"
        )


def _volume(a: Vector, b: Vector, c: Vector) -> float:
    return a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0])
