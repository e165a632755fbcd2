"""The program `flexsat`: its commands, and the number of threads they may use."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import NoReturn

from lockstep.cli.program import CommandGroup

# One thread a process: the matrices are small, and several runs share the machine. Before numpy is imported.
for _variable in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_variable, "1")

PROGRAM = CommandGroup(
    "flexsat",
    {
        "build": ("flexbench.cli.build", "build the FMUs, the system files and the interface document"),
        "new": ("flexbench.cli.spacecraft.new", "write a spacecraft file to start from"),
        "spacecraft": ("flexbench.cli.spacecraft.spacecraft", "show a spacecraft's mass, modes and wheels"),
        "modal": ("flexbench.cli.spacecraft.modal", "check and convert the modal data of a structure"),
        "run": ("flexbench.cli.run", "simulate a system; record its signals and metrics"),
        "paper": ("flexbench.cli.paper", "reproduce the paper's six runs and its table"),
        "branch": ("flexbench.cli.branch", "simulate variants from one checkpoint"),
        "campaign": ("flexbench.cli.campaign.campaign", "simulate thousands of dispersed runs; repeat one"),
        "report": ("flexbench.cli.report", "write a report of one or several runs as an HTML page"),
        "figures": ("flexbench.cli.figures", "draw the design or the results of runs"),
        "export": ("flexbench.cli.export", "write the signals of a run for other tools"),
        "export-c": ("flexbench.cli.export_c", "write the controller alone as C99 for flight software"),
        "margins": ("flexbench.cli.margins", "compute and measure stability margins"),
        "budget": ("flexbench.cli.budget", "compute the pointing budget after ECSS-E-ST-60-10C"),
        "spectra": ("flexbench.cli.spectra", "compute spectra of pointing, rate, deformation and torque"),
        "health": ("flexbench.cli.health", "test the consistency of the estimator: NIS, NEES, whiteness"),
        "robustness": ("flexbench.cli.robustness", "test the robustness to errors of modes and inertia"),
        "compare-layouts": (
            "flexbench.cli.compare_layouts",
            "compare centralised and distributed wheels under dispersions",
        ),
        "waterfall": ("flexbench.cli.waterfall", "draw the deformation over wheel speed, with the Campbell diagram"),
        "shadow": ("flexbench.cli.shadow", "evaluate a run with a shadow controller"),
        "equivalence": ("flexbench.cli.equivalence", "compare the co-simulation with the monolith"),
        "check": ("flexbench.cli.check", "check FMUs from any tool for acceptance"),
        "adapt": ("flexbench.cli.adapt", "draft the adapter of a foreign FMU"),
        "check-adapter": ("flexbench.cli.check_adapter", "check the conventions in a controller's adapter"),
        "probe-latency": ("lockstep.cli.probe_latency", "measure the delay from each input of an FMU to each output"),
        "write-ssp": ("lockstep.cli.write_ssp", "write a system with a foreign FMU as standard SSP"),
        "bundle": ("lockstep.cli.bundle", "write a system as one FMU"),
        "timeline": ("flexbench.cli.timeline", "show the order of steps and transfers in a tick"),
    },
    label="flexsat",
    description="Co-simulation bench for the attitude control of large flexible spacecraft.",
    epilog="examples:\n  {program} build\n  {program} run fmus/distributed/slew.ssd --stop-time 60",
    interrupted="interrupted; what was simulated is in the results folder",
)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line and return the exit code, as `CommandGroup.run`: 130 after Ctrl-C, 143 after SIGTERM."""
    return PROGRAM.run(arguments)


def program() -> NoReturn:
    """Run the command line and exit."""
    code = main()
    from lockstep.interrupt import end_program

    end_program(code)
