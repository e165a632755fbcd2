"""Command line: `python -m lockstep run SYSTEM` and `python -m lockstep show SYSTEM`."""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from lockstep.clock import nanoseconds, seconds_text
from lockstep.errors import InputError, RunError
from lockstep.master import simulate
from lockstep.progress import show_progress
from lockstep.schedule import build_schedule
from lockstep.ssp import load_system
from lockstep.system import System

_RUN_EXAMPLE = """example:
  python -m lockstep run orbit.ssd --out results/slew --stop 300 \\
      --set plant.mass=120 --set plant.initial.mrp=0,0,0.1 --record 'plant.*' --record-period 0.005 \\
      --delay controller:plant=2
"""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line and return the exit code: 0, 1 failed run, 2 bad input, 130 Ctrl-C."""
    options = _parser().parse_args(arguments)
    try:
        return _run(options) if options.command == "run" else _show(options)
    except InputError as error:
        code, message = 2, str(error)
    except RunError as error:
        code, message = 1, str(error)
    except KeyboardInterrupt:
        code, message = 130, "interrupted"
    except OSError as error:
        code, message = 1, f"{error.filename or 'system'}: {error.strerror or error}"
    except Exception as error:  # a bug: still one line, and one that can be reported
        code, message = 1, f"internal error, please report it: {type(error).__name__}: {error}"
    print(f"lockstep: {' '.join(message.split())}", file=sys.stderr)
    return code


def _parser() -> argparse.ArgumentParser:
    plain = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(prog="python -m lockstep", description="Simulate systems of FMI 2.0 FMUs.")
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    run = commands.add_parser("run", help="simulate a system", epilog=_RUN_EXAMPLE, formatter_class=plain)
    run.add_argument("system", type=Path, help="a .ssd file, an unpacked SSP folder, or a .ssp archive")
    run.add_argument("--out", type=Path, metavar="DIR", help="results folder (default: results/NAME OF THE SYSTEM)")
    run.add_argument("--stop", metavar="S", help="stop time in seconds (default: the system file's)")
    run.add_argument("--set", action="append", default=[], metavar="C.P=V", help="set parameter P of component C")
    run.add_argument("--record", action="append", metavar="PATTERN", help="outputs to record, or all")
    run.add_argument("--record-period", metavar="S", help="time between two recorded rows in seconds")
    run.add_argument("--delay", action="append", default=[], metavar="A:B=N", help="delay from A to B in ticks")
    run.add_argument("--overwrite", action="store_true", help="replace an earlier run in the results folder")
    example = "example:\n  python -m lockstep show orbit.ssd\n"
    show = commands.add_parser("show", help="print components, periods, order", epilog=example, formatter_class=plain)
    show.add_argument("system", type=Path, help="a .ssd file, an unpacked SSP folder, or a .ssp archive")
    return parser


def _run(options: argparse.Namespace) -> int:
    system = load_system(options.system)
    for text in options.delay:
        ends, _, ticks = text.rpartition("=")
        start, _, end = ends.partition(":")
        if not (start and end and ticks.isdecimal()):
            raise InputError(f"--delay {text}: write FROM:TO=TICKS, for example controller:plant=2")
        system = system.with_delay(start, end, int(ticks))
    overrides = {}
    for text in options.set:
        key, equals, value = text.partition("=")
        if not equals:
            raise InputError(f"--set {text}: write COMPONENT.PARAMETER=VALUE")
        overrides[key] = value
    folder = options.out or Path("results", system.name)
    if options.stop is not None:
        nanoseconds(options.stop, "--stop")
    with show_progress(system.name) as progress:
        summary = simulate(
            system,
            folder,
            stop_time=options.stop,
            overrides=overrides,
            record=options.record,
            record_period=options.record_period,
            progress=progress,
            overwrite=options.overwrite,
        )
    speed = summary.simulated_time / max(summary.wall_time, 1e-9)
    print(f"{summary.simulated_time:g} s simulated in {summary.wall_time:.1f} s ({speed:.1f} x real time): {folder}")
    return 0


def _show(options: argparse.Namespace) -> int:
    system = load_system(options.system)
    for line in describe(system):
        print(line)
    return 0


def describe(system: System) -> list[str]:
    """Return the system as text: tick, components in the order of a tick, and latencies."""
    lines = [f"{system.name}: tick {seconds_text(system.tick)} s, in the order of a tick:"]
    width = max(len(component.name) for component in system.components)
    for task in build_schedule(system).tasks:
        c = system.component(task.name)
        timing = f"every {seconds_text(c.period)} s from {seconds_text(c.offset)} s, {c.kind}"
        lines.append(f"  {c.name:{width}}  {timing}, {c.source.name}")
    links: dict[tuple[str, str, int], int] = {}
    for connection in system.connections:
        key = (connection.from_component, connection.to_component, connection.delay)
        links[key] = links.get(key, 0) + 1
    for (start, end, delay), count in links.items():
        latency = "same tick" if delay == 0 else f"delay {delay} tick{'s' if delay > 1 else ''}"
        lines.append(f"  {start} -> {end}: {count} value{'s' if count > 1 else ''}, {latency}")
    return lines


if __name__ == "__main__":
    code = main()
    sys.stdout.flush()
    sys.stderr.flush()
    sys.exit(code)
