"""Residuals and jumps against closed forms, and the figure's words, on histories made up here."""

from dataclasses import replace

import numpy as np
import pytest

from flexbench.figures.shadow import shadow_figure
from flexbench.studies.shadow.study import ShadowWindow, Study
from flexsat.parameters import ARCSECOND
from lockstep import InputError, Signals
from lockstep.shadow.residual import ShadowRun, jump, residuals, total_rms

INTERVAL, END = 0.005, 20.0
TIME = np.arange(round(END / INTERVAL)) * INTERVAL
SINE = 0.3 * np.sin(2.0 * np.pi * 0.5 * TIME)  # N.m; whole periods until 10 s
LATE = 0.3 * np.sin(2.0 * np.pi * 0.5 * (TIME - 0.04))


def made_up(original, shadow, acting):
    """Return signals with two outputs: the given one, and half of it."""
    columns = {}
    for number, share in ((1, 1.0), (2, 0.5)):
        for kind, values in (
            ("", acting), ("original.", original), ("shadow.", shadow), ("residual.", shadow - original),
        ):  # fmt: skip
            columns[f"controller.{kind}wheel.torque[{number}]"] = share * values
    for name in ("plant.attitude.mrp", "controller.reference.mrp"):
        for axis in (1, 2, 3):
            columns[f"{name}[{axis}]"] = 0.25 * ARCSECOND * np.cos(TIME) * name.startswith("plant")
    return Signals(time=TIME, columns=columns, units=dict.fromkeys(columns, "N.m"), descriptions={})


def recorded(switchover=None, blend=2.0):
    """Return a recorded of the two outputs."""
    outputs = ("wheel.torque[1]", "wheel.torque[2]")
    return ShadowRun(component="controller", outputs=outputs, switchover=switchover, blend=blend, end=END,
                about={"source": "vendor.fmu"})  # fmt: skip


def test_lag_bias_and_share_are_computed():
    signals = made_up(SINE, 0.5 * LATE + 0.01, SINE)
    one, half = residuals(signals, recorded())

    assert one.lag == pytest.approx(0.04)
    assert one.bias == pytest.approx(0.01, rel=1e-9)  # the sine's mean is zero
    assert one.original_rms == pytest.approx(0.3 / np.sqrt(2.0))
    # |0.5 exp(-i phi) - 1| of the sine, and the bias
    phase = 2.0 * np.pi * 0.5 * 0.04
    alone = one.original_rms * abs(0.5 * np.exp(-1j * phase) - 1.0)
    assert one.rms == pytest.approx(np.hypot(alone, 0.01), rel=1e-9)
    assert one.relative == pytest.approx(one.rms / one.original_rms)
    assert one.correlation == pytest.approx(np.cos(phase), rel=1e-9)
    assert one.largest == pytest.approx(np.sqrt(2.0) * alone + 0.01, rel=1e-3)  # at the nearest row
    assert (half.rms, half.bias, half.lag) == pytest.approx((0.5 * one.rms, 0.005, 0.04))
    assert total_rms((one, half)) == pytest.approx(one.rms * np.sqrt(1.25 / 2.0))


def test_residuals_begin_at_the_given_time_and_end_at_the_switchover():
    shadow = SINE + np.where(TIME < 2.0, 1.0, np.where(TIME < 10.0, 0.1, 5.0))
    signals = made_up(SINE, shadow, SINE)

    assert residuals(signals, recorded(10.0), since=2.0)[0].rms == pytest.approx(0.1)
    assert residuals(signals, recorded(10.0))[0].rms == pytest.approx(np.sqrt((1.0 * 2.0 + 0.01 * 8.0) / 10.0))
    with pytest.raises(InputError, match="no two rows were recorded from 10 s to the switchover"):
        residuals(signals, recorded(10.0), since=10.0)


def test_constant_outputs_have_no_correlation():
    (one, _) = residuals(made_up(0.0 * TIME, SINE, 0.0 * TIME), recorded())
    assert (one.correlation, one.lag, one.relative) == (None, None, None)


def test_jump_is_computed_with_its_neighbours():
    hard = made_up(SINE, SINE + 0.2, np.where(TIME < 10.0, SINE, SINE + 0.2))
    smooth = made_up(SINE, SINE + 0.2, np.where(TIME < 10.0, SINE, SINE + 0.2 * np.clip((TIME - 10.0) / 2.0, 0, 1)))
    usual = np.max(np.abs(np.diff(SINE)))

    found = jump(hard, recorded(10.0, 0.0))
    assert (found.acting, found.at_once) == pytest.approx((0.2, 0.2))
    assert found.step == pytest.approx(0.2 + usual, rel=1e-3)  # steepest at a zero of the sine
    assert found.neighbours == pytest.approx(usual, rel=1e-6)
    found = jump(smooth, recorded(10.0))
    assert found.acting == pytest.approx(0.0, abs=1e-15)
    assert found.at_once == pytest.approx(0.2)
    assert found.step == pytest.approx(usual, rel=1e-3)
    assert jump(smooth, recorded()) is None


@pytest.mark.parametrize("switchover", [None, 10.0])
def test_no_words_of_the_figure_overlap(crowded, switchover):
    signals, rode = made_up(SINE, LATE, SINE), replace(recorded(), switchover=switchover)
    window = ShadowWindow(start=0.0, end=END, values={})
    found = Study(recorded=rode, since=0.0, residuals=residuals(signals, rode), jump=jump(signals, rode), before=window,
                  blending=None, after=None)  # fmt: skip
    assert crowded(shadow_figure(signals, found)) == []
