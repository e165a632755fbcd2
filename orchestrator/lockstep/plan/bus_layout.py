"""Where every exchanged value lies in memory, for one whole cycle of the schedule. Pure integers.

All fetched outputs of one type share one array, the bus. A producer owns a ring of slots on it, and version v
of its outputs lies in slot v modulo the ring's size, sorted by value reference. Only outputs that somebody
reads of a version are fetched, so a slot's contents differ from version to version, with the period of the
cycle. Versions before the first are the initial outputs: the plan needs no special first tick.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

from lockstep.fmi.slave import SCALARS, Scalar
from lockstep.plan.schedule import Schedule, Task, cycle_length, ring_size
from lockstep.plan.wiring import Link

Reference = tuple[Scalar, int]  # type and value reference: what identifies a variable of an FMU
Contents = Mapping[Scalar, Mapping[int, int]]  # of a version, by type: the rank of each reference, ascending
Place = tuple[int, int]  # where a version's values of one type begin on the bus, and the number of its contents


@dataclass(frozen=True)
class Layout:
    """The memory plan. `recorded` maps a component to what is recorded of it every `record_ticks`.

    `held` are recorded values that a step takes at its start and keeps, which are inputs and parameters: true from the
    start of the newest step on, whatever the kind of the component. `compared` are outputs that a shadow is
    compared by.
    """

    schedule: Schedule
    links: tuple[Link, ...]
    recorded: Mapping[str, tuple[Reference, ...]]
    record_ticks: int
    held: Mapping[str, tuple[Reference, ...]] = field(default_factory=dict)
    compared: Mapping[str, frozenset[Reference]] = field(default_factory=dict)

    @property
    def records(self) -> bool:
        """Whether anything is recorded."""
        return bool(self.recorded or self.held)

    def records_at(self, tick: int) -> bool:
        """Return whether a row is recorded at a tick."""
        return self.records and tick % self.record_ticks == 0

    @cached_property
    def transferred(self) -> dict[str, frozenset[Reference]]:
        """The outputs of each component that connections transfer."""
        found: dict[str, set[Reference]] = {task.name: set() for task in self.schedule.tasks}
        for link in self.links:
            found[link.producer].update((link.scalar, source) for source in link.sources)
        return {name: frozenset(references) for name, references in found.items()}

    @cached_property
    def used(self) -> dict[str, frozenset[Reference]]:
        """The outputs of each component that something reads beside the recorder."""
        return {name: found | self.compared.get(name, frozenset()) for name, found in self.transferred.items()}

    @cached_property
    def rings(self) -> dict[str, int]:
        """How many versions of each component are kept."""
        lags: dict[str, set[int]] = {task.name: set() for task in self.schedule.tasks}
        for tick in range(self.schedule.hyperperiod(self.record_ticks)):
            for producer, reader, version, _ in self.reads(tick):
                lags[producer.name].add(self.schedule.begun_when_read(producer, reader, tick) - version)
        return {name: ring_size(values) for name, values in lags.items()}

    @cached_property
    def cycle(self) -> int:
        """The ticks after which plan and slots repeat."""
        hyperperiod = self.schedule.hyperperiod(self.record_ticks)
        return cycle_length(hyperperiod, self.rings, self.schedule.tasks)

    @cached_property
    def _versions(self) -> tuple[dict[str, list[int]], list[Contents]]:
        """The number of the contents of each version modulo the cycle, by component; and all different contents."""
        needed: dict[str, list[set[int]]] = {
            task.name: [set() for _ in range(self.cycle // task.period)] for task in self.schedule.tasks
        }
        for tick in range(self.cycle):
            for producer, _, version, group in self.reads(tick):
                versions = needed[producer.name]
                versions[version % len(versions)].add(group)
        numbers: dict[frozenset[int], int] = {}
        for versions in needed.values():
            for groups in versions:
                numbers.setdefault(frozenset(groups), len(numbers))
        numbered = {name: [numbers[frozenset(groups)] for groups in versions] for name, versions in needed.items()}
        return numbered, [self._contents(groups) for groups in numbers]

    def _contents(self, groups: Iterable[int]) -> Contents:
        found: dict[Scalar, set[int]] = {scalar: set() for scalar in SCALARS}
        for number in groups:
            for scalar, reference in self.groups[number]:
                found[scalar].add(reference)
        return {scalar: {r: rank for rank, r in enumerate(sorted(refs))} for scalar, refs in found.items()}

    @cached_property
    def groups(self) -> list[Sequence[Reference]]:
        """The values that are read together: of each link, then of each component, those recorded and those held."""
        links: list[Sequence[Reference]] = [[(link.scalar, s) for s in link.sources] for link in self.links]
        return [*links, *self.recorded.values(), *self.held.values()]

    @cached_property
    def _bases(self) -> dict[tuple[str, Scalar], tuple[int, int]]:
        """Where a component's ring begins on the bus, and how wide a slot is."""
        bases: dict[tuple[str, Scalar], tuple[int, int]] = {}
        numbers, contents = self._versions
        for scalar in SCALARS:
            start = 0
            for task in self.schedule.tasks:
                width = max(len(contents[number][scalar]) for number in set(numbers[task.name]))
                bases[task.name, scalar] = (start, width)
                start += width * self.rings[task.name]
        return bases

    def bus_size(self, scalar: Scalar) -> int:
        """Return how many values of this type the bus holds."""
        return sum(width * self.rings[name] for (name, kind), (_, width) in self._bases.items() if kind == scalar)

    def place_of(self, name: str, scalar: Scalar, version: int) -> Place:
        """Return where a version of a component's outputs lies on the bus; equal places hold the same variables."""
        start, width = self._bases[name, scalar]
        versions = self._versions[0][name]
        return start + version % self.rings[name] * width, versions[version % len(versions)]

    def fetched(self, name: str, scalar: Scalar, version: int) -> tuple[int, list[int]]:
        """Return where a version of a component's outputs begins on the bus, and what it holds."""
        start, number = self.place_of(name, scalar, version)
        return start, list(self._versions[1][number][scalar])

    def position(self, name: str, scalar: Scalar, reference: int, version: int) -> int:
        """Return where one value of a version lies on the bus."""
        start, number = self.place_of(name, scalar, version)
        return start + self._versions[1][number][scalar][reference]

    def positions(self, name: str, scalar: Scalar, references: Iterable[int], version: int) -> list[int]:
        """Return where some values of a version lie on the bus."""
        start, number = self.place_of(name, scalar, version)
        ranks = self._versions[1][number][scalar]
        return [start + ranks[reference] for reference in references]

    @cached_property
    def feeding(self) -> dict[str, list[Link]]:
        """The links to each component."""
        return {name: [link for _, link in links] for name, links in self._feeding.items()}

    @cached_property
    def _feeding(self) -> dict[str, list[tuple[int, Link]]]:
        """The links to each component, with their numbers."""
        feeding: dict[str, list[tuple[int, Link]]] = {task.name: [] for task in self.schedule.tasks}
        for number, link in enumerate(self.links):
            feeding[link.consumer].append((number, link))
        return feeding

    def renewed(self, reader: Task, tick: int) -> list[tuple[Link, int]]:
        """Return the links whose value is another than at the reader's previous step, and the version to read."""
        return [(link, version) for _, link, version in self._renewed(reader, tick)]

    def _renewed(self, reader: Task, tick: int) -> list[tuple[int, Link, int]]:
        found = []
        for number, link in self._feeding[reader.name]:
            seen = self.schedule.task(link.producer).seen
            version = seen(tick, link.delay)
            if version != seen(tick - reader.period, link.delay):
                found.append((number, link, version))
        return found

    def reads(self, tick: int) -> Iterable[tuple[Task, Task | None, int, int]]:
        """Yield what is read at this tick: producer, reader (None: the recorder), version and number of the group."""
        task = self.schedule.task
        for reader in self.schedule.tasks:
            if reader.steps_at(tick):
                for number, link, version in self._renewed(reader, tick):
                    yield task(link.producer), reader, version, number
        if tick % self.record_ticks == 0:
            number = len(self.links)
            for name in self.recorded:
                yield task(name), None, task(name).true_at(tick), number
                number += 1
            for name in self.held:
                yield task(name), None, task(name).begun(tick), number
                number += 1


def by_scalar(references: Iterable[Reference]) -> dict[Scalar, list[int]]:
    """Group references by type, in the order of SCALARS."""
    found: dict[Scalar, list[int]] = {scalar: [] for scalar in SCALARS}
    for scalar, reference in references:
        found[scalar].append(reference)
    return {scalar: numbers for scalar, numbers in found.items() if numbers}
