"""The options of a run on a command line: what they are, what their texts mean, and the run they ask for."""

import argparse
import re
from collections.abc import Iterable, Mapping
from functools import partial
from pathlib import Path

from lockstep.adapter.component import with_replacements
from lockstep.cli.checkpoint_options import add_checkpoint_options, begin_told, checkpoints_told, print_summary
from lockstep.cli.progress import show_progress
from lockstep.cli.shadow_options import add_shadow_options, record_as_told, shadow_as_told
from lockstep.errors import InputError, compact
from lockstep.faults.read import read_scenario
from lockstep.run.real_time_pacing import pacer_given
from lockstep.shadow.component import with_isolation
from lockstep.shadow.residual import residual_lines
from lockstep.simulation import RunSummary, simulate
from lockstep.ssp.step_times import Timing
from lockstep.system.clock import nanoseconds, seconds
from lockstep.system.component import Kind, Value
from lockstep.system.system import System


def add_run_options(parser: argparse.ArgumentParser) -> None:
    """Add the system and all options of a run."""
    parser.add_argument("system", type=Path, nargs="?", help="a .ssd file, an unpacked SSP folder, or a .ssp archive")
    add_timing_options(parser)
    parser.add_argument("--out", type=Path, metavar="DIR", help="results folder (default: results/NAME OF THE SYSTEM)")
    parser.add_argument("--stop", metavar="S", help="stop time in seconds (default: the system file's)")
    parser.add_argument("--set", action="append", default=[], metavar="C.P=V",
                        help="set parameter P of component C; or, as NAME=V, an input of the whole system")  # fmt: skip
    parser.add_argument("--replace", action="append", default=[], metavar="C=FMU", help="put an FMU in C's place")
    parser.add_argument("--adapter", action="append", default=[], metavar="FILE",
                        help="TOML file between it and the ports of C; C=FILE if several are replaced")  # fmt: skip
    parser.add_argument("--faults", action="append", default=[], type=Path, metavar="FILE",
                        help="scenario of what goes wrong when: see below")  # fmt: skip
    add_shadow_options(parser)
    parser.add_argument("--record", action="append", metavar="PATTERN", help="outputs to record, or all")
    parser.add_argument("--record-period", metavar="S", help="time between two recorded rows in seconds")
    parser.add_argument("--isolate", action="append", default=[], metavar="C", help="run C in a process of its own")
    parser.add_argument("--share-process", action="append", default=[], metavar="C", help="run C in our own process")
    parser.add_argument("--step-limit", metavar="S", help="wall time for a call of an isolated FMU (default: 60)")
    parser.add_argument("--overwrite", action="store_true", help="replace an earlier run in the results folder")
    add_checkpoint_options(parser)


def add_timing_options(parser: argparse.ArgumentParser) -> None:
    """Add when components are stepped and how old their values are: files of others do not say it."""
    add = partial(parser.add_argument, action="append", default=[])
    add("--delay", metavar="[A:B=]N", help="delay from A to B, or of all connections, in ticks")
    add("--period", metavar="[C=]S", help="period of component C, or of all, in seconds")
    parser.add_argument("--tick", metavar="S", help="base tick in seconds, for files that have none")
    add("--continuous", metavar="C", help="outputs of C are true at the end of its step")
    add("--sampled", metavar="C", help="outputs of C hold from the start of its step on")


def timing_of(options: argparse.Namespace) -> Timing:
    """Return what the options of `add_timing_options` say, for `load_system`. Raises InputError."""
    periods = [text.rpartition("=") for text in options.period]
    delays = [text for text in options.delay if "=" not in text]
    kinds: dict[str, Kind] = dict.fromkeys(options.continuous, "continuous")
    both = sorted(kinds.keys() & set(options.sampled))
    if both:
        raise InputError(f"--sampled {both[0]}: is told to be continuous too; choose one")
    kinds |= dict.fromkeys(options.sampled, "sampled")
    general = [period for name, _, period in periods if not name]
    for option, texts in (("--period", general), ("--delay", delays)):
        if len(texts) > 1:
            raise InputError(f"{option} {texts[-1]}: given for all already, as {texts[0]}; name a component")
    return Timing(
        tick=_positive(options.tick, "--tick") if options.tick is not None else None,
        period=_positive(general[0], "--period") if general else None,
        periods={name: _positive(period, f"--period {name}") for name, _, period in periods if name},
        kinds=kinds,
        delay=_ticks(delays[0]) if delays else None,
    )


def _positive(text: str, what: str) -> int:
    time = nanoseconds(text, what)
    if time <= 0:
        raise InputError(f"{what} {text}: must be > 0 s")
    return time


def _ticks(text: str, given: str | None = None) -> int:
    if not (text.isascii() and text.isdecimal()):
        told = f"--delay {given or text}"
        raise InputError(f"{told}: write FROM:TO=TICKS, for example sensors:controller=5, or TICKS for all")
    return int(text)


def run_as_told(options: argparse.Namespace, system: System, overrides: Mapping[str, Value]) -> RunSummary:
    """Simulate with the options of `add_run_options`, whose --set goes before `overrides`; print how it went."""
    system = with_replacements(system, options.replace, options.adapter)
    system = with_periods(with_delays(system, options.delay), options.period)
    system = shadow_as_told(options, system)
    system = with_processes(system, options.isolate, options.share_process)
    folder = options.out or Path("results", folder_name(system.name))
    if options.stop is not None:
        nanoseconds(options.stop, "--stop")
    restart, pacer = begin_told(options), pacer_given(options.pace)
    time = seconds(restart.checkpoint.time) if restart else 0.0
    with show_progress(system.name, begin=time, pacer=pacer) as progress:
        summary = simulate(
            system,
            folder,
            stop_time=options.stop,
            overrides={**overrides, **assignments(options.set)},
            record=record_as_told(options, system),
            record_period=options.record_period,
            progress=progress,
            overwrite=options.overwrite,
            step_limit=options.step_limit,
            faults=[read_scenario(path) for path in options.faults],
            pace=pacer,
            checkpoints=checkpoints_told(options),
            restart=restart,
        )
    if system.ignored:
        print(f"left out, as no variable takes them: {compact(system.ignored)}")
    print_summary(summary)
    if any(component.shadow for component in system.components):
        print("\n".join(residual_lines(summary.folder)))
    return summary


def folder_name(name: str) -> str:
    """Return the name of a system as one of a folder: a file of others may call it anything."""
    return re.sub(r"[^\w.,+=@ -]", "_", name).strip(". ") or "system"


def with_delays(system: System, texts: Iterable[str]) -> System:
    """Return the system with delays given as TICKS for all connections, and as FROM:TO=TICKS, which goes before."""
    for text in sorted(texts, key=lambda text: "=" in text):
        ends, equals, ticks = text.rpartition("=")
        start, _, end = ends.partition(":")
        if equals and not (start and end):
            raise InputError(f"--delay {text}: write FROM:TO=TICKS, for example sensors:controller=5, or TICKS for all")
        count = _ticks(ticks, text)
        system = system.with_delay(start, end, count) if equals else system.with_every_delay(count)
    return system


def with_periods(system: System, texts: Iterable[str]) -> System:
    """Return the system with periods given as COMPONENT=SECONDS; one for all was for `load_system`."""
    for text in texts:
        name, equals, period = text.rpartition("=")
        if equals:
            system = system.with_period(name, _positive(period, f"--period {name}"))
    return system


def with_processes(system: System, isolated: Iterable[str], shared: Iterable[str]) -> System:
    """Return the system with components, given by name, in processes of their own or in the master's."""
    for name in isolated:
        system = with_isolation(system, name, True)
    for name in shared:
        system = with_isolation(system, name, False)
    return system


def assignments(texts: Iterable[str]) -> dict[str, str]:
    """Return values given as COMPONENT.PARAMETER=VALUE, by component and parameter."""
    values = {}
    for text in texts:
        key, equals, value = text.partition("=")
        if not (key and equals):
            raise InputError(f"--set {text}: write COMPONENT.PARAMETER=VALUE")
        values[key] = value
    return values
