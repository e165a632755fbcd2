"""Measure one run of the comparison: its numbers, or why it is lost."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

from flexsat.parameters import ARCSECOND, ConfigurationName
from lockstep import Signals
from lockstep.results.read_run_record import read_run_record

from ...engine.jobs import Finished
from ...loop.scenarios import ScenarioName
from ...runs import histories
from ...runs.loop_monitor import found_lines, means_lost
from ...runs.loop_numbers import QUANTITIES as LOOP_QUANTITIES
from ...runs.loop_numbers import LoopNumbers, numbers_of, settling_band
from ...runs.loop_signals import read_loop
from ...runs.metrics import root_mean_square
from ...runs.windows import Window, end_of
from ..robustness.model_errors import GROWTH

Compared = Literal["ratio", "difference"]


@dataclass(frozen=True, slots=True, kw_only=True)
class ComparedQuantity:
    """A number of a run. Printed is the value over `scale`, in `unit`; less is better."""

    key: str
    label: str
    unit: str
    scale: float
    scenario: ScenarioName
    of: str  # of the loop's numbers: settling, or the RMS of a quantity in the slew, or in the part that is compared
    compared: Compared = "ratio"  # settling may be zero


QUANTITIES = (
    ComparedQuantity(key="pointing", label="pointing error in fine pointing", unit="arcsec", scale=ARCSECOND,
             scenario="fine_pointing", of="steady.pointing_error"),
    ComparedQuantity(key="deformation", label="deformation in fine pointing", unit="µm", scale=1e-6,
             scenario="fine_pointing", of="steady.deformation"),
    ComparedQuantity(key="torque", label="torque in fine pointing", unit="N.m", scale=1.0,
             scenario="fine_pointing", of="steady.torque"),
    ComparedQuantity(key="slew_pointing", label="pointing error during the slew", unit="arcsec", scale=ARCSECOND,
             scenario="slew", of="slew.pointing_error"),
    ComparedQuantity(key="slew_deformation", label="deformation during the slew", unit="µm", scale=1e-6,
             scenario="slew", of="slew.deformation"),
    ComparedQuantity(key="settling", label="settling time after the slew", unit="s", scale=1.0,
             scenario="slew", of="settling", compared="difference"),
    ComparedQuantity(key="settled_pointing", label="pointing error after the slew", unit="arcsec", scale=ARCSECOND,
             scenario="slew", of="steady.pointing_error"),
    ComparedQuantity(key="settled_deformation", label="deformation after the slew", unit="µm", scale=1e-6,
             scenario="slew", of="steady.deformation"),
    ComparedQuantity(key="settled_torque", label="torque after the slew", unit="N.m", scale=1.0,
             scenario="slew", of="steady.torque"),
)  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True)
class RunOutcome:
    """What one run came to, in SI. A lost run has no numbers."""

    configuration: ConfigurationName
    scenario: ScenarioName
    seed: int
    numbers: Mapping[str, float | None] = field(default_factory=dict)  # by key; None: it does not settle
    windows: Sequence[str] = ()  # that the numbers refer to
    lost: str = ""  # why


def measure(
    finished: Finished, name: ConfigurationName, scenario: ScenarioName, seed: int, band: float | None
) -> RunOutcome:
    """Return the numbers of a run, or why it is lost.

    Parameters
    ----------
    finished : run
    band : of settling [rad]; None: 5 arcsec, or 0.5 with the fine sensor
    """
    if finished.failure:
        return RunOutcome(configuration=name, scenario=scenario, seed=seed, lost=finished.failure)
    folder = finished.job.folder
    record, _ = read_run_record(folder)
    loop = read_loop(folder)
    assert loop is not None  # the study simulates the systems of `flexsat build`
    numbers = numbers_of(loop, (), settling_band(record) if band is None else band)
    steady = window_of(numbers, end_of(loop.signals.time), scenario)
    lost = "the run ends in the slew" if steady is None else lost_by(record.get("found", ()))
    if steady is not None and not lost:
        lost = growing(loop.signals, steady)
    if steady is None or lost:
        return RunOutcome(configuration=name, scenario=scenario, seed=seed, lost=lost)
    return RunOutcome(
        configuration=name,
        scenario=scenario,
        seed=seed,
        numbers={
            one.key: value_of(numbers, rms_of(loop.signals, steady), one.of)
            for one in QUANTITIES
            if one.scenario == scenario
        },
        windows=tuple(
            window.text
            for window in dict.fromkeys([*(one.window for one in numbers.windows if one.window.name == "slew"), steady])
        ),
    )


def window_of(numbers: LoopNumbers, last: float, scenario: ScenarioName) -> Window | None:
    """Return the part of a run that is compared: all that follows the slew, or the steady part, up to `last` [s].

    It does not depend on when the run settles, so that both layouts of a pair are compared over the same time. None:
    the run ends in the slew.
    """
    if scenario != "slew" or not numbers.slews:
        return None if numbers.steady is None else numbers.steady.window
    end = numbers.slews[-1].end
    if end is None or end >= last:
        return None
    return Window(name="after the slew", spans=((end, last),))


def lost_by(found: Sequence[Mapping[str, Any]]) -> str:
    """Return what the monitor found that makes a run a lost one, in words; empty for none."""
    fatal = [one for one in found if means_lost(one)]
    return "; ".join(found_lines(fatal)[: len(fatal)])


def growing(signals: Signals, steady: Window) -> str:
    """Return that the torque grows in the steady part of a run, in words; empty if it does not."""
    torque = histories.torque_norm(signals)[steady.rows(signals.time)]
    half = len(torque) // 2
    before, after = (root_mean_square(part) if len(part) else 0.0 for part in (torque[:half], torque[half:]))
    if not after >= GROWTH * before > 0.0:
        return ""
    return f"the torque grows {after / before:.3g} times from one half of the steady part to the other"


def rms_of(signals: Signals, window: Window) -> dict[str, float]:
    """Return the RMS of each quantity of the loop in a window, by key."""
    rows = window.rows(signals.time)
    return {one.key: root_mean_square(one.of(signals)[rows]) for one in LOOP_QUANTITIES}


def value_of(numbers: LoopNumbers, after: Mapping[str, float], path: str) -> float | None:
    """Return a number of a run by its path, as in `ComparedQuantity.of`; None where it does not settle.

    Parameters
    ----------
    numbers : of the run
    after : RMS in the part that is compared
    """
    if path == "settling":
        return numbers.settlings[-1].time
    window, key = path.split(".")
    return (numbers.windows[0].rms if window == "slew" else after)[key]
