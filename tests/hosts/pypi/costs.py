"""What each way to step the loop costs: RMS of pointing and torque in lockstep, which equals the hosts bit by bit."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from hosting import TICK, Bench
from loops import UNITS, Loop
from masters import references
from pypi.packages import SCHEMES, STEP, Scheme

from flexbench.loop.systems import RECORD

METRICS = ("pointing", "torque")
LOOP = Loop(configuration="centralised", scenario="fine_pointing", duration=30.0, since=10.0)  # decayed by then


def cost_rows(bench: Bench) -> Iterator[str]:
    """Yield the table in Markdown."""
    columns = [f"{metric} [{UNITS[metric][0]}]" for metric in METRICS]
    yield f"| way to step | controller's delays | {' | '.join(columns)} |"
    yield "|---|---|" + "---:|" * len(columns)
    for scheme in SCHEMES.values():
        known = scheme.values.get("controller", {})
        yield _row(bench, scheme, scheme.values, ", ".join(f"`{n}` {1e3 * v:g} ms" for n, v in known.items()) or "0")
        if known:
            yield _row(bench, scheme, {}, "left at 0")


def _row(bench: Bench, scheme: Scheme, values: Mapping[str, Mapping[str, Any]], delays: str) -> str:
    metrics = measured(bench, scheme, values)
    numbers = [f"{metrics[metric] * UNITS[metric][1]:.3g}" for metric in METRICS]
    return f"| {scheme.text} | {delays} | {' | '.join(numbers)} |"


def measured(bench: Bench, scheme: Scheme, values: Mapping[str, Mapping[str, Any]]) -> Mapping[str, float]:
    """Return the metrics of the loop that lockstep steps in one way, with these values of its components."""
    tick = scheme.period or TICK
    return LOOP.measured(
        bench.run(
            "run_package.py",
            {
                "package": str(LOOP.package(bench)),
                "tick": tick,
                "ticks": round(LOOP.duration * 1e9) // tick,
                "every": STEP // tick,
                "references": references(bench, LOOP.configuration, RECORD),
                "parameters": values,
                "delays": dict(scheme.delays),
                "one_rate": scheme.period,
            },
        )
    )
