"""`flexsat waterfall`."""

from __future__ import annotations

import argparse
from pathlib import Path

from flexsat.parameters import RPM
from lockstep import InputError

from ..html.text_table import format_table
from ..studies.waterfall.sweep import RESULT, design_of, read_waterfall, sweep
from ..studies.waterfall.tables import HEADER, flagged_rows, summary


def waterfall(options: argparse.Namespace) -> int:
    """Run the sweep; print the crossings inside an allowed band."""
    from ..figures import save_figure
    from ..figures.waterfall import waterfall_figure

    if options.jobs is not None and options.jobs < 1:
        raise InputError(f"--jobs {options.jobs}: must be 1 or more")
    span = (options.range[0] * RPM, options.range[1] * RPM) if options.range else None
    design = design_of(options.system)
    folder = options.out or Path("results") / f"{design.config.name}-waterfall"
    result = sweep(options.system, design, folder, options.points, options.stop, options.seed, span, options.jobs)
    paths = save_figure(waterfall_figure(result, design), folder / "figures", "waterfall")
    content = read_waterfall(folder)
    if content is not None:
        print(summary(content))
        if flagged := flagged_rows(content):
            print(format_table(HEADER, flagged, left=0))
    print("\n".join(map(str, [folder / RESULT, *paths])))
    return 0
