"""The results of a study of margins as rows of text, and what they mean."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from math import atan, ceil, degrees, isfinite, log10
from typing import Any

from ...campaign.statistics.percentiles import CONFIDENCE
from .estimate import COHERENT, TOGETHER

EXACT_HEADER = ("all inputs of the plant together", "margin")
HEADER = ("loop", "gain", "phase", "delay", "disk", "left out")
NONE = "none found"
_KINDS = ("gain_down", "gain_up", "phase", "delay", "disk")
_LINES_BELOW = 4.0  # about as many up to the lowest margin: it lies between two
Rows = list[tuple[str, ...]]


def exact_rows(content: Mapping[str, Any]) -> Rows:
    """Return the rows of the exact margins, and of the delay that really makes the co-simulation unstable."""
    rows: Rows = []
    if "analysis" in content:
        exact = content["analysis"]["exact"]
        rows.append(("delay", _delay(exact["delay"])))
        rows.append(("gain up", _gain(exact["gain_up"])))
        rows.append(("gain down", _gain(exact["gain_down"])))
        rows.append(("phase", _phase(exact["phase"])))
    if "real" in content:
        real = content["real"]
        found = f"{NONE} up to {real['stable'] * 1e3:g} ms"
        if real["unstable"] is not None:
            between = f"stable at {real['stable'] * 1e3:.1f}, unstable at {real['unstable'] * 1e3:.1f} ms"
            found = f"{real['delay'] * 1e3:.3f} ms, at {real['frequency']:.1f} Hz ({between})"
        rows.append(("delay that destabilises the co-simulation", found))
    return rows


def stability_text(content: Mapping[str, Any]) -> str:
    """Return whether the designed loop is stable on the plant of the run, as a sentence; nothing without a design."""
    if "stability" not in content:
        return ""
    found = content["stability"]
    plant = f"on {found['modes']} modes, up to {found['highest']:.1f} Hz"
    if found["growth"] < 0.0:
        return f"The designed loop is stable {plant}."
    return (
        f"The designed loop is UNSTABLE {plant}: it grows by {found['growth']:.3g} 1/s, at "
        f"{found['frequency']:.2f} Hz. An unstable loop has no margins; none were measured."
    )


def margin_rows(content: Mapping[str, Any]) -> Rows:
    """Return a row for each loop, computed and measured."""
    rows: Rows = []
    for name, margins in content.get("analysis", {}).get("margins", {}).items():
        rows.append((f"design: {name}", *_cells(margins, {})))
    for name, found in content.get("measured", {}).get("margins", {}).items():
        if "problem" in found:
            rows.append((f"measured: {name}", found["problem"], "", "", "", ""))
        else:
            rows.append((f"measured: {name}", *_cells(found["value"], found["uncertainty"])))
    return rows


def explanation(content: Mapping[str, Any]) -> str:
    """Return what the numbers mean, as sentences."""
    text = (
        "The loop is opened at the plant's input. Exact margins are those of the periodic loop, slow sensors included: "
        "the factor, phase or further delay on all inputs together at which its spectral radius reaches one. The other "
        "margins are those of its time-invariant equivalent, the response at the frequency of the test signal; one "
        "direction opened leaves the others closed. The delay margin counts the hold between two steps of the "
        "controller."
    )
    if "measured" in content:
        settings = content["measured"]["settings"]
        text += (
            f" Measured: {settings['periods']} periods of {settings['length']:g} s for each direction after "
            f"{settings['settle']} to settle, {'without' if settings['quiet'] else 'with'} noise, "
            f"seed {content['seed']}; lines of a coherence from {COHERENT:g}; {100 * CONFIDENCE:g} % intervals from "
            f"the scatter of the periods; `{TOGETHER}` opens all directions at once. Where crossings are left out, "
            "because the response changes too fast between two lines, the margins are upper bounds: --zoom measures "
            "again there, with longer periods."
        )
    return text + _below_the_lines(content)


def _below_the_lines(content: Mapping[str, Any]) -> str:
    """Name where the design has margins below the lowest measured line, which the measured ones then lack."""
    margins = content.get("analysis", {}).get("margins", {}).values()
    places = [found[f"{name}_at"] for found in margins for name in _KINDS if found[name] and found[f"{name}_at"]]
    frequency = content.get("measured", {}).get("frequency", [])
    if not places or not frequency or min(places) >= frequency[0]:
        return ""
    length = 10.0 * ceil(_LINES_BELOW / (10.0 * min(places)))
    return (
        f" The design has margins from {min(places):.3g} Hz on, below the lowest measured line, {frequency[0]:.3g} Hz:"
        f" the measured margins lack them; --length {length:g} measures there too."
    )


def limit_text(content: Mapping[str, Any]) -> str:
    """Return what limits the loop and by how much, as one sentence: the smallest disk margin; nothing without one."""
    loops = [(f"design: {name}", found) for name, found in content.get("analysis", {}).get("margins", {}).items()]
    loops += [(f"measured: {name}", found["value"]) for name, found in content.get("measured", {})
              .get("margins", {}).items() if "problem" not in found]  # fmt: skip
    loops = [(name, found) for name, found in loops if isfinite(found["disk"])]
    if not loops:
        return ""
    name, found = min(loops, key=lambda loop: float(loop[1]["disk"]))
    half = 0.5 * float(found["disk"])
    gain = f"{20.0 * log10((1.0 + half) / (1.0 - half)):.1f} dB" if half < 1.0 else "any factor"
    phase = f"{2.0 * degrees(atan(half)):.0f} deg"
    text = (f"What limits: `{name}` at {found['disk_at']:.3g} Hz, with a disk margin of {2.0 * half:.2f}: its gain may"
            f" change by {gain} up or down, or its phase by {phase}")  # fmt: skip
    exact = content.get("analysis", {}).get("exact", {}).get("delay")
    return f"{text}; a further delay of {_delay(exact)} on all inputs destabilises it." if exact else f"{text}."


def _cells(margins: Mapping[str, Any], uncertainty: Mapping[str, float]) -> Sequence[str]:
    """Return gain, phase, delay, disk and the number of crossings left out; with any, the others are upper bounds."""
    left_out = len(margins["unresolved"])
    bound = "<= " if left_out else ""

    def cell(name: str, text_of: Callable[[float | None, float | None], str]) -> str:
        if margins[name] is None:
            return NONE
        return f"{text_of(margins[name], uncertainty.get(name))} at {margins[f'{name}_at']:.3g} Hz"

    gains = [cell(name, _gain) for name in ("gain_down", "gain_up") if margins[name]]
    found = ", ".join(gains) or NONE, cell("phase", _phase), cell("delay", _delay)
    disk = f"{margins['disk']:.3f}{_plus(uncertainty.get('disk'), '.3f')} at {margins['disk_at']:.3g} Hz"
    return *(f"{bound if text != NONE else ''}{text}" for text in found), f"{bound}{disk}", str(left_out or "")


def _gain(factor: float | None, plus: float | None = None) -> str:
    if not factor:
        return NONE
    spread = None if plus is None else 20.0 * log10(1.0 + plus / factor)
    return f"{20.0 * log10(factor):+.2f}{_plus(spread, '.2f')} dB"


def _phase(angle: float | None, plus: float | None = None) -> str:
    return NONE if angle is None else f"{angle:.1f}{_plus(plus, '.1f')} deg"


def _delay(delay: float | None, plus: float | None = None) -> str:
    if delay is None:
        return NONE
    scale, unit = (1e3, "ms") if delay < 1.0 else (1.0, "s")
    return f"{scale * delay:.3f}{_plus(None if plus is None else scale * plus, '.3f')} {unit}"


def _plus(value: float | None, form: str) -> str:
    return "" if value is None else f" ± {value:{form}}"
