"""Turn the memory layout of a bundle into the operations of each tick, and those of the initialisation, as numbers.

Positions are those of values on the bus of their type. Nothing here knows an address: the bundle's binary reads the
program and binds it to the instances of the FMUs.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from lockstep.bundle.contents import CARRIED, Contents
from lockstep.fmi.slave import Scalar
from lockstep.plan.bus_layout import by_scalar
from lockstep.plan.schedule import Task
from lockstep.plan.wiring import Link
from lockstep.system.clock import seconds

Numbers = tuple[int, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Set:
    """Set values of one type: `targets` are references, ascending; each gets gain * bus[position] + bias.

    Without gains all values are unchanged.
    """

    scalar: Scalar
    targets: Numbers
    positions: Numbers
    gains: tuple[float, ...]
    biases: tuple[float, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Get:
    """Fetch values of one type to successive places on the bus, from `start` on; `used` are those that links read."""

    scalar: Scalar
    references: Numbers
    start: int
    used: tuple[bool, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class ComponentStep:
    """One step of a component, by its number: what to set before it, and to fetch after it."""

    component: int
    sets: tuple[Set, ...]
    gets: tuple[Get, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Tick:
    """Steps by their numbers, those before and those after the row is taken, and the number of the row; -1: none."""

    early: Numbers
    late: Numbers
    row: int


@dataclass(frozen=True, slots=True, kw_only=True)
class InitialSet:
    """Inputs that are set at initialization: `slots` are places among the initial values of `scalar`."""

    producer: int
    scalar: Scalar
    targets: Numbers
    slots: Numbers
    gains: tuple[float, ...]
    biases: tuple[float, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Initial:
    """What is set and fetched when a component is initialised."""

    sets: tuple[InitialSet, ...]
    gets: tuple[Get, ...]  # to the initial values; `start` is a slot
    bus: tuple[Get, ...]  # to the bus, for all versions up to the initial one


@dataclass(frozen=True, slots=True, kw_only=True)
class BundleProgram:
    """All operations. `order` are components as they are initialised; `initial` is by component, as the system's."""

    order: Numbers
    initial: tuple[Initial, ...]
    slots: Mapping[Scalar, int]
    bus: Mapping[Scalar, int]
    steps: tuple[ComponentStep, ...]
    rows: tuple[Mapping[Scalar, Numbers], ...]  # positions on the bus
    ticks: tuple[Tick, ...]  # of one cycle
    row_sizes: Mapping[Scalar, int]


def program(contents: Contents) -> BundleProgram:
    """Return the operations of a bundle."""
    return _Builder(contents).program()


class _Builder:
    """Number components as the system does, and share equal steps and rows."""

    def __init__(self, contents: Contents) -> None:
        self._layout, self._initial = contents.layout, contents.initial
        self._numbers = {component.name: k for k, component in enumerate(contents.system.components)}
        self._names = list(self._numbers)
        self._outputs = [port for port in contents.ports if port.kind == "output"]
        self._steps: dict[ComponentStep, int] = {}
        self._rows: dict[tuple[tuple[Scalar, Numbers], ...], int] = {}

    def program(self) -> BundleProgram:
        ordered = sorted(self._initial.tasks, key=lambda task: not task.continuous)
        slots = self._slots()
        ticks = tuple(map(self._tick, range(self._layout.cycle)))
        row = next(iter(self._rows), ())
        return BundleProgram(
            order=tuple(self._numbers[task.name] for task in ordered),
            initial=tuple(self._initial_of(name, slots) for name in self._names),
            slots={s: sum(1 for _, scalar, _ in slots if scalar == s) for s in CARRIED},
            bus={scalar: self._layout.bus_size(scalar) for scalar in CARRIED},
            steps=tuple(self._steps),
            rows=tuple(dict(parts) for parts in self._rows),
            ticks=ticks,
            row_sizes={scalar: len(positions) for scalar, positions in row},
        )

    def _tick(self, tick: int) -> Tick:
        due = [task for task in self._layout.schedule.tasks if task.steps_at(tick)]
        early = [self._step(task, tick) for task in due if not (task.continuous or task.after_row)]
        late = [self._step(task, tick) for task in due if task.continuous or task.after_row]
        row = self._row(tick) if tick % self._layout.record_ticks == 0 else -1
        return Tick(early=tuple(early), late=tuple(late), row=row)

    def _step(self, task: Task, tick: int) -> int:
        gets = []
        for scalar in CARRIED:
            start, references = self._layout.fetched(task.name, scalar, task.begun(tick))
            gets += [self._get(task.name, scalar, references, start)] if references else []
        step = ComponentStep(component=self._numbers[task.name], sets=self._sets(task, tick), gets=tuple(gets))
        return self._steps.setdefault(step, len(self._steps))

    def _get(self, name: str, scalar: Scalar, references: list[int], start: int) -> Get:
        used = self._layout.used[name]
        marks = tuple((scalar, reference) in used for reference in references)
        return Get(scalar=scalar, references=tuple(references), start=start, used=marks)

    def _sets(self, task: Task, tick: int) -> tuple[Set, ...]:
        entries: dict[Scalar, list[tuple[int, int, float, float]]] = {}
        for link, version in self._layout.renewed(task, tick):
            positions = self._layout.positions(link.producer, link.scalar, link.sources, version)
            rows = zip(link.targets, positions, link.gains, link.biases, strict=True)
            entries.setdefault(link.scalar, []).extend(rows)
        found = []
        for scalar in CARRIED:
            if scalar in entries:
                targets, places, gains, biases = zip(*sorted(entries[scalar]), strict=True)
                factors = _factors(gains, biases)
                found.append(Set(scalar=scalar, targets=targets, positions=places, gains=factors[0], biases=factors[1]))
        return tuple(found)

    def _row(self, tick: int) -> int:
        """Return the number of a row: where the values of the outputs lie, by type in the order of the ports."""
        task = self._layout.schedule.task
        parts = []
        for scalar in CARRIED:
            ports = [port for port in self._outputs if port.variable.scalar == scalar]
            places = (
                self._layout.position(
                    p.ends[0].component, scalar, p.variable.reference, task(p.ends[0].component).true_at(tick)
                )
                for p in ports
            )
            parts.append((scalar, tuple(places)))
        return self._rows.setdefault(tuple(parts), len(self._rows))

    def _slots(self) -> dict[tuple[str, Scalar, int], int]:
        """Return the place of each transferred output among the initial values of its type."""
        slots: dict[tuple[str, Scalar, int], int] = {}
        for scalar in CARRIED:
            place = 0
            for name in self._names:
                for reference in sorted(by_scalar(self._layout.transferred[name]).get(scalar, [])):
                    slots[name, scalar, reference] = place
                    place += 1
        return slots

    def _initial_of(self, name: str, slots: Mapping[tuple[str, Scalar, int], int]) -> Initial:
        gets, bus = [], []
        for scalar in CARRIED:
            mine = [(slot, key[2]) for key, slot in slots.items() if key[:2] == (name, scalar)]
            if mine:
                mine.sort()
                gets.append(self._get(name, scalar, [reference for _, reference in mine], mine[0][0]))
            places = {}
            for version in range(1 - self._layout.rings[name], 1):
                start, references = self._layout.fetched(name, scalar, version)
                if references:
                    places[start] = references
            bus += [self._get(name, scalar, references, start) for start, references in places.items()]
        sets = tuple(self._initial_set(link, slots) for link in self._layout.feeding[name])
        return Initial(sets=sets, gets=tuple(gets), bus=tuple(bus))

    def _initial_set(self, link: Link, slots: Mapping[tuple[str, Scalar, int], int]) -> InitialSet:
        gains, biases = _factors(link.gains, link.biases)
        return InitialSet(
            producer=self._numbers[link.producer],
            scalar=link.scalar,
            targets=link.targets,
            slots=tuple(slots[link.producer, link.scalar, source] for source in link.sources),
            gains=gains,
            biases=biases,
        )


def _factors(gains: tuple[float, ...], biases: tuple[float, ...]) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Return gains and biases, or none if all values are unchanged: 1 * -0.0 + 0 is another number than -0.0."""
    changed = any(gain != 1.0 or bias != 0.0 for gain, bias in zip(gains, biases, strict=True))
    return (gains, biases) if changed else ((), ())


def step_length(contents: Contents, task: Task) -> float:
    """Return the length of a component's steps [s]."""
    return seconds(task.period * contents.layout.schedule.tick)
