"""The command `probe-latency`."""

from __future__ import annotations

import shutil
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from lockstep.cli.command import command
from lockstep.cli.options import assignments, refuse_repeated
from lockstep.cli.outcome import PRINTED, json_path_option, print_lines, wrote
from lockstep.cli.parameter_types import COUNT, DURATION, PATH, OneOf
from lockstep.errors import InputError
from lockstep.interrupt import exit_code
from lockstep.whole_file import write_whole

if TYPE_CHECKING:
    from lockstep.system.component import Kind

_EXAMPLES = """
exit code: 0 no claim is contradicted; 1 one is, or the FMU failed; 2 bad input; 130 Ctrl-C

example:
  {program} probe-latency vendor.fmu --set gain=2 --set q_ok=3 --amplitude 0.01 --json latency.json
"""


@command(
    "probe-latency",
    _EXAMPLES,
    then="{program} run SYSTEM --delay A:B=N    # a run with other delays of its connections",
)
@click.argument("fmu", type=PATH, metavar="FMU",
                help="a co-simulation FMU of any version of FMI; it runs in a process of its own")  # fmt: skip
@click.option(
    "--step-size", metavar="S", help="step size in seconds (default: the one that the FMU recommends, or 0.001)"
)
@click.option("--steps", type=COUNT, default=104, metavar="N",
              help="steps to observe after a change (default: 104)")  # fmt: skip
@click.option("--set", "settings", multiple=True, metavar="NAME=V",
              help="value of a parameter, or start value of an input; an array takes V,V,...")  # fmt: skip
@click.option("--amplitude", multiple=True, metavar="A",
              help="change of every Real input in its unit, or INPUT=A (default: 0.01 of its range, or 0.001 of its "
                   "start or nominal value)")  # fmt: skip
@click.option("--kind", type=OneOf(("sampled", "continuous")), metavar="KIND",
              help="sampled: outputs hold from the start of a step; continuous: they are true at its end (default: "
                   "found with a shorter step; sampled where the FMU refuses one)")  # fmt: skip
@click.option("--time-limit", type=DURATION, default=60.0, metavar="S",
              help="wall time for all changes; arrays are changed as a whole where it is too short "
                   "(default: 60)")  # fmt: skip
@json_path_option("also write every pair as JSON; - prints it instead")
def probe_latency(
    fmu: Path,
    step_size: str | None,
    steps: int,
    settings: tuple[str, ...],
    amplitude: tuple[str, ...],
    kind: Kind | None,
    time_limit: float,
    json: Path | None,
) -> int:
    """Measure the delay from each input of an FMU to each output, and check its declared dependencies."""
    from lockstep.check.latency.probe_latency import ProbeSettings
    from lockstep.check.latency.probe_latency import probe_latency as probe
    from lockstep.cli.probe_latency_text import as_json, as_lines
    from lockstep.cli.probe_progress import show_probing

    chosen = ProbeSettings(
        step=None if step_size is None else _number(step_size, f"--step-size {step_size}"),
        steps=steps,
        starts=_values(settings),
        kind=kind,
        seconds=time_limit,
        **_amplitudes(amplitude),
    )
    if json is not None and json != PRINTED and json.resolve() == fmu.resolve():
        raise InputError(f"--json {json}: is the FMU; give another name")
    try:
        with show_probing(str(fmu)) as watch:
            report = probe(fmu, chosen, watch)
    except KeyboardInterrupt as error:
        print(f"{fmu}: interrupted; nothing was written", file=sys.stderr)
        return exit_code(error)
    if json == PRINTED:
        print(as_json(report), end="")
    else:
        print_lines(as_lines(report, shutil.get_terminal_size((120, 40)).columns))
        if json is not None:
            write_whole(json, as_json(report).encode())
            wrote(json)
    return 1 if report.of("contradicted") else 0


def _amplitudes(texts: tuple[str, ...]) -> dict[str, Any]:
    """Return the amplitude of all inputs and those of single ones, as arguments of `ProbeSettings`."""
    general, single = None, {}
    refuse_repeated(texts, "--amplitude")
    for text in texts:
        name, _, amount = text.rpartition("=")
        value = _number(amount, f"--amplitude {text}")
        if name:
            single[name] = value
        else:
            general = value
    return {"amplitude": general, "amplitudes": single}


def _values(texts: tuple[str, ...]) -> dict[str, str]:
    for text in texts:
        name, equals, _ = text.partition("=")
        if not (name and equals):
            raise InputError(f"--set {text}: write NAME=VALUE")
    return assignments(texts)


def _number(text: str, what: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise InputError(f"{what}: {text!r} is not a number") from None
