"""Numbers of a campaign in text: the unit in which a metric is shown, and as many digits of bounds as of values."""

import math
import re

import numpy as np
import pytest

from flexbench.campaign.statistics.evaluation import evaluate
from flexbench.campaign.statistics.sample import Metric, Sample
from flexbench.campaign.statistics.tables import metric_table, run_text

ARCSECOND = math.pi / 648000.0
POINTING = Metric(name="pointing", unit="rad", shown_unit="arcsec", scale=ARCSECOND)


@pytest.mark.parametrize(
    ("value", "text"),
    [(0.12345678 * ARCSECOND, "0.1235 arcsec"), (None, "none"), (math.inf, "never"), (0.0, "0 arcsec")],
)
def test_a_metric_of_one_run_has_the_unit_in_which_it_is_shown(value, text):
    assert run_text(value, POINTING) == text


def test_a_metric_without_a_unit_is_a_number():
    assert run_text(2.0, Metric(name="count", unit="")) == "2"


def test_bounds_have_the_digits_of_values():
    values = (1.0 + np.sqrt(np.arange(1.0, 401.0)) / 100.0) * ARCSECOND  # 1.01 to 1.2 arcsec
    sample = Sample(
        system="one",
        numbers=np.arange(1, 401),
        inputs={},
        choices={},
        units={},
        metrics={"pointing": values},
        causes=[""] * 400,
    )
    ((*_, percentile, worst, _),) = metric_table([evaluate(sample, [POINTING], [])])[1]

    assert worst == "1.2"
    assert re.fullmatch(r"p95 1\.\d{3} \(1\.\d{3} to 1\.\d{3}\)", percentile), percentile
