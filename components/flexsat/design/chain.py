"""Design of one configuration: from parameters to the arrays that the run-time components carry."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields, replace
from functools import lru_cache, partial
from typing import Any

import numpy as np

from ..arrays import Array, Index
from ..description.built_in import configuration
from ..description.configuration import Configuration, Release
from ..description.wheel_set import over_largest
from ..fixed_order import on_grid
from ..parameters import (
    ConfigurationName,
    Rates,
    Weights,
)
from ..runtime.controller_parameters import ControllerMatrices
from ..runtime.periods import whole_multiple
from ..runtime.plant_parameters import PlantMatrices, without_rounding
from ..runtime.sensor_parameters import SensorMatrices
from ..spacecraft.assembly import Spacecraft, build_spacecraft
from ..spacecraft.linear_model import LinearModel, linearise
from ..spacecraft.variation import keep_modes, modes_of_design, with_modes
from ..spacecraft.wheel_bands import Banded, choose_bands
from ..spacecraft.wheel_speeds import WheelResponse
from ..variants import AS_PUBLISHED, CORRECTED, PUBLISHED, Variant
from .dominant_pole import dominant_pole
from .estimator import Estimator, assumed_by_filter, design_estimator, measurement_noise
from .jitter_cancellation import MODES, jitter_torque
from .regulator import Regulator, design_regulator
from .slow_errors import slow_gains, static_deflection


@dataclass(frozen=True, slots=True, kw_only=True)
class Design:
    """Everything computed at design time for one configuration."""

    config: Configuration
    variant: Variant
    structure: Spacecraft  # the plant's, with all its modes
    spacecraft: Spacecraft  # the controller's, with the modes that it is designed with
    response: WheelResponse
    model: LinearModel
    regulator: Regulator
    coarse: Estimator
    fine: Estimator
    plant: PlantMatrices
    sensors: SensorMatrices
    controller: ControllerMatrices

    @property
    def known_modes(self) -> Index:
        """Which of the plant's modes the controller is designed with, in its order; from 0."""
        return np.arange(self.structure.mode_count)[modes_of_design(self.structure, self.config.modes)]


def plant_matrices(
    spacecraft: Spacecraft, nominal_speed: Array, step_size: float, flexible_accelerometers: bool = True
) -> PlantMatrices:
    """Return what the plant carries of a spacecraft.

    Without `flexible_accelerometers` the motion of the modes is left out of the accelerometers, as the authors'
    measurement function does for the centralised configuration (PHYSICS section 7).
    """
    wheels, wheel_set = spacecraft.wheels, spacecraft.wheel_set
    torque_limit, torque_factor = over_largest(wheel_set.torque_limit)
    deflection = np.einsum("ni,nim->nm", spacecraft.accelerometers.axis, spacecraft.accelerometers.deflection)
    if not flexible_accelerometers:
        deflection = np.zeros_like(deflection)
    turned, turning = np.cross(spacecraft.lateral_a, spacecraft.lateral_b), spacecraft.turning
    return PlantMatrices(
        mass_matrix=without_rounding(spacecraft.mass_matrix),
        frequency=spacecraft.frequency,
        damping=spacecraft.damping,
        torque_influence=spacecraft.torque_influence,
        wrench_influence=spacecraft.wrench_influence,
        lateral_influence=spacecraft.jitter_influence[:, 2 * spacecraft.wheel_count :],
        mount_of_wheel=spacecraft.mount_of_wheel,
        wheel_axis=wheels.axis,
        wheel_sense=np.sign(np.sum(turned * wheels.axis, axis=1)),
        wheel_slope=wheels.slope,
        wheel_inertia=wheel_set.inertia,
        torque_limit=torque_limit,
        torque_limit_factor=torque_factor,
        speed_limit=wheel_set.speed_limit,
        full_torque_speed=wheel_set.full_torque_speed,
        torque_step=wheel_set.torque_step,
        friction_torque=wheel_set.friction_torque,
        step_size=step_size,
        nominal_speed=nominal_speed,
        gyro_axis=spacecraft.gyros.axis,
        gyro_slope=spacecraft.gyros.axial_slope,
        accelerometer_axis=spacecraft.accelerometers.axis,
        accelerometer_position=spacecraft.accelerometers.position,
        accelerometer_deflection=deflection,
        turn_axis=turning.axis,
        turn_point=turning.point,
        turn_angle=turning.angle,
        turn_moment=turning.moment,
        turn_inertia=turning.inertia,
        mount_turn=turning.mount_turn,
        mount_position=spacecraft.mounts.position,
        mode_part=turning.mode_part,
        mount_part=turning.mount_part,
        gyro_part=turning.gyro_part,
        accelerometer_part=turning.accelerometer_part,
    )


def check_rates(rates: Rates) -> None:
    """Refuse periods between which samples would be missed, or be used later than the design assumes.

    Raises
    ------
    ValueError
        If the controller's period is no whole multiple of the plant's and the sensors', if neither of these two is one
        of the other, or if the star tracker's is none of the controller's.
    """
    quick, slow = sorted(("plant", "sensors"), key=lambda name: float(getattr(rates, name)))
    for period, step in ((slow, quick), ("controller", "plant"), ("controller", "sensors"),
                         ("star_tracker", "controller")):  # fmt: skip
        whole_multiple(f"Rates.{period}", getattr(rates, period), getattr(rates, step))


@dataclass(frozen=True, slots=True, kw_only=True)
class Basis:
    """What a design begins with: sizes and nominal values of its components. The controller has no gains yet."""

    config: Configuration
    structure: Spacecraft  # the plant's, with all its modes
    spacecraft: Spacecraft  # the controller's, with the modes that it is designed with
    response: WheelResponse
    model: LinearModel
    plant: PlantMatrices
    sensors: SensorMatrices
    controller: ControllerMatrices  # all gains empty


@lru_cache(maxsize=8)
def build_design(config: Configuration, variant: Variant = CORRECTED) -> Design:
    """Run the whole design chain of one configuration.

    Parameters
    ----------
    config : all parameters
    variant : whose slips the design has; the weights are those of `config`

    Raises
    ------
    ValueError
        For periods that do not fit together, weights without a stabilising gain, or the release of a spacecraft that
        has none.
    """
    basis = design_basis(config, variant)
    config, spacecraft, model = basis.config, basis.spacecraft, basis.model
    noise, period, wheels = config.noise, config.rates.controller, config.wheel_set
    regulator = design_regulator(spacecraft, model, config.weights, period)
    phases = whole_multiple("Rates.star_tracker", config.rates.star_tracker, period)
    assumed = assumed_by_filter(config)
    coarse, fine = (
        design_estimator(
            model,
            assumed.wheel_set.broadband,
            measurement_noise(model, assumed.noise, star_tracker, config.weights.gyro_noise * config.gyro_noise),
            config.weights.process_noise,
            period,
            phases,
            variant.broadband_through_torques,
        )
        for star_tracker in (assumed.noise.star_tracker_coarse, assumed.noise.star_tracker_fine)
    )
    against_jitter = np.zeros((spacecraft.wheel_count, 4 * spacecraft.wheel_count))
    if config.weights.jitter_cancellation > 0.0:
        quick = linearise(keep_modes(basis.structure, slice(MODES)), basis.response.nominal, noise.filter_frequency)
        against_jitter = jitter_torque(
            quick, wheels, fine, regulator.gain, model, period, config.weights.jitter_cancellation
        )
    gains: dict[str, Any] = {
        "gain_coarse": coarse.gain,
        "gain_fine": fine.gain,
        "feedback": regulator.gain,
        "jitter_torque": against_jitter,
        **slow_gains(config, spacecraft, phases, none=variant.without_slow_filters),
    }
    return Design(
        config=config,
        variant=variant,
        structure=basis.structure,
        spacecraft=spacecraft,
        response=basis.response,
        model=model,
        regulator=regulator,
        coarse=coarse,
        fine=fine,
        plant=basis.plant,
        sensors=basis.sensors,
        controller=replace(basis.controller, **gains),
    )


def design_basis(config: Configuration, variant: Variant = CORRECTED) -> Basis:
    """Return all of a design but its gains, which take most of its time; ports do not depend on them.

    Raises
    ------
    ValueError
        As `build_design`, but for weights.
    """
    check_rates(config.rates)
    release = config.release_for(variant)
    banded = _structure(replace(config, weights=Weights()), release)
    structure, response = banded.spacecraft, banded.response
    config = replace(config, wheels=banded.config.wheels)
    spacecraft = keep_modes(structure, modes_of_design(structure, config.modes))
    noise, period, wheels = config.noise, config.rates.controller, config.wheel_set
    phases = whole_multiple("Rates.star_tracker", config.rates.star_tracker, period)
    model = linearise(spacecraft, response.nominal, noise.filter_frequency)
    reference = linearise(spacecraft, response.nominal, noise.filter_frequency, gyroscopic=False)
    reference_a, reference_b = reference.rigid_and_flexible()
    shaper_frequency, shaper_damping = dominant_pole(spacecraft)
    # a motor whose torque falls with speed gives least at the top of its band: what the controller counts on
    torque_limit, torque_factor = over_largest(wheels.torque_at(np.abs(response.nominal) + wheels.speed_band))
    speed_band, band_factor = over_largest(wheels.speed_band)
    (force, force_factor), (torque, torque_imbalance_factor) = map(
        over_largest, (wheels.imbalance_force, wheels.imbalance_torque)
    )
    controller = ControllerMatrices(
        a=model.a,
        b_torque=model.b_torque,
        b_jitter=model.b_jitter,
        c=model.c,
        **dict.fromkeys(("gain_coarse", "gain_fine", "feedback", "jitter_torque"), np.zeros((0, 0))),
        b_body=model.b_body,
        **slow_gains(config, spacecraft, phases, none=True),
        deflection_of_torque=static_deflection(spacecraft),
        reference_a=reference_a,
        reference_b=reference_b,
        nominal_speed=response.nominal,
        wheel_axis=spacecraft.wheels.axis,
        wheel_inertia=wheels.inertia,
        inertia=spacecraft.inertia,
        modes=spacecraft.mode_count,
        period=period,
        shaper_frequency=shaper_frequency,
        shaper_damping=shaper_damping,
        gyros=model.gyro_count,
        accelerometers=model.index.accelerometers,
        torque_limit=torque_limit,
        speed_band=speed_band,
        imbalance_force=force,
        imbalance_torque=torque,
        authority=config.slew.authority,
        slew_start=config.slew.start_time,
        torque_limit_factor=torque_factor,
        speed_band_factor=band_factor,
        imbalance_force_factor=force_factor,
        imbalance_torque_factor=torque_imbalance_factor,
        slew_gyroscopic=config.slew.gyroscopic,
    )
    gyro_noise, gyro_noise_factor = over_largest(config.gyro_noise)
    broadband_force, broadband_force_factor = over_largest(wheels.broadband_force)
    broadband_torque, broadband_torque_factor = over_largest(wheels.broadband_torque)
    return Basis(
        config=config,
        structure=structure,
        spacecraft=spacecraft,
        response=response,
        model=model,
        plant=plant_matrices(structure, response.nominal, config.rates.plant, release.flexible_accelerometers),
        sensors=SensorMatrices(
            nominal_speed=response.nominal,
            wrench_of_jitter=spacecraft.wrench_in_mount_axes,
            gyros=model.gyro_count,
            accelerometers=model.index.accelerometers,
            gyro_axis=spacecraft.gyros.axis,
            rate_of_gyros=on_grid(np.asarray(np.linalg.pinv(spacecraft.gyros.axis), np.float64)),
            **_nominal_errors(config),
            gyro_noise=gyro_noise,
            gyro_noise_factor=gyro_noise_factor,
            gyro_mounting_error=np.array([device.mounting_error for device in config.gyros]).T.copy(),
            accelerometer_noise=noise.accelerometer,
            encoder_noise=noise.encoder,
            star_tracker_coarse=noise.star_tracker_coarse,
            star_tracker_fine=noise.star_tracker_fine,
            filter_frequency=noise.filter_frequency,
            imbalance_force=force,
            imbalance_torque=torque,
            broadband_force=broadband_force,
            broadband_torque=broadband_torque,
            imbalance_force_factor=force_factor,
            imbalance_torque_factor=torque_imbalance_factor,
            broadband_force_factor=broadband_force_factor,
            broadband_torque_factor=broadband_torque_factor,
            harmonic_order=np.ascontiguousarray(wheels.harmonic_order.T),
            harmonic_force=np.ascontiguousarray(wheels.harmonic_force.T),
            harmonic_torque=np.ascontiguousarray(wheels.harmonic_torque.T),
            harmonic_phase=np.ascontiguousarray(wheels.harmonic_phase.T),
            step_size=config.rates.sensors,
            fast_period=period,
            star_tracker_period=config.rates.star_tracker,
        ),
        controller=controller,
    )


def _nominal_errors(config: Configuration) -> dict[str, Any]:
    """Return the errors of a spacecraft's sensors by the names of their matrices."""
    values = {item.name: getattr(config.sensor_errors, item.name) for item in fields(config.sensor_errors)}
    return {name: np.array(value) if isinstance(value, tuple) else value for name, value in values.items()}


@lru_cache(maxsize=4)  # the controllers of a configuration share it
def _structure(config: Configuration, release: Release) -> Banded:
    """Return the plant's spacecraft and the wheel speeds at which it is quiet; the weights do not matter."""
    return choose_bands(config, build_spacecraft(config, release))


def as_arrays(matrices: PlantMatrices | SensorMatrices | ControllerMatrices, prefix: str) -> dict[str, Array]:
    """Return a matrix set as named arrays for an `.npz`, each name with the prefix."""
    return {f"{prefix}.{f.name}": np.asarray(getattr(matrices, f.name)) for f in fields(matrices)}


def cost_arrays(design: Design) -> dict[str, Array | Index]:
    """Return what the regulator's cost of a recorded run is computed with, as named arrays.

    `basis` (s, c), `state_weight` (c, c) and `torque_weight` (n, n) of the regulator; `modes` (k,): the plant's modes
    that the controller knows.
    """
    arrays = {name: getattr(design.regulator, name) for name in ("basis", "state_weight", "torque_weight")}
    return {**arrays, "modes": design.known_modes}


class Designs:
    """What one configuration can fly: two controllers on the full structure, and what was published, if anything was.

    Each variant is given, or made when it is first asked for: most uses need one of them.
    """

    def __init__(self, variants: Mapping[Variant, Design | Callable[[], Design]]) -> None:
        self._made = dict(variants)

    @property
    def corrected(self) -> Design:
        """With the robust controller."""
        return self.variant(CORRECTED)

    @property
    def published(self) -> Design:
        """The published controller on the same plant, at the same wheel speeds."""
        return self.variant(PUBLISHED)

    @property
    def variants(self) -> tuple[Variant, ...]:
        """What there is: not the release of a spacecraft that was not published."""
        return tuple(self._made)

    def variant(self, variant: Variant) -> Design:
        """Return the design of a variant, made now if it has not been; raise ValueError if there is none."""
        if variant not in self._made:
            raise ValueError(f"{variant.name}: {self.corrected.config.name} has no published release; there are"
                             f" {', '.join(one.name for one in self._made)}")  # fmt: skip
        made = self._made[variant]
        if not isinstance(made, Design):
            made = self._made[variant] = made()
        return made


@lru_cache(maxsize=2)  # both configurations
def build_designs(name: ConfigurationName) -> Designs:
    """Run the design chain for everything that a built-in configuration can fly; raise ValueError for other names."""
    return designs_of(configuration(name, "robust"), configuration(name, "published"))


def designs_of(robust: Configuration, published: Configuration) -> Designs:
    """Return what two configurations can fly that differ in the weights of their controllers."""
    flown = {CORRECTED: robust, PUBLISHED: published}
    if published.release is not None:
        flown[AS_PUBLISHED] = with_modes(published, published.release.modes)
    return Designs({variant: partial(build_design, config, variant) for variant, config in flown.items()})
