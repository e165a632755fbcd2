"""End a campaign once its runs are enough, by a rule such as `p95(pointing) within 5 %`."""

from __future__ import annotations

from collections.abc import Callable

from .campaign_file import Campaign
from .result_file import Results
from .samples import samples_of
from .statistics.stop_rule import FIRST_LOOK, State, next_look, parse_rule, states


class StopRule:
    """Look at the first runs of a campaign, as often as the rule says; callable as `until` of `run_campaign`.

    Parameters
    ----------
    text : the rule
    campaign : whose metrics and requirements it names
    report : called with a line of text at each look
    """

    def __init__(self, text: str, campaign: Campaign, report: Callable[[str], None]) -> None:
        self._requirements = campaign.requirements
        self._conditions = parse_rule(text, [one.name for one in campaign.metrics], campaign.requirements)
        self._report = report
        self._next = FIRST_LOOK
        self.states: list[State] = []  # at the last look

    def __call__(self, results: Results) -> bool:
        """Return whether these runs, the first ones of the campaign, are enough."""
        count = len(results.numbers)
        if count < self._next:
            return False
        self._next = next_look(count)
        samples = samples_of(results)
        self.states = [state for sample in samples for state in states(self._conditions, sample, self._requirements)]
        self._report(f"{count} runs: {'; '.join(map(_text, self.states))}")
        return all(state.satisfied for state in self.states)


def _text(state: State) -> str:
    needed = "" if state.satisfied or state.needed is None else f", about {state.needed} runs of this system needed"
    return f"{state.condition.text}, {state.system}: {state.text}{needed}"
