"""Options of a run, and the run that they describe."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import click

from lockstep.cli.checkpoint_options import CheckpointOptions, checkpoint_options
from lockstep.cli.options import (
    DISTINGUISHED,
    adapter_option,
    assignments,
    input_option,
    option_group,
    out_option,
    record_option,
    replace_option,
)
from lockstep.cli.parameter_types import PATH, WholeNumber
from lockstep.cli.shadow_options import ShadowOptions, shadow_options
from lockstep.cli.timing_options import TimingOptions, implementation, timing_options, with_delays, with_step_sizes
from lockstep.errors import InputError

if TYPE_CHECKING:
    from lockstep.plan.plan import Plan
    from lockstep.results.monitor import Watch
    from lockstep.simulation import RunSummary
    from lockstep.system.component import Value
    from lockstep.system.system import System


@dataclass(frozen=True, slots=True, kw_only=True)
class RunRequest:
    """Everything that a user says about a run; times are texts, as they are exact."""

    system: Path | None
    timing: TimingOptions
    out: Path | None
    start_time: str | None
    stop_time: str | None
    settings: tuple[str, ...]
    inputs: tuple[Path, ...]
    replace: tuple[str, ...]
    adapter: tuple[str, ...]
    faults: tuple[Path, ...]
    shadow: ShadowOptions
    record: tuple[str, ...]
    record_period: str | None
    isolate: tuple[str, ...]
    share_process: tuple[str, ...]
    step_limit: str | None
    tolerance: tuple[str, ...]
    overwrite: bool
    checkpoints: CheckpointOptions
    pace: str | None
    realtime_priority: int | None
    core: int | None
    threads: str | None
    profile: bool
    strict_inputs: bool
    strict: bool
    within: Path | None


run_options = option_group(
    "request",
    RunRequest,
    click.argument("system", type=PATH, required=False, metavar="[SYSTEM]",
                   help="a .ssd file, an unpacked SSP folder, a .ssp archive, an OspSystemStructure.xml, or one FMU"),
    timing_options,
    out_option(f"results folder (default: results/SYSTEM{DISTINGUISHED})"),
    click.option("--start-time", metavar="S",
                 help="start time in seconds (default: the system file's, or 0)"),
    click.option("--stop-time", metavar="S", help="stop time in seconds (default: the system file's)"),
    click.option("--set", "settings", multiple=True, metavar="C.P=V",
                 help="set parameter P of component C, or, as NAME=V, an input of the whole system; units: 0.1arcsec"),
    input_option,
    replace_option,
    adapter_option,
    click.option("--faults", type=PATH, multiple=True, metavar="FILE", help="fault scenario: see below"),
    shadow_options,
    record_option,
    click.option("--record-period", metavar="S", help="time between two recorded rows in seconds"),
    click.option("--isolate", multiple=True, metavar="C", help="run C in a process of its own; also a pattern: 'gen*'"),
    click.option("--share-process", multiple=True, metavar="C", help="run C in the master's process; also a pattern"),
    click.option("--step-limit", metavar="S", help="most wall time of one call of an isolated FMU (default: 60)"),
    click.option("--tolerance", multiple=True, metavar="[C=]T",
                 help="relative tolerance of C's integration, or of all (default: the FMU's own)"),
    click.option("--overwrite", is_flag=True, help="replace an earlier run in the results folder"),
    checkpoint_options,
    click.option("--pace", metavar="X", help="limit the speed to X times real time (default: no limit)"),
    click.option("--realtime-priority", type=WholeNumber(1), metavar="N",
                 help="SCHED_FIFO priority of the stepping thread, 1 to 99, where permitted"),
    click.option("--core", type=WholeNumber(0), metavar="N", help="keep the stepping thread on this core"),
    click.option("--threads", metavar="N|auto",
                 help="most threads that step FMUs in parallel; 1: in turn (default: auto, one for each core, where "
                      "steps are long enough)"),
    click.option("--profile", is_flag=True, help="show where the wall time goes, by component"),
    click.option("--strict-inputs", is_flag=True, help="refuse inputs that have neither a connection nor a value"),
    click.option("--strict", is_flag=True, help="refuse system files and FMUs that would only get a warning"),
    click.option("--within", type=PATH, metavar="DIR",
                 help="refuse a system file that names files outside this folder"),
)  # fmt: skip


def run_system(
    request: RunRequest,
    system: System,
    overrides: Callable[[System], Mapping[str, Value]] = lambda _: {},
    *,
    marks: str = "",
    finish: Callable[[Path], None] = lambda _: None,
    watch: Watch | None = None,
    check: Callable[[Plan], None] | None = None,
) -> RunSummary:
    """Simulate a system and print the summary.

    Parameters
    ----------
    request : what the command line says
    system : before replacements, delays and step sizes of the request
    overrides : returns parameters of the system that is simulated; values of --set go before them
    marks : follows the system's name in that of the default folder
    finish : called with the folder at the end, while no other run can use that
    watch, check : as in `RunOptions`
    """
    from lockstep.adapter.component import with_replacements
    from lockstep.cli.outcome import remark
    from lockstep.cli.progress import print_summary, print_warnings, show_progress
    from lockstep.errors import compact
    from lockstep.faults.read import read_scenario
    from lockstep.results.results_folder import claim
    from lockstep.run.real_time_pacing import pacer_given
    from lockstep.shadow.residual import residual_lines
    from lockstep.simulation import simulate
    from lockstep.system.clock import nanoseconds, seconds

    system = with_replacements(system, request.replace, request.adapter)
    system = with_step_sizes(with_delays(system, request.timing.delay), request.timing.step_size)
    if request.start_time is not None:
        system = system.with_start_time(nanoseconds(request.start_time, "--start-time"))
    system = request.shadow.apply(system)
    system = with_processes(system, request.isolate, request.share_process)
    default = Path("results", folder_name(system.name) + marks)
    if request.stop_time is not None:
        nanoseconds(request.stop_time, "--stop-time")
    restart, pacer = request.checkpoints.restart(), pacer_given(request.pace)
    time = seconds(restart.checkpoint.time if restart else system.start_time)
    numbered = request.out is None and not request.overwrite
    with claim(request.out or default, overwrite=request.overwrite, numbered=numbered) as folder:
        with show_progress(system.name, begin=time, pacer=pacer) as progress:
            summary = simulate(
                system,
                folder,
                stop_time=request.stop_time,
                overrides={**overrides(system), **assignments(request.settings)},
                record=_recorded(request.record, system),
                record_period=request.record_period,
                progress=progress,
                step_limit=request.step_limit,
                tolerance=_tolerances(request.tolerance, system),
                faults=[read_scenario(path) for path in request.faults],
                pace=pacer,
                realtime_priority=request.realtime_priority,
                core=request.core,
                tick=implementation(request.timing.tick),
                threads=request.threads,
                profile=request.profile,
                checkpoints=request.checkpoints.schedule(),
                restart=restart,
                strict_inputs=request.strict_inputs,
                inputs=request.inputs or None,
                strict=request.strict,
                watch=watch,
                check=check,
            )
        print_warnings(summary.warnings)
        if system.ignored:
            remark(f"left out, as no variable takes them: {compact(system.ignored)}")
        if system.start_values:
            remark(f"values of connected inputs, which apply at initialization only: {compact(system.start_values)}")
        print_summary(summary, profile=request.profile)
        if any(component.shadow for component in system.components):
            remark(*residual_lines(folder.path))
        finish(folder.path)
    return summary


def folder_name(name: str) -> str:
    """Return the name of a system as that of a folder: a system file may contain any name."""
    return re.sub(r"[^\w.,+=@ -]", "_", name).strip(". ") or "system"


def _recorded(patterns: tuple[str, ...], system: System) -> list[str] | None:
    """Return the patterns to record: those asked for, and always what a shadow is evaluated by."""
    from lockstep.shadow.component import recorded

    if not patterns:
        return None
    return [*patterns, *(pattern for component in system.components for pattern in recorded(component))]


def _tolerances(texts: Iterable[str], system: System) -> dict[str, str]:
    """Return tolerances given as TOLERANCE for all, and as COMPONENT=TOLERANCE, which goes before."""
    from lockstep.shadow.component import names_of

    found: dict[str, str] = {}
    for text in texts:
        name, equals, tolerance = text.rpartition("=")
        if (equals and not name) or name in found:
            raise InputError(f"--tolerance {text}: write COMPONENT=TOLERANCE or TOLERANCE for all, each once")
        found[name] = tolerance
    general = dict.fromkeys(names_of(system), found[""]) if "" in found else {}
    return general | {name: tolerance for name, tolerance in found.items() if name}


def with_processes(system: System, isolated: Iterable[str], shared: Iterable[str]) -> System:
    """Return the system with components in processes of their own or in the master's; a name goes before a pattern."""
    from lockstep.shadow.component import names_of, with_isolation
    from lockstep.system.name_patterns import named

    found: dict[str, tuple[bool, str, bool]] = {}  # isolated, as which option says, and whether by a pattern
    names = names_of(system)
    for option, patterns, isolate in (("--isolate", isolated, True), ("--share-process", shared, False)):
        for pattern in patterns:
            for name in named(pattern, names, f"{option} "):
                entry = (isolate, f"{option} {pattern}", name != pattern)
                before = found.get(name, entry)
                if before[0] != isolate and before[2] == entry[2]:
                    raise InputError(f"{entry[1]}: {before[1]} names {name} too; choose one")
                found[name] = before if entry[2] else entry
    for name, (isolate, _, _) in found.items():
        system = with_isolation(system, name, isolate)
    return system
