"""Choose the steps that threads make: those that are long enough, where the run is quicker with them than in turn.

A step in a thread costs 5 to 50 us more, since another core has to be woken. So only steps above a threshold are
candidates, and only where another step can run beside them. Whether cores are free for them shows in the run itself:
after an interval in turn follows one with threads, and the quicker way stays. The other one is tried again after a
pause, which doubles as long as the answer is the same: steps may become longer, and other programs may end.
"""

from __future__ import annotations

from collections.abc import Sequence

WORTH = 20e-6  # [s] that a step must take on average
_GAIN = 1.05  # times as many ticks a second that threads must bring
_INTERVAL = 0.2  # [s] for which a way is measured
_SHORTEST, _LONGEST = 0.8, 25.6  # [s] of a pause

NONE: frozenset[int] = frozenset()


class ThreadChoice:
    """Which jobs are in threads, judged between two ticks from time to time."""

    def __init__(self, beside: frozenset[int], *, always: bool = False) -> None:
        """Begin in turn. `beside` are the jobs during which another one can run; `always`: all of them in threads."""
        self.chosen = beside if always else NONE
        self._beside, self._always = beside, always
        self._worth = NONE
        self._rates: dict[bool, float] = {}  # ticks a second, in turn and with threads
        self._began: tuple[float, int] | None = None  # the interval that is measured: wall time [s] and tick
        self._pause, self._next = _SHORTEST, 0.0  # when another measurement begins [s]
        self._measuring = True

    def look(self, now: float, tick: int, means: Sequence[float]) -> frozenset[int]:
        """Return the jobs that are in threads from now on.

        Parameters
        ----------
        now : wall time [s]
        tick : the first tick that is not complete
        means : of each job, what a step has taken on average [s]
        """
        if self._always or not self._beside:
            return self.chosen
        if not self._measuring:
            if now < self._next:
                return self.chosen
            self._rates, self._measuring, self._began = {}, True, None
        if self._began is None:
            self._began = now, tick
            return self.chosen
        since, first = self._began
        if now - since < _INTERVAL or tick - first < 2:
            return self.chosen
        self._rates[bool(self.chosen)] = (tick - first) / (now - since)
        self._worth = frozenset(number for number in self._beside if means[number] > WORTH)
        self._began = now, tick
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
        self.chosen = self._worth if threads else NONE
        self._wait(now, same=bool(self.chosen) != bool(before))  # the way before this measurement was the other one

    def _wait(self, now: float, *, same: bool) -> None:
        self._pause = min(2.0 * self._pause, _LONGEST) if same else _SHORTEST
        self._next, self._measuring = now + self._pause, False
