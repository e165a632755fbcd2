"""Run `flexsat` with the paper's runs cut to seconds: a short slew, and windows of the metrics that begin after it.

Workers of a study import the main module of their parent, and so are changed too. Figures of the design are left out:
the study of whole runs draws them.
"""

from functools import partial

from flexbench.loop import scenarios
from flexbench.runs import metrics
from flexsat.parameters import Slew

metrics.SETTLED_FROM, metrics.PUBLISHED_WINDOW, metrics.LAST = 1.5, (0.5, 1.5), 1.0  # s
scenarios.Slew = partial(Slew, rotation=(5e-6, 0.0, 0.0), start_time=0.35)  # ends at 1.44 s

if __name__ == "__main__":
    from flexbench.cli.parser import program
    from flexbench.report import paper_pages

    paper_pages.design_figures = lambda _: {}
    program()
