"""Read the design that a run flew from the FMUs that flew, and keep it beside the results as design.npz.

Metrics, figures and reports take wheels, modes and weights from here: a plant with other matrices has its own numbers.
"""

from __future__ import annotations

import hashlib
import io
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flexsat.arrays import Array, Index
from flexsat.design.chain import Design, cost_arrays
from flexsat.fmu.python.load_matrices import COST, MODEL_FILE
from flexsat.fmu.reproducible_zip import npz_bytes
from flexsat.runtime.slew_guidance import Profile, plan
from flexsat.variants import VARIANT_PORT, Variant, chosen_by
from lockstep import InputError
from lockstep.results.read_run_record import read_run_record
from lockstep.whole_file import write_whole

from .commands import Command
from .loop_names import LoopNames, loop_names

FILE = "design.npz"
SAME = 1e-6  # of the largest element: designs on two processors differ by 1e-9


@dataclass(frozen=True, slots=True, kw_only=True)
class CostWeights:
    """What the regulator weighs, as designed."""

    basis: Array  # (r, c): of the regulated states
    state_weight: Array  # (c, c)
    torque_weight: Array  # (n, n)
    modes: Index  # (k,): which modes of the plant are those of the controller


@dataclass(frozen=True, slots=True, kw_only=True)
class FlownDesign:
    """The part of a design that recorded signals are evaluated with. `m` modes and `n` wheels of the plant."""

    variant: Variant  # of the plant
    nominal_speed: Array  # (n,) [rad/s]
    wheel_axis: Array  # (n, 3)
    wheel_axial_slope: Array  # (n, m) [rad/(m sqrt(kg))]: rotation about the wheel's axis
    rotation: Array  # (3, m) [m sqrt(kg)]: coupling of the modes to rotation
    frequency: Array  # (m,) [rad/s]
    damping: Array  # (m,) [1/s]
    mass: float  # kg
    inertia: Array  # (3, 3) [kg.m2]
    torque_limit: Array  # (n,) [N.m] of each motor of the plant; NaN where an earlier version kept none
    speed_band: float  # rad/s either side of nominal; NaN for a controller of others
    period: float  # s, of the controller; NaN for one of others
    # of the controller's slew plan; NaN for one of others, and for one that plans for unequal wheels or keep-out cones
    slew_inertia: Array  # (3, 3) [kg.m2]
    slew_torque: Array  # (3,) [N.m]: that a slew may use about each body axis
    slew_momentum: Array  # (3,) [N.m.s]
    cost: CostWeights | None  # None: a controller of others, or an FMU of an earlier version

    @property
    def modes(self) -> int:
        """Number of modes of the plant."""
        return len(self.frequency)

    @property
    def wheels(self) -> int:
        """Number of wheels."""
        return len(self.wheel_axis)

    @property
    def known_modes(self) -> Index:
        """Which modes of the plant the controller is designed with, (k,); all for a controller of others."""
        return np.arange(self.modes) if self.cost is None else self.cost.modes

    def weights(self) -> CostWeights:
        """Return the regulator's weights; raise InputError if there are none."""
        if self.cost is None:
            raise InputError("LQR cost: the run's controller carries no weights of a regulator")
        return self.cost


_ARRAYS = tuple(f.name for f in fields(FlownDesign) if f.name not in ("variant", "cost"))  # in design.npz by name


def flown_part(design: Design) -> FlownDesign:
    """Return the part of a whole design that recorded signals are evaluated with."""
    plant, controller = design.plant, design.controller
    return _flown(
        {f.name: np.asarray(getattr(plant, f.name)) for f in fields(plant)},
        {f.name: np.asarray(getattr(controller, f.name)) for f in fields(controller)}
        | {f"{COST}.{name}": values for name, values in cost_arrays(design).items()},
        {},
        {},
        design.variant,
    )


def read_flown(folder: Path) -> FlownDesign:
    """Return the design that a run flew: as kept in its folder, or else from its FMUs.

    Raises
    ------
    InputError
        If the run has no plant of flexsat, or its FMUs have changed since and it keeps no design.
    """
    kept = folder / FILE
    if kept.is_file():
        return _read_kept(kept)
    record, _ = read_run_record(folder)
    names = loop_names(record)
    if names is None:
        raise InputError(f"{folder}: not a run of a flexsat system, whose plant is called plant_<configuration>")
    return _of_fmus(folder, record, names)


def keep_flown(folder: Path) -> None:
    """Write design.npz to a run's folder, from the FMUs that flew; nothing if they cannot be read any more."""
    record, _ = read_run_record(folder)
    names = loop_names(record)
    if names is None:
        return
    try:
        design = _of_fmus(folder, record, names)
    except InputError:
        return
    write_flown(folder, design)


def write_flown(folder: Path, design: FlownDesign) -> None:
    """Write design.npz to a run's folder."""
    arrays = {name: np.asarray(value) for name, value in design.variant.switch.items()}
    arrays |= {name: np.asarray(getattr(design, name)) for name in _ARRAYS}
    if design.cost is not None:
        arrays |= {f"{COST}.{f.name}": np.asarray(getattr(design.cost, f.name)) for f in fields(CostWeights)}
    write_whole(folder / FILE, npz_bytes(arrays))


def _read_kept(path: Path) -> FlownDesign:
    try:
        with np.load(path) as archive:
            arrays = dict(archive)
    except (OSError, ValueError, zipfile.BadZipFile) as error:
        raise InputError(f"{path}: cannot be read ({error}); delete it, the FMUs that flew have the same") from None
    if "nominal_speed" in arrays:  # earlier versions kept no limits
        arrays.setdefault("torque_limit", np.full_like(arrays["nominal_speed"], np.nan))
    if lacking := [name for name in (VARIANT_PORT, *_ARRAYS) if name not in arrays]:
        raise InputError(f"{path}: has no {lacking[0]}; delete it, the FMUs that flew have the same")
    values: dict[str, Any] = {name: arrays[name] if arrays[name].ndim else arrays[name].item() for name in _ARRAYS}
    return FlownDesign(**values, variant=chosen_by(arrays.get), cost=_weights(arrays))


def _of_fmus(folder: Path, record: Mapping[str, Any], names: LoopNames) -> FlownDesign:
    components = {component["name"]: component for component in record["component"]}
    plant = components[names.plant]
    given = plant.get("parameters", {})
    variant = chosen_by(given.get)
    matrices = _matrices(folder, plant, variant)
    controller = components.get(names.controller or "", {})
    set_to = controller.get("parameters", {})
    own: dict[str, NDArray[Any]] = {}
    if str(controller.get("model", "")).removesuffix("_flat") == f"controller_{names.configuration}":
        own = _matrices(folder, controller, chosen_by(set_to.get, set_to.get("design")))
    return _flown(matrices, own, given, set_to, variant)


def _matrices(folder: Path, component: Mapping[str, Any], variant: Variant) -> dict[str, NDArray[Any]]:
    """Return the matrices of a variant that a component's FMU carries; raise InputError if it is not what flew."""
    path, name = Path(component["source"]), component["name"]
    remedy = f"{folder} keeps no {FILE} either; simulate again"
    try:
        content = path.read_bytes()
    except OSError:
        raise InputError(f"{path}: the FMU of {name} that flew is gone, and {remedy}") from None
    if hashlib.sha256(content).hexdigest() != component.get("sha256"):
        raise InputError(f"{path}: has changed since it flew as {name}, and {remedy}")
    try:
        with (
            zipfile.ZipFile(io.BytesIO(content)) as archive,
            np.load(io.BytesIO(archive.read(f"resources/{MODEL_FILE}"))) as arrays,
        ):
            prefix = f"{variant.name}."
            return {key.removeprefix(prefix): arrays[key] for key in arrays.files if key.startswith(prefix)}
    except (KeyError, ValueError, zipfile.BadZipFile) as error:
        raise InputError(f"{path}: carries no matrices of {name} ({error}); build it with `flexsat build`") from None


def _flown(
    plant: Mapping[str, NDArray[Any]],
    controller: Mapping[str, NDArray[Any]],
    of_plant: Mapping[str, Any],
    parameters: Mapping[str, Any],
    variant: Variant,
) -> FlownDesign:
    try:
        mass, axis = plant["mass_matrix"], plant["wheel_axis"]
        return FlownDesign(
            variant=variant,
            nominal_speed=plant["nominal_speed"],
            wheel_axis=axis,
            wheel_axial_slope=np.einsum("ni,nim->nm", axis, plant["wheel_slope"]),
            rotation=mass[3:6, 6:],
            frequency=plant["frequency"],
            damping=plant["damping"],
            mass=float(mass[0, 0]),
            inertia=mass[3:6, 3:6],
            torque_limit=_torque_limits(plant, of_plant),
            speed_band=float(parameters.get("wheel.speed_band", controller.get("speed_band", np.nan))),
            period=float(controller.get("period", np.nan)),
            **_slew_limits(controller, parameters),
            cost=_weights(controller),
        )
    except KeyError as error:
        raise InputError(f"the plant's FMU carries no {error.args[0]}; build it with `flexsat build`") from None


def _torque_limits(plant: Mapping[str, NDArray[Any]], given: Mapping[str, Any]) -> Array:
    """Return the torque limit of each wheel [N.m] as the run set it."""
    count = len(plant["nominal_speed"])
    limit = float(given.get("wheel.torque_limit", plant.get("torque_limit", np.nan)))
    factors = np.array(plant.get("torque_limit_factor", np.ones(count)), float)
    for wheel in range(count):
        factors[wheel] = float(given.get(f"wheel.torque_limit_factor[{wheel + 1}]", factors[wheel]))
    return limit * factors


def _slew_limits(controller: Mapping[str, NDArray[Any]], parameters: Mapping[str, Any]) -> dict[str, Array]:
    """Return what the controller plans slews with, as its parameters set it.

    NaN for wheels of unequal limits, and for those that are not along body axes: their torques about one do not add up.
    """
    unequal = ("wheel.torque_limit_factor", "wheel.speed_band_factor", "wheel.speed_offset", "keep_out.")
    along = "wheel_axis" in controller and np.all(np.count_nonzero(controller["wheel_axis"], axis=1) == 1)
    alike = all(
        np.ptp(controller[name]) == 0.0
        for name in ("wheel_inertia", "torque_limit_factor", "speed_band_factor")
        if name in controller
    )
    if not along or not alike or any(name.startswith(unequal) for name in parameters):
        return {
            "slew_inertia": np.full((3, 3), np.nan),
            "slew_torque": np.full(3, np.nan),
            "slew_momentum": np.full(3, np.nan),
        }

    def of_run(port: str, name: str) -> float:
        return float(parameters.get(port, controller[name]))

    capability = np.sum(np.abs(controller["wheel_axis"]), axis=0) * of_run("slew.authority", "authority")
    momentum = float(np.ravel(controller["wheel_inertia"])[0]) * of_run("wheel.speed_band", "speed_band")
    return {
        "slew_inertia": controller["inertia"],
        "slew_torque": capability * of_run("wheel.torque_limit", "torque_limit"),
        "slew_momentum": capability * momentum,
    }


def _weights(arrays: Mapping[str, NDArray[Any]]) -> CostWeights | None:
    if any(f"{COST}.{f.name}" not in arrays for f in fields(CostWeights)):
        return None
    return CostWeights(**{f.name: arrays[f"{COST}.{f.name}"] for f in fields(CostWeights)})


def planned_slew(design: FlownDesign, command: Command) -> Profile:
    """Return the rigid slew that the controller plans for a command from rest; InputError if its plan is not known.

    The feed-forward torque of the controller begins a little before it and ends a little after it.
    """
    if not np.all(np.isfinite(design.slew_torque)):
        raise InputError(
            "the slew's plan: it is known for flexsat's controller, with equal wheels along body axes and without"
            " keep-out cones only"
        )
    rotation = np.array(command.rotation)
    return plan(rotation, command.time, design.slew_inertia, design.slew_torque, design.slew_momentum)


def refuse_other_design(flown: FlownDesign, design: Design, folder: Path) -> None:
    """Raise InputError if a run flew another plant or other weights than the design of this version."""
    stock = flown_part(design)
    compared = ("nominal_speed", "wheel_axis", "frequency", "damping", "wheel_axial_slope")
    differing = [name for name in compared if not _alike(getattr(flown, name), getattr(stock, name))]
    if not differing and flown.cost is not None and stock.cost is not None:
        differing = [
            f"{COST}.{f.name}"
            for f in fields(CostWeights)
            if not _alike(getattr(flown.cost, f.name), getattr(stock.cost, f.name))
        ]
    if differing:
        raise InputError(
            f"{folder}: flew another design than this version's ({differing[0]} differs), and this needs the whole"
            " design; build the FMUs again and simulate"
        )


def _alike(one: NDArray[Any], other: NDArray[Any]) -> bool:
    """Return whether two arrays agree to the rounding of a design on another processor."""
    if one.shape != other.shape:
        return False
    return bool(np.all(np.abs(one - other) <= SAME * max(float(np.max(np.abs(other), initial=0.0)), 1e-300)))
