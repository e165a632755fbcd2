"""The command `python -m lockstep run`."""

from __future__ import annotations

from functools import partial

from lockstep.cli.command import command
from lockstep.cli.run_options import RunRequest, run_options
from lockstep.cli.timing_options import implementation
from lockstep.faults import HELP

_EXAMPLES = f"""
examples:
  {{program}} run orbit.ssd --out results/slew --stop-time 300 \\
      --set plant.mass=120 --set plant.initial.mrp=0,0,0.1 --record 'plant.*' --record-period 0.005 \\
      --delay controller:plant=2

checkpoints every minute at real time; resuming after a kill; restarting with another value:
  {{program}} run orbit.ssd --out results/slew --checkpoint-every 60 --pace 1
  {{program}} run --resume results/slew
  {{program}} run --restart-from results/slew/checkpoints/t=120.ckpt --out results/other --set plant.drag=0.2
  A restart keeps overrides, stop time and recording of the checkpointed run; faults are those given now.

a system file of another tool, without step sizes and delays:
  {{program}} run vendor.ssp --step-size 0.001 --step-size aocs/controller=0.01 --stop-time 60 --set command=0
  The step size is that of --step-size, of the file, or the one that the FMU prefers; all step sizes are multiples of
  the tick. An FMU with discrete outputs alone is sampled: its outputs hold from the start of a step. All others are
  continuous: their outputs are true at the end of a step. A connection transfers the newest value: that of the same
  tick from a sampled component, that of one tick ago, which is true now, from a continuous one; --delay overrides.
  `{{program}} show vendor.ssp` prints the result.

inputs from a file, and variables that are no outputs:
  {{program}} run vendor.fmu --input signals.csv --record all --record 'inputs:*' --record 'locals:*'
  The file has a column `time` in seconds; the others are named as inputs, component.variable (of one FMU alone, just
  variable), or as connectors of the system. Continuous Reals are interpolated linearly, all else keeps the value of
  the row before; before the first row and after the last one their values hold. A connected input is refused.

{HELP}"""


@command("run", _EXAMPLES, then='lockstep.read_signals("{path}") in Python: time, signals, units', tables=True)
@run_options
def run(request: RunRequest) -> int:
    """Simulate a system of FMUs and leave its signals in a results folder."""
    from lockstep.cli.checkpoint_options import resume_run
    from lockstep.cli.run_options import run_system
    from lockstep.ssp.load import load_system

    if request.checkpoints.resume is not None:
        resume_run(
            request.checkpoints.resume,
            pace=request.pace,
            step_limit=request.step_limit,
            realtime_priority=request.realtime_priority,
            core=request.core,
            tick=implementation(request.timing.tick),
            threads=request.threads,
            profile=request.profile,
        )
    else:
        load = partial(load_system, timing=request.timing.timing(), within=request.within)
        run_system(request, request.checkpoints.system(request.system, load))
    return 0
