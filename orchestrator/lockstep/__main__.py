"""The program `python -m lockstep`."""

import sys
from collections.abc import Sequence

from lockstep.cli.program import CommandGroup
from lockstep.interrupt import end_program

PROGRAM = CommandGroup(
    "python -m lockstep",
    {
        "run": ("lockstep.cli.run", "simulate a system"),
        "show": ("lockstep.cli.show", "print components, step sizes, order and delays of a system"),
        "write-ssp": ("lockstep.cli.write_ssp", "write a system with a foreign FMU as standard SSP"),
        "bundle": ("lockstep.cli.bundle", "write a system as one FMU"),
        "check": ("lockstep.cli.check", "accept or refuse FMUs"),
        "probe-latency": ("lockstep.cli.probe_latency", "measure the delay from each input of an FMU to each output"),
    },
    label="lockstep",
    description="Simulate systems of FMUs (SSP, OSP), or one FMU.",
    epilog="example:\n  {program} run orbit.ssd --out results/slew --stop-time 300",
)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line and return the exit code, as `CommandGroup.run`: 130 after Ctrl-C, 143 after SIGTERM."""
    return PROGRAM.run(arguments)


if __name__ == "__main__":
    code = main()
    sys.stdout.flush()
    sys.stderr.flush()
    end_program(code)
