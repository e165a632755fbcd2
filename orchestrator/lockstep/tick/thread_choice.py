"""Choose the steps that threads make: those that are long enough, where the run is quicker with them than in turn.

A step in a thread costs 5 to 50 us more, since another core has to be woken. So only steps above a threshold are
candidates, and only where another step can run beside them. Whether cores are free for them shows in the run itself:
after an interval in turn follows one with threads, and the quicker way stays. Steps in turn try threads again after a
pause, which doubles as long as the answer is the same: steps may become longer, and other programs may end. Threads
are measured all the time: they try steps in turn again when the ticks become slower, and after the longest pause.

Times are those that the run works: what it waits for real time, or for its caller, says nothing about either way.
"""

from __future__ import annotations

from collections.abc import Sequence

WORTH = 20e-6  # [s] that a step must take on average
_GAIN = 1.05  # times as many ticks a second that threads must bring
_KEPT = 0.8  # of the ticks a second that threads brought: below it they are compared again
_INTERVAL = 0.08  # [s] for which a way is measured at least: from one look to the next
_SHORTEST, _LONGEST = 0.8, 25.6  # [s] of a pause

NONE: frozenset[int] = frozenset()


class ThreadChoice:
    """Which jobs are in threads, judged between two ticks from time to time."""

    def __init__(self, beside: frozenset[int], tick: int = 0, *, always: bool = False) -> None:
        """Begin in turn, at time 0 and a tick.

        `beside` are the jobs during which another one can run; `always`: all of them in threads.
        """
        self.chosen = beside if always else NONE
        self._beside, self._always = beside, always
        self._worth = NONE
        self._rates: dict[bool, float] = {}  # ticks a second, in turn and with threads
        self._began = 0.0, tick  # the interval that is measured: its first time [s] and tick
        self._brought = 0.0  # ticks a second that threads brought when they were chosen
        self._pause, self._soonest, self._next = _SHORTEST, 0.0, 0.0  # when another measurement begins [s]
        self._measuring = True

    def look(self, now: float, tick: int, means: Sequence[float]) -> frozenset[int]:
        """Return the jobs that are in threads from now on.

        Parameters
        ----------
        now : time for which the run has worked [s]
        tick : the first tick that is not complete
        means : of each job, what a step has taken on average [s]
        """
        if self._always or not self._beside:
            return self.chosen
        since, first = self._began
        if tick < first:  # the run went back
            self._began = now, tick
            return self.chosen
        if now - since < _INTERVAL or tick - first < 2:
            return self.chosen
        self._began = now, tick
        rate = (tick - first) / (now - since)
        if not self._measuring:
            slower = bool(self.chosen) and rate < _KEPT * self._brought
            if now < (self._soonest if slower else self._next):
                return self.chosen
            self._rates, self._measuring = {}, True
        self._rates[bool(self.chosen)] = rate
        self._worth = frozenset(number for number in self._beside if means[number] > WORTH)
        if len(self._rates) == 2:
            self._settle(now)
        elif self.chosen:
            self.chosen = NONE
        elif self._worth:
            self.chosen = self._worth
        else:
            self._wait(now, same=True)
        return self.chosen

    def _settle(self, now: float) -> None:
        """Take the quicker of the two ways."""
        before = self.chosen
        threads = bool(self._worth) and self._rates[True] > _GAIN * self._rates[False]
        self.chosen, self._brought = self._worth if threads else NONE, self._rates[True]
        self._wait(now, same=bool(self.chosen) != bool(before))  # the way before this measurement was the other one

    def _wait(self, now: float, *, same: bool) -> None:
        self._pause = min(2.0 * self._pause, _LONGEST) if same else _SHORTEST
        self._soonest, self._measuring = now + self._pause, False
        self._next = now + _LONGEST if self.chosen else self._soonest
