"""Command line: `python -m lockstep run SYSTEM`, `show SYSTEM`, `check FMU` and `probe-latency FMU`."""

import argparse
import sys
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

from lockstep.cli.check_command import EXIT_CODES, add_check_options, check_as_told
from lockstep.cli.checkpoint_options import resume_as_told, system_told
from lockstep.cli.probe_latency_command import EXAMPLE, TEXT, add_latency_options, probe_as_told
from lockstep.cli.run_options import add_run_options, add_timing_options, run_as_told, timing_of, with_delays
from lockstep.cli.write_ssp_command import WRITE_EXAMPLE, add_write_options, write_as_told
from lockstep.errors import InputError, RunError, compact
from lockstep.faults import HELP
from lockstep.interrupt import end_program
from lockstep.plan.schedule import build_schedule
from lockstep.ssp.load import load_system
from lockstep.system.clock import seconds_text
from lockstep.system.system import System

_RUN_EXAMPLE = """example:
  python -m lockstep run orbit.ssd --out results/slew --stop 300 \\
      --set plant.mass=120 --set plant.initial.mrp=0,0,0.1 --record 'plant.*' --record-period 0.005 \\
      --delay controller:plant=2

saved every minute, and gone on with after a kill, or from a checkpoint with another value; at the pace of the clock:
  python -m lockstep run orbit.ssd --out results/slew --checkpoint-every 60 --pace 1
  python -m lockstep run --resume results/slew
  python -m lockstep run --from results/slew/checkpoints/t=120.ckpt --out results/other --set plant.drag=0.2
  What the run of the checkpoint was holds on: overrides, stop time, recording; but faults are those given anew.

a system file of others, which tells no periods and delays:
  python -m lockstep run vendor.ssp --period 0.001 --period aocs/controller=0.01 --stop 60 --set command=0
  The period is that of --period, of the file, or the step size that the FMU prefers; the tick is what all periods are
  multiples of. An FMU with discrete outputs alone is sampled: they hold from the start of a step on. All others are
  continuous: theirs are true at its end. A connection passes on the newest value there is: that of the same tick from
  a sampled component, that of one tick ago, which is true now, from a continuous one; --delay for another.
  `python -m lockstep show vendor.ssp` prints what that comes to.
"""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line and return the exit code: 0, 1 failed run, 2 bad input, 130 Ctrl-C."""
    options = _parser().parse_args(arguments)
    try:
        return _COMMANDS[options.command](options)
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
    parser = argparse.ArgumentParser(prog="python -m lockstep", description="Simulate systems of FMUs (SSP 1.0).")
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    run = commands.add_parser("run", help="simulate a system", epilog=f"{_RUN_EXAMPLE}\n{HELP}", formatter_class=plain)
    add_run_options(run)
    example = "example:\n  python -m lockstep show vendor.ssp --period 0.01 --period controller=0.1\n"
    show = commands.add_parser("show", help="print components, periods, order", epilog=example, formatter_class=plain)
    show.add_argument("system", type=Path, help="a .ssd file, an unpacked SSP folder, or a .ssp archive")
    add_timing_options(show)
    example = f"example:\n  python -m lockstep {WRITE_EXAMPLE}\n"
    write = commands.add_parser("write-ssp", help="write a system with a foreign FMU in it as standard SSP",
                                epilog=example, formatter_class=plain)  # fmt: skip
    add_write_options(write)
    example = f"{EXIT_CODES}\nexample:\n  python -m lockstep check vendor.fmu --html report.html --strict\n"
    check = commands.add_parser("check", help="accept or refuse FMUs", epilog=example, formatter_class=plain)
    add_check_options(check)
    latency = commands.add_parser(
        "probe-latency",
        help=TEXT,
        description=TEXT,
        epilog=EXAMPLE.format("python -m lockstep probe-latency"),
        formatter_class=plain,
    )
    add_latency_options(latency)
    return parser


def _run(options: argparse.Namespace) -> int:
    if options.resume is not None:
        resume_as_told(options)
    else:
        run_as_told(options, system_told(options, partial(load_system, timing=timing_of(options))), {})
    return 0


def _show(options: argparse.Namespace) -> int:
    system = with_delays(load_system(options.system, timing_of(options)), options.delay)
    for line in describe(system):
        print(line)
    return 0


_COMMANDS: dict[str, Callable[[argparse.Namespace], int]] = {
    "write-ssp": write_as_told,
    "run": _run,
    "show": _show,
    "check": check_as_told,
    "probe-latency": probe_as_told,
}


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
    if system.inputs:
        lines.append(f"  without a value: {compact(one.name for one in system.inputs)}; give --set NAME=VALUE")
    if system.ignored:
        lines.append(f"  left out, as no variable takes them: {compact(system.ignored)}")
    return lines


if __name__ == "__main__":
    code = main()
    sys.stdout.flush()
    sys.stderr.flush()
    end_program(code)
