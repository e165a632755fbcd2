"""The options of a run on a command line: what they are, what their texts mean, and the run they ask for."""

import argparse
from collections.abc import Iterable, Mapping
from pathlib import Path

from lockstep.adapter.component import with_replacements
from lockstep.clock import nanoseconds
from lockstep.errors import InputError
from lockstep.master import RunSummary, simulate
from lockstep.progress import show_progress
from lockstep.system import System, Value


def add_run_options(parser: argparse.ArgumentParser) -> None:
    """Add the system and all options of a run."""
    parser.add_argument("system", type=Path, help="a .ssd file, an unpacked SSP folder, or a .ssp archive")
    parser.add_argument("--out", type=Path, metavar="DIR", help="results folder (default: results/NAME OF THE SYSTEM)")
    parser.add_argument("--stop", metavar="S", help="stop time in seconds (default: the system file's)")
    parser.add_argument("--set", action="append", default=[], metavar="C.P=V", help="set parameter P of component C")
    parser.add_argument("--delay", action="append", default=[], metavar="A:B=N", help="delay from A to B in ticks")
    parser.add_argument("--period", action="append", default=[], metavar="C=S", help="period of component C in seconds")
    parser.add_argument("--replace", action="append", default=[], metavar="C=FMU", help="put an FMU in C's place")
    parser.add_argument("--adapter", action="append", default=[], metavar="FILE",
                        help="TOML file between it and the ports of C; C=FILE if several are replaced")  # fmt: skip
    parser.add_argument("--record", action="append", metavar="PATTERN", help="outputs to record, or all")
    parser.add_argument("--record-period", metavar="S", help="time between two recorded rows in seconds")
    parser.add_argument("--isolate", action="append", default=[], metavar="C", help="run C in a process of its own")
    parser.add_argument("--share-process", action="append", default=[], metavar="C", help="run C in our own process")
    parser.add_argument("--step-limit", metavar="S", help="wall time for a call of an isolated FMU (default: 60)")
    parser.add_argument("--overwrite", action="store_true", help="replace an earlier run in the results folder")


def run_as_told(options: argparse.Namespace, system: System, overrides: Mapping[str, Value]) -> RunSummary:
    """Simulate with the options of `add_run_options`, whose --set goes before `overrides`; print how it went."""
    system = with_replacements(system, options.replace, options.adapter)
    system = with_periods(with_delays(system, options.delay), options.period)
    system = with_isolation(system, options.isolate, options.share_process)
    folder = options.out or Path("results", system.name)
    if options.stop is not None:
        nanoseconds(options.stop, "--stop")
    with show_progress(system.name) as progress:
        summary = simulate(
            system,
            folder,
            stop_time=options.stop,
            overrides={**overrides, **assignments(options.set)},
            record=options.record,
            record_period=options.record_period,
            progress=progress,
            overwrite=options.overwrite,
            step_limit=options.step_limit,
        )
    speed = summary.simulated_time / max(summary.wall_time, 1e-9)
    print(f"{summary.simulated_time:g} s simulated in {summary.wall_time:.1f} s ({speed:.1f} x real time): {folder}")
    return summary


def with_delays(system: System, texts: Iterable[str]) -> System:
    """Return the system with delays given as FROM:TO=TICKS."""
    for text in texts:
        ends, _, ticks = text.rpartition("=")
        start, _, end = ends.partition(":")
        if not (start and end and ticks.isdecimal()):
            raise InputError(f"--delay {text}: write FROM:TO=TICKS, for example controller:plant=2")
        system = system.with_delay(start, end, int(ticks))
    return system


def with_periods(system: System, texts: Iterable[str]) -> System:
    """Return the system with periods given as COMPONENT=SECONDS."""
    for text in texts:
        name, equals, period = text.partition("=")
        if not (name and equals):
            raise InputError(f"--period {text}: write COMPONENT=SECONDS, for example sensors=0.005")
        system = system.with_period(name, nanoseconds(period, f"--period {name}"))
    return system


def with_isolation(system: System, isolated: Iterable[str], shared: Iterable[str]) -> System:
    """Return the system with components, given by name, in processes of their own or in the master's."""
    for name in isolated:
        system = system.with_isolation(name, True)
    for name in shared:
        system = system.with_isolation(name, False)
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
