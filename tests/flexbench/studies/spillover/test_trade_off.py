"""Trade-off curves of a design: their chosen point is the design itself."""

from dataclasses import replace

import pytest

from flexbench.studies.margins.designed_loop import DesignedLoop
from flexbench.studies.margins.stability import delay_margin
from flexbench.studies.spillover import trade_off as curves
from flexbench.studies.spillover.trade_off import CANCELLATION, FEEDBACK, HEADER, trade_off, variations
from flexsat.description.built_in import configuration
from flexsat.parameters import ARCSECOND
from flexsat.spacecraft.variation import ModelErrors

MODES = 40


def test_the_chosen_point_is_the_design(robust, monkeypatch):
    """Delay against the exact margin; pointing and torque as linear analysis of the design has them."""
    monkeypatch.setattr(curves, "LOOP_FACTORS", (1.0,))
    plants = robust["centralised"]
    point = next(trade_off(configuration("centralised", "robust"), MODES, (0.04, 0.06, 0.08)))
    assert (point.curve, point.factor, point.stable) == (FEEDBACK, 1.0, True)
    loop = DesignedLoop(design=plants.design, plant=plants.model(MODES, ModelErrors()))
    exact = delay_margin(lambda extra: loop.at(0.05 + extra))
    assert 0.0 <= 0.05 + exact - point.delay <= 0.02 / 2**curves.HALVINGS  # bisected from below
    assert point.settled.pointing / ARCSECOND == pytest.approx(0.0189, abs=0.0003)
    assert len(point.row) == len(HEADER)


def test_one_weight_is_varied_on_each_curve():
    weights = configuration("distributed", "robust").weights
    for curve, factor, varied in variations(weights):
        name = {FEEDBACK: "torque", CANCELLATION: "jitter_cancellation"}[curve]
        assert varied == replace(weights, **{name: factor * getattr(weights, name)})
