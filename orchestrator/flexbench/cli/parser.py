"""The command line: `flexsat build`, `check`, `run`, `paper`, `report`, `export` and more."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NoReturn

# One thread a process: the matrices are small, and several runs share the machine. Before numpy is imported.
for _variable in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_variable, "1")

FMUS, RESULTS = Path("fmus"), Path("results")


def program() -> NoReturn:
    """Be the command `flexsat`."""
    code = main()
    from lockstep.interrupt import end_program

    end_program(code)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line and return the exit code: 0, 1 failed run, 2 bad input, 130 Ctrl-C."""
    try:
        options = _parser().parse_args(arguments)
        command: Callable[[argparse.Namespace], int] = options.call
        return command(options)
    except KeyboardInterrupt:
        code, message = 130, "interrupted; what was simulated is in the results folder"
    except BrokenPipeError:
        return 1
    except OSError as error:
        code, message = 1, f"{error.filename or 'system'}: {error.strerror or error}"
    except Exception as error:
        code, message = _told(error)
    print(f"flexsat: {' '.join(message.split())}", file=sys.stderr)
    return code


def _told(error: Exception) -> tuple[int, str]:
    from lockstep import RunError

    if isinstance(error, RunError):
        return 1, str(error)
    if isinstance(error, ValueError):  # lockstep.InputError is one
        return 2, str(error)
    return 1, f"internal error, please report it: {type(error).__name__}: {error}"


class _Parser(argparse.ArgumentParser):
    """Tell what is wrong in one line; argparse offers no other way than a class of one's own."""

    def error(self, message: str) -> NoReturn:
        """Exit with code 2."""
        self.exit(2, f"flexsat: {message}; see `{self.prog} --help`\n")


def _parser() -> argparse.ArgumentParser:
    from flexbench.cli.analysis_options import (
        BUDGET_EXAMPLE,
        SHADOW_EXAMPLE,
        add_budget_options,
        add_shadow_options,
        add_spectra_options,
        add_waterfall_options,
    )
    from flexbench.cli.branch_options import BRANCH_EXAMPLE, add_branch_options
    from flexbench.cli.margins_options import add_margin_options
    from lockstep.cli.check_command import EXIT_CODES, add_check_options
    from lockstep.cli.probe_latency_command import EXAMPLE, TEXT, add_latency_options, probe_as_told
    from lockstep.cli.run_options import add_run_options, add_timing_options  # imports numpy: after the threads are set
    from lockstep.cli.write_ssp_command import WRITE_EXAMPLE, add_write_options
    from lockstep.faults import HELP

    parser = _Parser(
        prog="flexsat", description="Co-simulation bench for the attitude control of large flexible spacecraft."
    )
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    plain = argparse.RawDescriptionHelpFormatter

    def add(name: str, call: Callable[[argparse.Namespace], int], text: str, example: str) -> argparse.ArgumentParser:
        command = commands.add_parser(
            name, help=text, description=text, epilog=f"example:\n  {example}\n", formatter_class=plain
        )
        command.set_defaults(call=call)
        return command

    build = add("build", _build, "build the FMUs and system files", "flexsat build --configuration distributed")
    build.add_argument("--configuration", action="append", choices=("centralised", "distributed"), metavar="NAME",
                       help="centralised or distributed (default: both)")  # fmt: skip
    build.add_argument("--out", type=Path, default=FMUS, metavar="DIR", help="folder to fill (default: fmus)")
    build.add_argument("--flat", action="store_true",
                       help="also with flat names, wheel_torque_1, into DIR/NAME/flat")  # fmt: skip

    check = add(
        "check",
        _check,
        "accept or refuse FMUs of any maker: the file, how it runs, and which ports of ours it can serve",
        f"flexsat check --like controller vendor.fmu --html report.html --junit report.xml\n\n{EXIT_CODES}",
    )
    add_check_options(check)
    check.add_argument("--like", metavar="NAME",
                       help="compare its ports with controller, plant or sensors, or controller:distributed "
                            "and so on (default: with the one it resembles)")  # fmt: skip

    adapt = add(
        "adapt",
        _adapt,
        "draft the adapter of a foreign FMU from names, units and array sizes, and say what it could not decide",
        "flexsat adapt vendor.fmu --like controller --out vendor.toml",
    )
    adapt.add_argument("fmu", type=Path, help="the foreign FMU")
    adapt.add_argument("--like", required=True, metavar="NAME", help="the component of ours that it is to stand for")
    adapt.add_argument("--out", type=Path, metavar="FILE", help="file to write (default: print it)")

    adapting = add(
        "check-adapter",
        _check_adapter,
        "turn and spin a spacecraft before a foreign controller: are its adapter's conventions right?",
        "flexsat check-adapter vendor.fmu --adapter vendor.toml --like controller:centralised",
    )
    adapting.add_argument("fmu", type=Path, help="the foreign controller")
    adapting.add_argument("--adapter", type=Path, required=True, metavar="FILE", help="TOML file to check")
    adapting.add_argument("--like", metavar="NAME", help="controller:centralised or controller:distributed "
                          "(default: the one that the adapter fits)")  # fmt: skip

    add_write_options(add(
        "write-ssp", _write_ssp, "write a system with a foreign FMU in it as standard SSP", f"flexsat {WRITE_EXAMPLE}",
    ))  # fmt: skip

    run = add(
        "run",
        _run,
        "run one system, and leave its signals and metrics",
        "flexsat run fmus/distributed/slew.ssd --seed 3 --set plant.initial.mrp[1]=1e-6 --stop 200\n"
        f"  flexsat run fmus/distributed/fine_pointing.ssd --faults examples/faults/star_tracker_outage.toml\n\n{HELP}",
    )
    add_run_options(run)
    run.add_argument("--seed", type=int, metavar="N", help="seed of plant and sensors")
    run.add_argument("--as-published", action="store_true", help="with the slips of the published release")

    paper = add(
        "paper",
        _paper,
        "build, run the paper's six runs, and print its table with our numbers beside it",
        "flexsat paper --seeds 6",
    )
    paper.add_argument("--as-published", action="store_true", help="only with the slips of the published release")
    paper.add_argument("--corrected", action="store_true", help="only without them (default: both)")
    paper.add_argument("--seeds", type=int, default=1, metavar="N", help="run seeds 1 to N (default: 1)")
    paper.add_argument("--duration", type=float, default=300.0, metavar="S", help="simulated time (default: 300)")
    paper.add_argument("--out", type=Path, default=RESULTS / "paper", metavar="DIR",
                       help="results folder (default: results/paper)")  # fmt: skip
    paper.add_argument("--fmus", type=Path, default=FMUS, metavar="DIR", help="folder of the FMUs (default: fmus)")
    paper.add_argument("--jobs", type=int, metavar="N", help="processes at once (default: one a core)")

    add_branch_options(add(
        "branch", _branch, "go on from one checkpoint many times, each time with other values", BRANCH_EXAMPLE,
    ))  # fmt: skip

    figures = add(
        "figures",
        _figures,
        "draw the design, or with RESULTS the runs: PNG and SVG",
        "flexsat figures results/paper --configuration distributed --out figures",
    )
    figures.add_argument("results", type=Path, nargs="*", metavar="RESULTS",
                         help="results folders of runs, or folders of such (default: draw the design)")  # fmt: skip
    figures.add_argument("--configuration", action="append", choices=("centralised", "distributed"), metavar="NAME",
                         help="centralised or distributed (default: both)")  # fmt: skip
    figures.add_argument("--out", type=Path, default=RESULTS / "figures", metavar="DIR",
                         help="folder to fill (default: results/figures)")  # fmt: skip

    export = add(
        "export",
        _export,
        "write a run's signals as one file for other tools, with units",
        "flexsat export results/distributed-slew --to mat --signals plant.rate --signals 'plant.wheel.*'",
    )
    export.add_argument("results", type=Path, metavar="RESULTS", help="results folder of a run")
    export.add_argument("--to", required=True, choices=("csv", "mat", "hdf5", "parquet"), metavar="FORMAT",
                        help="csv, mat (MATLAB structures), hdf5 (netCDF-4) or parquet")  # fmt: skip
    export.add_argument("--out", type=Path, metavar="FILE", help="file (default: RESULTS/NAME OF RESULTS.csv etc.)")
    export.add_argument("--signals", action="append", default=[], metavar="PATTERN",
                        help="signals to write, * and ? wild (default: all that was recorded)")  # fmt: skip

    report = add(
        "report",
        _report,
        "write one HTML page of a run, or of several side by side; it needs no network",
        "flexsat report results/distributed-slew results/centralised-slew --out slews.html --pdf",
    )
    report.add_argument("results", type=Path, nargs="+", metavar="RESULTS",
                        help="results folders of runs, or folders of such folders")  # fmt: skip
    report.add_argument("--out", type=Path, metavar="FILE",
                        help="page to write (default: report.html in the first results folder)")  # fmt: skip
    report.add_argument("--window", type=float, nargs=2, metavar=("FROM", "TO"),
                        help="plot this part of the time, in seconds; a short one is kept row by row")  # fmt: skip
    report.add_argument("--pdf", action="store_true", help="also print the page to PDF; needs Chromium or Chrome")

    health = add(
        "health",
        _health,
        "judge the estimator: NIS and NEES with bounds, whiteness of the innovations",
        "flexsat health fmus/distributed/fine_pointing.ssd --seeds 4 --stop 100",
    )
    health.add_argument("system", type=Path, help="system file of ours")
    health.add_argument("--seeds", type=int, default=2, metavar="N", help="fly seeds 1 to N (default: 2)")
    health.add_argument("--stop", type=float, default=100.0, metavar="S", help="simulated time (default: 100)")
    health.add_argument("--out", type=Path, default=RESULTS / "health", metavar="DIR", help="results folder")
    health.add_argument("--jobs", type=int, metavar="N", help="processes at once (default: one a core)")

    robustness = add(
        "robustness",
        _robustness,
        "fly with errors of the modal frequencies that the controller does not know",
        "flexsat robustness --levels 1 2 5 --seeds 2 --stop 100",
    )
    robustness.add_argument("--configuration", action="append", choices=("centralised", "distributed"), metavar="NAME",
                            help="centralised or distributed (default: both)")  # fmt: skip
    robustness.add_argument("--scenario", choices=("slew", "fine_pointing"), default="fine_pointing", metavar="NAME",
                            help="slew or fine_pointing (default: fine_pointing)")  # fmt: skip
    robustness.add_argument("--levels", type=float, nargs="+", metavar="PERCENT", help="errors (default: 1 2 5)")
    robustness.add_argument("--seeds", type=int, default=1, metavar="N", help="fly seeds 1 to N (default: 1)")
    robustness.add_argument("--stop", type=float, default=100.0, metavar="S", help="simulated time (default: 100)")
    robustness.add_argument("--out", type=Path, default=RESULTS / "robustness", metavar="DIR", help="results folder")
    robustness.add_argument("--fmus", type=Path, default=FMUS, metavar="DIR", help="folder of the FMUs (default: fmus)")
    robustness.add_argument("--jobs", type=int, metavar="N", help="processes at once (default: one a core)")

    margins = add(
        "margins",
        _margins,
        "gain, phase, delay and disk margins: of the design, and measured through the FMUs, a vendor's too",
        "flexsat margins fmus/centralised/fine_pointing.ssd --controller-fmu vendor.fmu --find-delay",
    )
    add_margin_options(margins)

    add_budget_options(add(
        "budget", _budget, "pointing budget of results after ECSS-E-ST-60-10C, or split by source", BUDGET_EXAMPLE,
    ))  # fmt: skip
    add_spectra_options(add(
        "spectra", _spectra, "spectra of pointing, rate, deformation and torque of results",
        "flexsat spectra results/distributed-fine-pointing --resolution 0.1",
    ))  # fmt: skip
    add_shadow_options(add(
        "shadow", _shadow, "judge a shadow controller: residual of each wheel, the loop before and after its hand-over",
        SHADOW_EXAMPLE,
    ))  # fmt: skip
    add_waterfall_options(add(
        "waterfall", _waterfall, "deformation over wheel speed, from a sweep of short runs, over the Campbell diagram",
        "flexsat waterfall fmus/distributed/fine_pointing_open_loop.ssd --points 24 --stop 20",
    ))  # fmt: skip

    latency = add("probe-latency", probe_as_told, TEXT, "")
    latency.epilog = EXAMPLE.format("flexsat probe-latency")
    add_latency_options(latency)

    timeline = add(
        "timeline",
        _timeline,
        "show who runs when, and which value travels where",
        "flexsat timeline fmus/distributed/slew.ssd --ticks 6 --svg timeline.svg",
    )
    timeline.add_argument("system", type=Path, help="a .ssd file, an unpacked SSP folder, or a .ssp archive")
    add_timing_options(timeline)
    timeline.add_argument("--ticks", type=int, default=6, metavar="N", help="ticks to show (default: 6)")
    timeline.add_argument("--svg", type=Path, metavar="FILE", help="also draw it")

    gate = add(
        "equivalence",
        _equivalence,
        "compare the co-simulation with the same steppers in one plain loop",
        "flexsat equivalence --configuration distributed --scenario slew --duration 30",
    )
    gate.add_argument("--configuration", action="append", choices=("centralised", "distributed"), metavar="NAME",
                      help="centralised or distributed (default: both)")  # fmt: skip
    gate.add_argument("--scenario", action="append", choices=("slew", "fine_pointing", "fine_pointing_open_loop"),
                      metavar="NAME", help="slew, fine_pointing, ... (default: these two)")  # fmt: skip
    gate.add_argument("--seed", type=int, default=1, metavar="N", help="seed of both (default: 1)")
    gate.add_argument("--duration", type=float, default=300.0, metavar="S", help="simulated time (default: 300)")
    gate.add_argument("--record", action="append", metavar="PATTERN", help="signals to compare (default: as recorded)")
    gate.add_argument("--out", type=Path, default=RESULTS / "equivalence", metavar="DIR", help="results folder")
    gate.add_argument("--fmus", type=Path, default=FMUS, metavar="DIR", help="folder of the FMUs (default: fmus)")
    return parser


def _build(options: argparse.Namespace) -> int:
    from . import commands

    return commands.build(options.configuration or ("centralised", "distributed"), options.out, flat=options.flat)


def _check(options: argparse.Namespace) -> int:
    from . import commands

    return commands.check(options)


def _adapt(options: argparse.Namespace) -> int:
    from ..adapt import excitation_of_design as adapting

    return adapting.draft(options)


def _check_adapter(options: argparse.Namespace) -> int:
    from ..adapt import excitation_of_design as adapting

    return adapting.check(options)


def _write_ssp(options: argparse.Namespace) -> int:
    from lockstep.cli.write_ssp_command import write_as_told

    return write_as_told(options)


def _run(options: argparse.Namespace) -> int:
    from . import commands

    return commands.run(options)


def _paper(options: argparse.Namespace) -> int:
    from . import commands

    return commands.paper(options)


def _equivalence(options: argparse.Namespace) -> int:
    from . import commands

    return commands.equivalence(options)


def _branch(options: argparse.Namespace) -> int:
    from . import branch_command as branch

    return branch.command(options)


def _figures(options: argparse.Namespace) -> int:
    from . import figures as command

    return command.draw(options)


def _export(options: argparse.Namespace) -> int:
    from . import commands

    return commands.export(options)


def _report(options: argparse.Namespace) -> int:
    from . import commands

    return commands.report(options)


def _margins(options: argparse.Namespace) -> int:
    from . import margins as command

    return command.margins(options)


def _health(options: argparse.Namespace) -> int:
    from . import health as command

    return command.health(options)


def _robustness(options: argparse.Namespace) -> int:
    from . import health as command

    return command.robustness(options)


def _budget(options: argparse.Namespace) -> int:
    from . import budget as command

    return command.budget(options)


def _spectra(options: argparse.Namespace) -> int:
    from . import spectra as command

    return command.spectra(options)


def _shadow(options: argparse.Namespace) -> int:
    from . import shadow as command

    return command.shadow(options)


def _waterfall(options: argparse.Namespace) -> int:
    from . import waterfall as command

    return command.waterfall(options)


def _timeline(options: argparse.Namespace) -> int:
    from . import commands

    return commands.timeline(options)
