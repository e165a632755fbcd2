"""By command and option: the test that shows the effect of the option on the result, or that it is refused.

One module a subject; a test is named by its file below `tests/` and its function.
"""

from . import foreign, results, simulating, studies, systems

EFFECTS = foreign.EFFECTS | results.EFFECTS | simulating.EFFECTS | studies.EFFECTS | systems.EFFECTS
