"""The study of a shadow controller as rows of text and as a file."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path

from lockstep.shadow.residual import total_rms

from ...runs.json_file import write_json
from ...runs.run_folder import Run
from .study import MEASURES, ShadowWindow, Study

RESULT = "shadow.json"
RESIDUALS = ("output", "unit", "residual RMS", "largest", "bias", "original RMS", "share", "correlation", "later by")
NOTE = (
    "Residual: shadow less original, at every recorded row before the switchover. Share: its RMS over that of the"
    " original. Later by: the shift at which the two correlate most, to a row. Torques act on the wheels."
)


def residual_rows(found: Study) -> list[tuple[str, ...]]:
    """Return a row an output, as texts."""
    return [
        (
            one.output,
            one.unit,
            f"{one.rms:.4g}",
            f"{one.largest:.4g}",
            f"{one.bias:.3g}",
            f"{one.original_rms:.4g}",
            "-" if one.relative is None else f"{100.0 * one.relative:.3g} %",
            "-" if one.correlation is None else f"{one.correlation:.4f}",
            "-" if one.lag is None else f"{1e3 * one.lag:g} ms",
        )
        for one in found.residuals
    ]


def loop_header(found: Study) -> tuple[str, ...]:
    """Return the columns of `loop_rows`."""
    return ("closed loop", "unit", *(f"{name}, {w.start:g} to {w.end:g} s" for name, w in _windows(found)))


def loop_rows(found: Study) -> list[tuple[str, ...]]:
    """Return the numbers of the closed loop, a column a window, as texts."""
    windows = [window for _, window in _windows(found)]
    known = [measure for measure in MEASURES if all(measure.key in window.values for window in windows)]
    return [(m.label, m.unit, *(f"{m.scale * window.values[m.key]:.4g}" for window in windows)) for m in known]


def _windows(found: Study) -> list[tuple[str, ShadowWindow]]:
    named = (("before", found.before), ("blending", found.blending), ("after", found.after))
    return [(name, window) for name, window in named if window is not None]


def summary(found: Study) -> list[str]:
    """Return what a reader wants first, as sentences."""
    recorded, unit = found.recorded, found.residuals[0].unit
    sentences = [
        f"{Path(recorded.about['source']).name} ran in shadow of {recorded.component} until"
        f" {recorded.end if recorded.switchover is None else recorded.switchover:g} s:"
        f" residual RMS over {len(found.residuals)} outputs {total_rms(found.residuals):.4g} {unit}."
    ]
    if found.jump is not None:
        sentences.append(
            f"It took over at {recorded.switchover:g} s with a jump of {found.jump.acting:.3g} {unit}; a hard switch"
            f" would have jumped by {found.jump.at_once:.4g} {unit}, and this difference decayed within"
            f" {recorded.blend:g} s. The step to the switchover is {found.jump.step:.4g} {unit}, those within 1 s of it"
            f" are up to {found.jump.neighbours:.4g}."
        )
    if recorded.switchover is not None and found.after is None:
        sentences.append("The run ends before the difference has passed: nothing to compare with.")
    return sentences


def write_study(found: Study, run: Run, folder: Path) -> Path:
    """Write shadow.json to a folder, the run's or another, in SI; return its path."""
    recorded = found.recorded
    content = {
        "configuration": run.configuration,
        "seed": run.seed,
        "component": recorded.component,
        "shadow": {key: recorded.about[key] for key in ("name", "source", "sha256", "period")},
        "since": found.since,
        "switchover": recorded.switchover,
        "blend": recorded.blend,
        "residual_rms": total_rms(found.residuals),
        "residuals": [asdict(one) | {"relative": one.relative} for one in found.residuals],
        "jump": None if found.jump is None else asdict(found.jump),
        "windows": {
            name: {"start": window.start, "end": window.end, "metrics": dict(window.values)}
            for name, window in _windows(found)
        },
    }
    return write_json(folder / RESULT, content)
