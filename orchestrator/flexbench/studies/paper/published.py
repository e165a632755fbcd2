"""The paper's results table, and what is known of how its numbers came about.

Source: P, Cachim et al., IEEE Aerospace 2025 (arXiv 2410.07376), its results table; C, the authors' public release.
Nothing here is read by a simulation.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from flexsat import variants
from flexsat.description.built_in import CONFIGURATIONS
from flexsat.parameters import ConfigurationName

# Hz, of the structure clamped at the hole: the authors' own finite elements (public release), four digits
MODE_FREQUENCIES: tuple[float, ...] = (
    0.3441, 0.3441, 0.4117, 0.5285, 0.5285, 1.026, 1.245, 1.917, 1.917, 2.158, 2.286, 2.286, 3.076, 3.076, 3.146,
    3.146, 3.881, 3.944, 4.156, 4.606, 5.05, 5.05, 5.41, 5.41, 5.966,
)  # fmt: skip

# The last is the published controller on the corrected plant, in fine pointing alone: to see when its loop is lost
VariantName = Literal["as_published", "corrected", "published_design"]
VARIANTS: tuple[VariantName, ...] = ("as_published", "corrected", "published_design")
TITLES: Mapping[VariantName, str] = {
    "as_published": "as published",
    "corrected": "corrected, robust",
    "published_design": "corrected, published design",
}
JUDGED: VariantName = "as_published"  # against the paper
FLOWN: Mapping[VariantName, variants.Variant] = {
    "as_published": variants.AS_PUBLISHED,
    "corrected": variants.CORRECTED,
    "published_design": variants.PUBLISHED,
}


@dataclass(frozen=True, slots=True, kw_only=True)
class PaperRow:
    """One row of the table. Values are (centralised, distributed), in the printed unit."""

    key: str  # name in metrics.json
    scenario: str
    label: str
    unit: str
    scale: float  # from SI to the printed unit
    published: tuple[float, float]
    definition: str
    note: str = ""
    of_whole_run: bool = False  # refers to runs of 300 s

    def published_for(self, name: ConfigurationName) -> float:
        """Return the paper's value; not a number for a spacecraft that is not the paper's."""
        return self.published[CONFIGURATIONS.index(name)] if name in CONFIGURATIONS else math.nan


_DEG = 57.29577951308232
_ARCSEC = 3600.0 * _DEG

ROWS: tuple[PaperRow, ...] = (
    PaperRow(
        key="total_cost",
        scenario="slew",
        label="slew: total cost",
        unit="1",
        scale=1.0,
        published=(1.9e4, 461.0),
        definition="half the plain sum of the LQR cost over 200 Hz samples, no dt; weights of the design that flew",
        of_whole_run=True,
    ),
    PaperRow(
        key="control_cost",
        scenario="slew",
        label="slew: control cost",
        unit="1",
        scale=1.0,
        published=(34.0, 219.0),
        definition="its torque part",
        note="not reproduced by any variant tried, nor with the authors' own matrices (202 / 37)",
        of_whole_run=True,
    ),
    PaperRow(
        key="settling_time",
        scenario="slew",
        label="slew: settling",
        unit="s",
        scale=1.0,
        published=(100.0, 30.0),
        definition="from the end of the slew until the pointing error stays below 3 RMS of the last 50 s",
        of_whole_run=True,
    ),
    PaperRow(
        key="pointing_error",
        scenario="slew",
        label="slew: pointing error",
        unit="arcsec",
        scale=_ARCSEC,
        published=(49.0, 1.8),
        definition="RMS for t > 150 s of the angle between attitude and reference",
    ),
    PaperRow(
        key="rate_error",
        scenario="slew",
        label="slew: rate error",
        unit="deg/s",
        scale=_DEG,
        published=(1.1e-3, 1.1e-4),
        definition="RMS for t > 150 s; as published: RMS over 75 to 150 s, divided by sqrt 2",
    ),
    PaperRow(
        key="deformation",
        scenario="slew",
        label="slew: deformation",
        unit="µm",
        scale=1e6,
        published=(2.3, 0.33),
        definition="as the rate error's, of the RMS deformation of the structure",
    ),
    PaperRow(
        key="torque",
        scenario="fine_pointing",
        label="fine pointing: torque",
        unit="N.m",
        scale=1.0,
        published=(0.083, 0.24),
        definition="RMS for t > 150 s of the sum of |torque| over the wheels",
        note="the release divides by all samples instead of those after 150 s: that is 0.71 of this",
    ),
    PaperRow(
        key="pointing_error",
        scenario="fine_pointing",
        label="fine pointing: error",
        unit="arcsec",
        scale=_ARCSEC,
        published=(0.068, 0.038),
        definition="RMS for t > 150 s",
    ),
    PaperRow(
        key="rate_error",
        scenario="fine_pointing",
        label="fine pointing: rate",
        unit="deg/s",
        scale=_DEG,
        published=(3.0e-5, 2.5e-5),
        definition="RMS for t > 150 s",
    ),
    PaperRow(
        key="deformation",
        scenario="fine_pointing",
        label="deformation, closed loop",
        unit="µm",
        scale=1e6,
        published=(0.27, 0.15),
        definition="RMS for t > 150 s",
    ),
    PaperRow(
        key="deformation",
        scenario="fine_pointing_open_loop",
        label="deformation, open loop",
        unit="µm",
        scale=1e6,
        published=(0.27, 0.33),
        definition="RMS for t > 150 s, no torque commanded",
    ),
)
REMARKS = (
    "Control cost: the two published values were not reproduced by any variant tried, nor was the distributed total,"
    " with the authors' own matrices either (202 and 37 against 34 and 219; 247 against 461). The two exchanged would"
    " agree within 10 %. No single set of weights gives all rows: they seem to come from runs with different weights.",
    "Rate in fine pointing: the norm of the measured rate of the bus gyros is 2.83e-5 and 2.39e-5 deg/s, within 6 % of"
    " the published 3.0e-5 and 2.5e-5; the true rate, shown here, is smaller.",
    "Rate and deformation after the slew: the authors' public release cannot print these two rows. The RMS over 75 to"
    " 150 s divided by sqrt 2 fits both layouts within 10 %; it is a fit, not a line of the release.",
    "Slews are simulated without wheel jitter, as in the authors' release.",
    "As published: plant and controller share 25 modes; order of mode rows, zero wheel phases, smoothed slew reference,"
    " 1 arcsec initial error on each axis, and the definitions above. Corrected: the plant has the 198 modes below"
    " 80 Hz, wheel speeds are chosen on them; one order, random phases, time-optimal reference.",
    "With random wheel phases the deformation of the centralised spacecraft scatters from seed to seed.",
)
