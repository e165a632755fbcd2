"""The command `flexsat equivalence`."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import click

from flexsat.parameters import RUN_DURATION
from lockstep.cli.command import command
from lockstep.cli.options import DISTINGUISHED, out_option, record_option, stop_time_option
from lockstep.cli.outcome import keep_table, remark, wrote
from lockstep.cli.parameter_types import OneOf

from .options import DEFAULT_SEED, SCENARIOS, fmus_option, seed_option, spacecraft_option

if TYPE_CHECKING:
    from ..loop.scenarios import ScenarioName

_EXAMPLES = """
exit code: 0 all signals agree, 1 they do not, 2 bad input

examples:
  {program} equivalence --configuration distributed --scenario slew --stop-time 30
  {program} equivalence --native
  {program} equivalence --configuration my.toml --native --stop-time 30
"""


@command("equivalence", _EXAMPLES, then="{program} figures {path} --out differences    # the runs, drawn",
         tables=True)  # fmt: skip
@spacecraft_option
@click.option("--scenario", type=OneOf(SCENARIOS), multiple=True, metavar="NAME",
              help="slew, fine_pointing or fine_pointing_open_loop (default: the first two)")  # fmt: skip
@seed_option
@stop_time_option(RUN_DURATION)
@record_option
@out_option(f"results folder (default: results/equivalence{DISTINGUISHED})")
@fmus_option
@click.option(
    "--native", is_flag=True, help="use the FMUs in C, whose rounding differs: tolerance 1e-10 instead of 1e-12"
)
def equivalence(
    configuration: tuple[str, ...],
    scenario: tuple[str, ...],
    seed: int | None,
    stop_time: float,
    record: tuple[str, ...],
    out: Path | None,
    fmus: Path,
    native: bool,
) -> int:
    """Compare the co-simulation with the monolith: the Python steppers in one loop, without FMI and master."""
    from ..loop import equivalence as gate
    from ..loop.build_options import ONLY_PYTHON, STANDARD
    from ..loop.chosen_spacecraft import build_missing, choose
    from ..runs.study_folder import study_folder

    seed = DEFAULT_SEED if seed is None else seed
    failed = False
    ports: list[tuple[Any, ...]] = []
    with study_folder(out, "equivalence") as root:
        for spacecraft in choose(configuration, fmus):
            build_missing((spacecraft,), SCENARIOS[0], STANDARD if native else ONLY_PYTHON)
            name = spacecraft.name
            for one in cast("tuple[ScenarioName, ...]", scenario or SCENARIOS[:2]):
                folder = root / f"{name}-{one.replace('_', '-')}"
                differences = gate.compare(
                    spacecraft.root, folder, name, one, seed, stop_time, list(record) or None, native=native
                )
                worst = max(differences, key=lambda difference: difference.relative)
                failed |= not worst.met
                ports += [(name, one, d.port, d.scalars, d.relative, d.signal, d.met) for d in differences]
                signals = sum(difference.scalars for difference in differences)
                result = (
                    "equal" if worst.relative == 0.0 else f"largest difference {worst.relative:.1e} in {worst.signal}"
                )
                kind = "native, " if native else ""
                remark(f"{name} {one}, {kind}{stop_time:g} s, seed {seed}: {signals} signals, {result}")
        keep_table(
            ("spacecraft", "scenario", "port", "signals", "largest relative difference", "in", "agrees"),
            ports,
            f"{'native' if native else 'Python'} FMUs against the monolith, {stop_time:g} s, seed {seed}",
        )
        wrote(root)
    if failed:
        tolerance = gate.NATIVE_TOLERANCE if native else gate.TOLERANCE
        print(f"flexsat: signals differ by more than {tolerance:g}", file=sys.stderr)
    return 1 if failed else 0
