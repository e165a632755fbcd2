"""Where every exchanged value lies in memory, for one whole cycle of the schedule. Pure integers.

All fetched outputs of one type share one array, the bus. A producer owns a ring of slots on it, and version v
of its outputs lies in slot v modulo the ring's size, sorted by value reference. Only outputs that somebody
reads of a version are fetched, so a slot's contents differ from version to version, with the period of the
cycle. Versions before the first are the initial outputs: the plan needs no special first tick.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

from lockstep.fmi.slave import SCALARS, Scalar
from lockstep.plan.schedule import Schedule, Task, cycle_length, ring_size
from lockstep.plan.wiring import Link

Reference = tuple[Scalar, int]  # type and value reference: what identifies a variable of an FMU


@dataclass(frozen=True)
class Layout:
    """The memory plan. `recorded` maps a component to what is recorded of it every `record_ticks`."""

    schedule: Schedule
    links: tuple[Link, ...]
    recorded: Mapping[str, tuple[Reference, ...]]
    record_ticks: int

    @cached_property
    def rings(self) -> dict[str, int]:
        """How many versions of each component are kept."""
        lags: dict[str, list[int]] = {task.name: [] for task in self.schedule.tasks}
        for tick in range(self.schedule.hyperperiod(self.record_ticks)):
            for producer, reader, version, _ in self.reads(tick):
                lags[producer.name].append(self.schedule.begun_when_read(producer, reader, tick) - version)
        return {name: ring_size(values) for name, values in lags.items()}

    @cached_property
    def cycle(self) -> int:
        """The ticks after which plan and slots repeat."""
        hyperperiod = self.schedule.hyperperiod(self.record_ticks)
        return cycle_length(hyperperiod, self.rings, self.schedule.tasks)

    @cached_property
    def _contents(self) -> dict[tuple[str, Scalar], list[list[int]]]:
        """The value references of each version modulo the cycle, sorted."""
        needed: dict[tuple[str, Scalar], list[set[int]]] = {
            (task.name, scalar): [set() for _ in range(self.cycle // task.period)]
            for task in self.schedule.tasks
            for scalar in SCALARS
        }
        for tick in range(self.cycle):
            for producer, _, version, references in self.reads(tick):
                for scalar, reference in references:
                    versions = needed[producer.name, scalar]
                    versions[version % len(versions)].add(reference)
        return {key: [sorted(version) for version in versions] for key, versions in needed.items()}

    @cached_property
    def _bases(self) -> dict[tuple[str, Scalar], tuple[int, int]]:
        """Where a component's ring begins on the bus, and how wide a slot is."""
        bases: dict[tuple[str, Scalar], tuple[int, int]] = {}
        for scalar in SCALARS:
            start = 0
            for task in self.schedule.tasks:
                width = max(map(len, self._contents[task.name, scalar]))
                bases[task.name, scalar] = (start, width)
                start += width * self.rings[task.name]
        return bases

    @cached_property
    def _ranks(self) -> dict[tuple[str, Scalar], list[dict[int, int]]]:
        return {
            key: [{reference: rank for rank, reference in enumerate(version)} for version in versions]
            for key, versions in self._contents.items()
        }

    def bus_size(self, scalar: Scalar) -> int:
        """Return how many values of this type the bus holds."""
        return sum(width * self.rings[name] for (name, kind), (_, width) in self._bases.items() if kind == scalar)

    def fetched(self, name: str, scalar: Scalar, version: int) -> tuple[int, list[int]]:
        """Return where a version of a component's outputs begins on the bus, and what it holds."""
        start, width = self._bases[name, scalar]
        versions = self._contents[name, scalar]
        return start + version % self.rings[name] * width, versions[version % len(versions)]

    def position(self, name: str, scalar: Scalar, reference: int, version: int) -> int:
        """Return where one value of a version lies on the bus."""
        start, width = self._bases[name, scalar]
        ranks = self._ranks[name, scalar]
        return start + version % self.rings[name] * width + ranks[version % len(ranks)][reference]

    def renewed(self, reader: Task, tick: int) -> list[tuple[Link, int]]:
        """Return the links whose value is another than at the reader's previous step, and the version to read."""
        found = []
        for link in self.links:
            if link.consumer != reader.name:
                continue
            seen = self.schedule.task(link.producer).seen
            version = seen(tick, link.delay)
            if version != seen(tick - reader.period, link.delay):
                found.append((link, version))
        return found

    def reads(self, tick: int) -> Iterable[tuple[Task, Task | None, int, Sequence[Reference]]]:
        """Yield what is read at this tick: producer, reader (None: the recorder), version and variables."""
        task: Callable[[str], Task] = self.schedule.task
        for reader in self.schedule.tasks:
            if reader.steps_at(tick):
                for link, version in self.renewed(reader, tick):
                    yield task(link.producer), reader, version, [(link.scalar, source) for source in link.sources]
        if tick % self.record_ticks == 0:
            for name, references in self.recorded.items():
                yield task(name), None, task(name).true_at(tick), references
