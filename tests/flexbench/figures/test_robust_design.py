"""Figures of the robust design: what is marked on them, and the command that draws them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from flexbench.cli.parser import main
from flexbench.figures import robust_design
from flexbench.figures.robust_design import trade_off_figure
from flexbench.studies.spillover import mode_choice, trade_off
from flexbench.studies.spillover.loop_shapes import LoopShape, loop_shape
from flexbench.studies.spillover.stationary import Stationary
from flexbench.studies.spillover.trade_off import CANCELLATION, FEEDBACK, Point
from flexsat.design.chain import Design
from flexsat.parameters import ARCSECOND


def point(curve: str, factor: float, delay: float, pointing: float, torque: float, deformation: float) -> Point:
    settled = Stationary(pointing=pointing * ARCSECOND, torque=torque, deformation=1e-6 * deformation)
    return Point(curve=curve, factor=factor, stable=True, delay=delay, settled=settled)


POINTS = [
    point(FEEDBACK, 0.1, 0.004, 0.018, 0.05, 0.08),
    point(FEEDBACK, 1.0, 0.0101, 0.028, 0.04, 0.08),
    Point(curve=FEEDBACK, factor=10.0, stable=False, delay=0.0, settled=None),
    point(CANCELLATION, 1.0, 0.0101, 0.028, 0.04, 0.08),
    point(CANCELLATION, 10.0, 0.0101, 0.028, 0.03, 0.11),
]


def test_the_chosen_point_and_what_is_wanted_are_marked(points: Any):
    left, right = trade_off_figure({"distributed": POINTS}).axes
    for axes, chosen, wanted in ((left, (10.1, 0.028), (10.0, 0.03)), (right, (0.04, 0.08), (0.06, 0.14))):
        assert_allclose(points(axes, "chosen"), [chosen], rtol=1e-12)
        upright, level = (line for line in axes.get_lines() if line.get_color() == "0.5")
        assert (upright.get_xdata()[0], level.get_ydata()[0]) == pytest.approx(wanted)
    assert_allclose(points(left, "varied weight, its factor"), [(4.0, 0.018), (10.1, 0.028)], rtol=1e-12)


def test_the_command_prints_the_tables_and_draws(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    """The robust loop is below one beyond 12 Hz, the published one far above: both are kept as they are drawn."""
    drawn: list[LoopShape] = []

    def kept(design: Design, _: int) -> LoopShape:
        drawn.append(loop_shape(design, 60))
        return drawn[-1]

    monkeypatch.setattr(trade_off, "robust_trade_off", lambda _: POINTS)  # a dozen designs: minutes
    monkeypatch.setattr(mode_choice, "compare_mode_choices", lambda _: [])
    monkeypatch.setattr(robust_design, "loop_shape", kept)
    out = tmp_path / "drawn"
    assert main(["figures", "--robust-design", "--configuration", "centralised", "--out", str(out)]) == 0
    assert {path.stem for path in out.iterdir()} == {"robust-trade-off", "robust-loop-shapes"}
    assert "0.0280" in capsys.readouterr().out
    robust, published = drawn
    assert np.abs(robust.axes[np.argmin(np.abs(robust.frequency - 0.003)), 0]) > 1.0
    assert np.all(np.abs(robust.axes[robust.frequency > 12.0]) < 1.0)
    assert np.any(np.abs(published.axes[published.frequency > 12.0]) > 1.0)
    for other in ([str(tmp_path)], ["--as-published"]):
        assert main(["figures", "--robust-design", *other, "--out", str(tmp_path / "refused")]) == 2
        assert "--robust-design: " in capsys.readouterr().err
