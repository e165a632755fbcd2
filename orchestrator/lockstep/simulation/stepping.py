"""Open a run that is stepped from Python."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import Unpack

from lockstep.interrupt import Interrupt, attend, deferred_interrupt
from lockstep.results.results_folder import ResultsFolder
from lockstep.simulation.open_run import open_run
from lockstep.simulation.options import NamedOptions, RunOptions, chosen_options
from lockstep.simulation.stepped_run import Run
from lockstep.simulation.system_of_fmus import Delays, Fmus, Pairs, Periods, as_system
from lockstep.system.component import Kind
from lockstep.system.system import System


def open(
    system: System | Path | str | Fmus,
    folder: Path | str | ResultsFolder | None = None,
    options: RunOptions | None = None,
    *,
    connections: Pairs = (),
    periods: Periods | None = None,
    delays: Delays | None = None,
    kinds: Mapping[str, Kind] | None = None,
    **named: Unpack[NamedOptions],
) -> Run:
    """Open a run that is stepped: check the system, start and initialise the FMUs, and stay at the start time.

    Parameters are those of `simulate`. Raises InputError if anything in the input is wrong.

    Examples
    --------
    A control law in Python::

        with lockstep.open("loop.ssd", stop_time=10.0) as run:
            for time in run:
                run.set("plant.torque", -2.0 * run["plant.rate"])
        run.signals["plant.rate"]
    """
    chosen = chosen_options(options, named)
    interrupt = Interrupt()
    with ExitStack() as stack:
        with deferred_interrupt() as opening:
            opened = open_run(as_system(system, connections, periods, delays, kinds), folder, chosen, opening, stack)
        opened.interrupt, opened.stops_between_ticks = interrupt, True
        attend(interrupt)
        return Run(opened, interrupt, stack.pop_all())
