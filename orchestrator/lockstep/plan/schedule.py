"""Compute when and in which order components are stepped, and which version of an output a reader sees, in ticks.

Let a component with period P and offset O (in ticks) begin its steps at ticks O, O + P, ... and call the
outputs of its v-th step version v; version 0 is its initial outputs. A step begun at tick j produces its
outputs

- in tick j, if the component is sampled: its outputs hold from the step's start on;
- in tick j + P - 1, if it is continuous: its outputs are true at the end of the step, which is the end of
  that tick.

A reader at tick k with delay n sees the newest version produced by the end of tick k - n. With n = 0 the
producer has to be stepped first in the tick. A continuous producer cannot be read with n = 0: the value
would be one of the future. With n = 1 a reader sees the value that is true now.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import gcd, lcm

from lockstep.errors import InputError
from lockstep.system.clock import Time, seconds_text
from lockstep.system.system import Connection, System

LONGEST_CYCLE = 20_000  # [ticks]; bounds the size of the precomputed plan


@dataclass(frozen=True, slots=True, kw_only=True)
class Task:
    """When one component is stepped, in ticks."""

    name: str
    period: int
    offset: int = 0
    continuous: bool = False
    after_row: bool = False  # sampled, and its step at a tick is made after the row of that tick is recorded

    def steps_at(self, tick: int) -> bool:
        """Return whether a step begins at this tick."""
        return (tick - self.offset) % self.period == 0

    def begun(self, tick: int) -> int:
        """Return the version made by the newest step begun at or before this tick.

        Before the first step the number is zero or negative: the initial outputs.
        """
        return (tick - self.offset) // self.period + 1

    def seen(self, tick: int, delay: int) -> int:
        """Return the version that a reader at this tick sees through this delay."""
        produced_later = self.period - 1 if self.continuous else 0
        return self.begun(tick - delay - produced_later)

    def true_at(self, tick: int) -> int:
        """Return the version whose values are true at this tick's time: the one to record."""
        return self.seen(tick, 1 if self.continuous or self.after_row else 0)


@dataclass(frozen=True, kw_only=True)
class Schedule:
    """Tasks in the order in which they are stepped within a tick."""

    tick: Time  # [ns]
    tasks: tuple[Task, ...]
    start: Time = 0  # simulated time of tick 0 [ns]

    def time(self, tick: int) -> Time:
        """Return the simulated time at which a tick begins [ns]."""
        return self.start + tick * self.tick

    @cached_property
    def _places(self) -> dict[str, int]:
        """The place of each component in the order of a tick."""
        return {task.name: place for place, task in enumerate(self.tasks)}

    def task(self, name: str) -> Task:
        """Return the task of a component."""
        return self.tasks[self._places[name]]

    def hyperperiod(self, *more: int) -> int:
        """Return the number of ticks after which everything repeats, `more` periods included."""
        cycle = lcm(*(task.period for task in self.tasks), *more)
        if cycle > LONGEST_CYCLE:
            periods = ", ".join(f"{task.name} {seconds_text(task.period * self.tick)} s" for task in self.tasks)
            if more:
                periods += ", recording " + ", ".join(f"{seconds_text(ticks * self.tick)} s" for ticks in more)
            raise InputError(
                f"the periods repeat after {cycle} ticks only, more than {LONGEST_CYCLE}: {periods}; "
                "choose periods with a smaller common multiple"
            )
        return cycle

    def begun_when_read(self, producer: Task, reader: Task | None, tick: int) -> int:
        """Return the producer's newest version at the moment of a read; the recorder (None) reads last."""
        if reader is not None and self._places[producer.name] >= self._places[reader.name]:
            return producer.begun(tick - 1)
        return producer.begun(tick)


def build_schedule(system: System) -> Schedule:
    """Order the components of a system.

    Raises
    ------
    InputError
        If a period or offset is not a whole multiple of the tick, a same-tick connection leaves a continuous
        component, or same-tick connections form a cycle.
    """
    tasks = [
        Task(
            name=c.name,
            period=_ticks(c.period, system.tick, f"{c.name}: period"),
            offset=_ticks(c.offset, system.tick, f"{c.name}: offset"),
            continuous=c.kind == "continuous",
        )
        for c in system.components
    ]
    by_name = {task.name: task for task in tasks}
    for connection in system.connections:
        if connection.delay == 0 and by_name[connection.from_component].continuous:
            raise InputError(
                f"{connection}: a same-tick value of a continuous component is one of the future; "
                "give the connection a delay of 1 tick, which is the value true now"
            )
    ordered = _order(tasks, _before(by_name, system.connections))
    return Schedule(tick=system.tick, tasks=tuple(ordered), start=system.start_time)


def whole_ticks(time: Time, tick: Time, what: str) -> int:
    """Return a time in ticks; refuse by name what is not a positive whole number of them."""
    ticks = _ticks(time, tick, what)
    if ticks <= 0:
        raise InputError(f"{what} {seconds_text(time)} s must be > 0")
    return ticks


def ring_size(lags: Iterable[int]) -> int:
    """Return how many versions of a producer to keep when readers lag behind the newest by `lags`.

    A power of two, so that rings of several producers do not multiply the length of the cycle.
    """
    return 1 << max(lags, default=0).bit_length()


def cycle_length(hyperperiod: int, rings: Mapping[str, int], tasks: Sequence[Task]) -> int:
    """Return the number of ticks after which the schedule and every ring of versions repeat."""
    turns = 1
    for task in tasks:
        steps = hyperperiod // task.period
        ring = rings[task.name]
        turns = lcm(turns, ring // gcd(ring, steps))
    if hyperperiod * turns > LONGEST_CYCLE:
        raise InputError(
            f"periods and delays repeat after {hyperperiod * turns} ticks only, more than {LONGEST_CYCLE}; "
            "choose shorter delays or periods with a smaller common multiple"
        )
    return hyperperiod * turns


def _ticks(time: Time, tick: Time, what: str) -> int:
    if time % tick:
        lower = time // tick * tick
        near = " or ".join(f"{seconds_text(t)} s" for t in (lower, lower + tick) if t > 0)
        raise InputError(
            f"{what} {seconds_text(time)} s is not a whole multiple of the tick {seconds_text(tick)} s; choose {near}"
        )
    return time // tick


def _before(tasks: Mapping[str, Task], connections: Sequence[Connection]) -> dict[str, set[str]]:
    """Return, for each component, those that have to be stepped before it in a tick."""
    before: dict[str, set[str]] = {name: set() for name in tasks}
    for pair in {(c.from_component, c.to_component) for c in connections if c.delay == 0}:
        producer, consumer = tasks[pair[0]], tasks[pair[1]]
        if (producer.offset - consumer.offset) % gcd(producer.period, consumer.period) == 0:  # they have common steps
            before[pair[1]].add(pair[0])
    return before


def _order(tasks: Sequence[Task], before: Mapping[str, set[str]]) -> list[Task]:
    """Sort producers first; among free choices keep the order of the file."""
    ordered: list[Task] = []
    placed: set[str] = set()
    while len(ordered) < len(tasks):
        free = next((t for t in tasks if t.name not in placed and before[t.name] <= placed), None)
        if free is None:
            members = _cycle({t.name for t in tasks} - placed, before)
            remedy = f"give one of them a delay of 1 tick or more, such as --delay {members[0]}:{members[1]}=1"
            raise InputError(f"same-tick connections form a cycle: {' -> '.join(members)}; {remedy}")
        ordered.append(free)
        placed.add(free.name)
    return ordered


def _cycle(stuck: set[str], before: Mapping[str, set[str]]) -> list[str]:
    """Walk back from producer to producer until a name returns."""
    path = [min(stuck)]
    while True:
        producer = min(before[path[-1]] & stuck)
        if producer in path:
            return [producer, *reversed(path[path.index(producer) :])]
        path.append(producer)
