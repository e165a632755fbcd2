"""The variants that a spacecraft is built in: one set of matrices each, and the slips of a release that belong to it.

The parameters `as_published` and `design` of the FMUs choose one here, and nowhere else; whatever is downstream takes
the variant, or the matrices that were made for it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from .controller_weights import DEFAULT_DESIGN, ControllerDesign
from .parameters import ARCSECOND

VARIANT_PORT = "as_published"  # parameter of plant, sensors and controller


@dataclass(frozen=True, slots=True, kw_only=True)
class Variant:
    """One set of matrices, and how a run with it begins: a column of the table in PHYSICS section 7.

    By default without slips. What else a release has of its own for one spacecraft is in that one's `Release`.
    """

    name: str  # of its arrays in an FMU, and of its constants in C
    label: str  # of plant and sensors, in tables
    flown: str  # what flies with it, in a sentence
    mark: str = ""  # in the names of results
    of_release: bool = False  # with what the spacecraft's release has of its own
    broadband_through_torques: bool = False  # broadband jitter enters the filter's model by the first inputs
    without_slow_filters: bool = False  # of external torque and gyro biases
    linear_attitude: bool = False  # attitudes are sums of a quarter of the angle
    accelerometer_noise_is_gyros: bool = False  # the gyros' number, read in m/s2
    random_wheel_phases: bool = True  # at the start
    smoothed_slews: bool = False  # the modes at rest, instead of time-optimal
    attitude_deviation: float = 0.1 * ARCSECOND  # rad about each axis, random, where fine pointing begins
    attitude_offset: float = 0.0  # rad about each axis, where fine pointing begins

    @property
    def switch(self) -> Mapping[str, bool]:
        """The parameter that chooses it, by name: in FMUs, and in the files that runs and studies leave."""
        return {VARIANT_PORT: self.of_release}

    def lacking(self, array: str, file: str) -> str:
        """Return the message of a component that has not this array of the variant."""
        if self.of_release:
            return f"{VARIANT_PORT}: this spacecraft has no published release; set it to false"
        return f"{file}: no array {array!r}; build the FMU again"


CORRECTED = Variant(name="corrected", label="corrected", flown="robust design")
# the published controller on the same plant with the same sensors, which have no matrices of their own for it
PUBLISHED = Variant(name="published", label="corrected", flown="published design")
AS_PUBLISHED = Variant(
    name="as_published",
    label="as published",
    flown="as published",
    mark="-as-published",
    of_release=True,
    broadband_through_torques=True,
    without_slow_filters=True,
    linear_attitude=True,
    accelerometer_noise_is_gyros=True,
    random_wheel_phases=False,
    smoothed_slews=True,
    attitude_deviation=0.0,
    attitude_offset=1.0 * ARCSECOND,
)
VARIANTS = (CORRECTED, PUBLISHED, AS_PUBLISHED)
OF_DESIGN: Mapping[ControllerDesign, Variant] = {"robust": CORRECTED, "published": PUBLISHED}


def chosen_by(value: Callable[[str], Any], design: object = DEFAULT_DESIGN) -> Variant:
    """Return the variant that the parameters of a component choose: the release goes before the design.

    Parameters
    ----------
    value : gives the value of a parameter; None for one that is not set
    design : the controller's parameter of this name
    """
    if value(VARIANT_PORT):
        return AS_PUBLISHED
    return PUBLISHED if design == "published" else CORRECTED
