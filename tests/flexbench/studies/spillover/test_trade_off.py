"""Trade-off curves of a design: their chosen point is the design itself."""

from dataclasses import replace

import numpy as np

from flexbench.studies.margins.designed_loop import DesignedLoop
from flexbench.studies.margins.real_plant import Plants
from flexbench.studies.spillover import trade_off as curves
from flexbench.studies.spillover.trade_off import CANCELLATION, FEEDBACK, HEADER, trade_off, variations
from flexsat.description.built_in import configuration
from flexsat.design.chain import build_design
from flexsat.spacecraft.variation import ModelErrors

MODES = 40


def test_a_point_is_its_design(monkeypatch):
    """Delay against the exact margin; pointing and torque as linear analysis of the design has them."""
    monkeypatch.setattr(curves, "LOOP_FACTORS", (0.1,))
    chosen = configuration("distributed", "robust")
    point = next(trade_off(chosen, MODES, (0.02, 0.04)))
    assert (point.curve, point.factor, point.stable) == (FEEDBACK, 0.1, True)
    plants = Plants(build_design(replace(chosen, weights=replace(chosen.weights, torque=1.0))), MODES)
    loop = DesignedLoop(design=plants.design, plant=plants.model(MODES, ModelErrors()))
    reached = 0.02 / 2**curves.HALVINGS  # bisected from below
    assert all(loop.at(delay).radius() < 1.0 for delay in np.linspace(0.0, point.delay, 9))
    assert loop.at(point.delay + reached).radius() > 1.0
    assert len(point.row) == len(HEADER)


def test_one_weight_is_varied_on_each_curve():
    weights = configuration("distributed", "robust").weights
    for curve, factor, varied in variations(weights):
        name = {FEEDBACK: "torque", CANCELLATION: "jitter_cancellation"}[curve]
        assert varied == replace(weights, **{name: factor * getattr(weights, name)})
