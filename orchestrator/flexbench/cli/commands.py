"""What the commands do. Imported once the command line is understood: numpy and the rest take a moment."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path
from time import perf_counter

from flexsat.fmu.reproducible_zip import write_atomically
from flexsat.parameters import CONFIGURATIONS, ConfigurationName
from lockstep import InputError, RunSummary, System, load_system
from lockstep.cli.check_command import check_as_told
from lockstep.cli.checkpoint_options import resume_as_told, system_told
from lockstep.cli.run_options import run_as_told, timing_of, with_delays
from lockstep.plan.timeline import timeline_lines
from lockstep.plan.timeline_svg import timeline_svg

from ..adapt.contracts import contracts
from ..loop import equivalence as gate
from ..loop.scenarios import SCENARIOS, ScenarioName, scalar_overrides, scenario_parameters
from ..runs.metrics import SETTLED_FROM
from ..runs.run_folder import read_run, write_metrics
from ..studies.paper import paper as study
from ..studies.paper.published import VARIANTS, Variant
from ..studies.paper.table import as_text


def build(names: Sequence[ConfigurationName], folder: Path, *, flat: bool = False) -> int:
    """Build FMUs, systems and what documents them, a line each."""
    from ..loop.build import build_all  # with matplotlib, which other commands need not wait for

    started = perf_counter()
    build_all(names, folder, flat=flat)
    print(f"built in {perf_counter() - started:.1f} s")
    return 0


def check(options: argparse.Namespace) -> int:
    """Check FMUs, ours or a vendor's, also against the ports of our components."""
    try:
        return check_as_told(options, contracts)
    except KeyboardInterrupt:
        print("flexsat: interrupted; the reports tell of the FMUs that were done", file=sys.stderr)
        return 130


def run(options: argparse.Namespace) -> int:
    """Simulate one system; add its metrics if it is one of ours and long enough."""
    folder = (_run_anew(options) if options.resume is None else resume_as_told(options)).folder
    try:
        metrics = write_metrics(read_run(folder))
    except InputError as error:
        print(f"no metrics.json: {error}")
        return 0
    for key, value in metrics.items():
        print(f"  {key:16} {value:.4g}")
    return 0


def _run_anew(options: argparse.Namespace) -> RunSummary:
    def load(path: Path) -> System:
        if not path.exists() and path.suffix == ".ssd":
            raise InputError(f"{path}: no such file; `flexsat build` writes fmus/<configuration>/<scenario>.ssd")
        return load_system(path, timing_of(options))

    system = system_told(options, load)
    overrides: dict[str, float | int | bool | str] = {}
    if options.as_published:
        overrides |= scalar_overrides(scenario_parameters(_scenario_of(system), as_published=True))
    if options.seed is not None:
        overrides |= {"plant.seed": options.seed, "sensors.seed": options.seed}
    return run_as_told(options, system, overrides)


def _scenario_of(system: System) -> ScenarioName:
    for scenario in sorted(SCENARIOS, key=len, reverse=True):
        if system.name.endswith(scenario.replace("_", "-")):
            return scenario
    raise InputError(f"--as-published: system {system.name} is none of the paper's; they end in slew, fine-pointing")


def paper(options: argparse.Namespace) -> int:
    """Run the paper's study."""
    if options.seeds < 1:
        raise InputError(f"--seeds {options.seeds}: must be 1 or more")
    if options.jobs is not None and options.jobs < 1:
        raise InputError(f"--jobs {options.jobs}: must be 1 or more")
    chosen: list[Variant] = [variant for variant in VARIANTS if getattr(options, variant)] or list(VARIANTS)
    if not options.duration > SETTLED_FROM:
        raise InputError(
            f"--duration {options.duration:g}: the table refers to t > {SETTLED_FROM:g} s; simulate longer"
        )
    seeds = range(1, options.seeds + 1)
    build(CONFIGURATIONS, options.fmus)
    results = study.run_paper(options.fmus, options.out, chosen, seeds, options.duration, options.jobs)
    print(as_text(results))
    from ..report.paper_pages import draw_paper, report_paper  # with matplotlib, which other commands need not wait for

    print("\n".join(str(path) for path in draw_paper(options.out, chosen, seeds[0])))
    print(report_paper(options.out, chosen, seeds[0]))
    print(f"table.txt, table.md, table.csv, table.json and every run: {options.out}")
    return 0


def equivalence(options: argparse.Namespace) -> int:
    """Run the equivalence gate; exit code 1 if it does not hold."""
    failed = False
    for name in options.configuration or CONFIGURATIONS:
        if not (options.fmus / name / "slew.ssd").is_file():
            build((name,), options.fmus)
        for scenario in options.scenario or ("slew", "fine_pointing"):
            folder = options.out / f"{name}-{scenario.replace('_', '-')}"
            differences = gate.compare(
                options.fmus, folder, name, scenario, options.seed, options.duration, options.record
            )
            worst = max(differences, key=lambda difference: difference.relative)
            failed |= not worst.met
            signals = sum(difference.scalars for difference in differences)
            verdict = "equal" if worst.relative == 0.0 else f"largest difference {worst.relative:.1e} in {worst.port}"
            print(f"{name} {scenario}, {options.duration:g} s, seed {options.seed}: {signals} signals, {verdict}")
    if failed:
        print(f"flexsat: the gate of {gate.TOLERANCE:g} does not hold", file=sys.stderr)
    return 1 if failed else 0


def export(options: argparse.Namespace) -> int:
    """Write a run's signals for other tools."""
    from ..runs.export import export_run

    print(export_run(options.results, options.to, options.out, options.signals))
    return 0


def report(options: argparse.Namespace) -> int:
    """Write the page of one run or several."""
    from ..report import write_report

    window = None if options.window is None else (options.window[0], options.window[1])
    print("\n".join(str(path) for path in write_report(options.results, options.out, pdf=options.pdf, window=window)))
    return 0


def timeline(options: argparse.Namespace) -> int:
    """Print, and on request draw, the first ticks of a system."""
    if options.ticks < 1:
        raise InputError(f"--ticks {options.ticks}: must be 1 or more")
    system = with_delays(load_system(options.system, timing_of(options)), options.delay)
    print("\n".join(timeline_lines(system, options.ticks)))
    if options.svg is not None:
        write_atomically(options.svg, timeline_svg(system, options.ticks).encode())
        print(options.svg)
    return 0
