"""Compute the histories shown first, errors, deformation and effort, as far as their signals were recorded."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from flexbench.runs import histories
from flexbench.runs.flown_design import FlownDesign
from flexbench.runs.run_folder import Run
from flexsat.arrays import Array
from flexsat.parameters import ARCSECOND, DEGREE, RPM
from lockstep import InputError, Signals
from lockstep.array_names import elements_of

ERRORS = (histories.ATTITUDE, histories.ATTITUDE_REFERENCE)
RATES = ("plant.rate", "controller.reference.rate")
MODAL, MODAL_RATE, SPEED = "plant.modal.displacement", "plant.modal.velocity", "plant.wheel.speed"


@dataclass(frozen=True, slots=True, kw_only=True)
class DerivedHistory:
    """A history computed from recorded signals, in the unit that is printed."""

    name: str
    unit: str
    description: str
    values: Array  # (rows,) or (rows, n)
    elements: tuple[str, ...] = ()  # names of the n


def fully_recorded(signals: Signals, design: FlownDesign | None, *names: str) -> bool:
    """Return whether all elements of these arrays were recorded: a part of an array has no norm.

    None for a design that is lost: then how many wheels and modes there are is not known.
    """
    counts = {name: len("xyz") for name in names}
    if design is not None:
        recorded = len(elements_of(MODAL, signals.columns))  # the plant has ports for modes that a variant lacks
        modes = max(design.modes, recorded)
        counts |= {histories.TORQUE: design.wheels, SPEED: design.wheels, MODAL: modes, MODAL_RATE: modes}
    elif {histories.TORQUE, SPEED, MODAL, MODAL_RATE} & set(names):
        return False
    return all(len(elements_of(name, signals.columns)) == counts[name] for name in names)


def design_of(run: Run) -> FlownDesign | None:
    """Return the design that a run flew, None if it is lost."""
    try:
        return run.flown
    except InputError:
        return None


def derived_histories(signals: Signals, run: Run | None) -> Iterator[DerivedHistory]:
    """Yield the derived histories that the recorded signals allow; none for a system that is not flexsat's."""
    if run is None:
        return
    design = design_of(run)
    if fully_recorded(signals, design, *ERRORS):
        yield DerivedHistory(
            name="pointing error",
            unit="arcsec",
            description="angle between attitude and reference",
            values=histories.pointing_error(signals) / ARCSECOND,
        )
        yield DerivedHistory(
            name="pointing error about body axes",
            unit="arcsec",
            description="rotation from reference to attitude",
            values=histories.pointing_error_vector(signals) / ARCSECOND,
            elements=("x", "y", "z"),
        )
    if fully_recorded(signals, design, *RATES):
        yield DerivedHistory(
            name="rate error",
            unit="deg/s",
            description="norm of body rate less reference",
            values=histories.rate_error(signals) / DEGREE,
        )
    if "plant.rms_deformation" in signals:
        yield DerivedHistory(
            name="deformation",
            unit="µm",
            description="RMS deflection of the structure, mass-weighted",
            values=histories.deformation(signals) * 1e6,
        )
    if fully_recorded(signals, design, histories.TORQUE):
        yield DerivedHistory(
            name="torque, sum over wheels",
            unit="N.m",
            description="sum over the wheels of |commanded torque|",
            values=histories.torque_norm(signals),
        )
    if design is not None and fully_recorded(signals, design, SPEED, "plant.rate", MODAL_RATE):
        deviation = histories.wheel_speed_deviation(signals, design) / RPM
        yield DerivedHistory(
            name="wheel speed less nominal",
            unit="rpm",
            description="inertial speed about each wheel's axis, less the nominal one",
            values=deviation,
            elements=tuple(str(wheel + 1) for wheel in range(deviation.shape[1])),
        )
