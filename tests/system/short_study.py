"""Run `flexsat` with the paper's runs cut to seconds: a short slew, and windows of the metrics that begin after it.

Workers of a study import this module for the function that they run, and so are changed too. Figures of the design are
left out, which the study of whole runs draws, and the build, which that of `flexsat build` is: its FMUs are linked.
"""

import os
import shutil
import sys
from functools import partial
from pathlib import Path

from flexbench.engine import jobs
from flexbench.loop import scenarios
from flexbench.loop.build_options import STANDARD
from flexbench.runs import metrics
from flexsat.description.built_in import CONFIGURATIONS
from flexsat.parameters import Slew

metrics.SETTLED_FROM, metrics.PUBLISHED_WINDOW, metrics.LAST = 1.5, (0.5, 1.5), 1.0  # s
scenarios.Slew = partial(Slew, rotation=(5e-6, 0.0, 0.0), start_time=0.35)  # ends at 1.44 s
run_as_delivered = jobs.run_job


def run_job(job):
    """Run a job in a process that has imported this module."""
    return run_as_delivered(job)


def link_build(built, names, folder, print_line, *, options, without_native):
    """Stand in for a build of both layouts with FMUs in C."""
    assert (tuple(names), options, callable(without_native)) == (tuple(CONFIGURATIONS), STANDARD, True)
    shutil.copytree(built, folder, copy_function=os.link, ignore=shutil.ignore_patterns("flat", "closed"))
    for path in sorted(folder.rglob("*.fmu")):
        print_line(str(path))


if __name__ == "__main__":
    import short_study

    from flexbench.cli.parser import main
    from flexbench.loop import build
    from flexbench.report import paper_pages

    built, *arguments = sys.argv[1:]
    jobs.run_job = short_study.run_job
    build.build_all = partial(link_build, Path(built))
    paper_pages.design_figures = lambda _: {}
    sys.exit(main(arguments))
