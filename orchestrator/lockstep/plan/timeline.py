"""List the schedule of a system tick by tick: steps, and the values that they read, from the system file alone."""

from collections import Counter
from dataclasses import dataclass

from lockstep.array_names import array_of
from lockstep.plan.schedule import Task, build_schedule
from lockstep.system.clock import Time, seconds_text
from lockstep.system.system import System


@dataclass(frozen=True, slots=True, kw_only=True)
class Read:
    """Values that one step takes from one producer.

    Attributes
    ----------
    producer : component
    count : how many values
    delay : latency contract of the connection [ticks]
    since : time from which they hold (sampled producer), or at which they are true (continuous one) [ns]
    initial : the producer's initial outputs: none of its steps was done in time
    """

    producer: str
    count: int
    delay: int
    since: Time
    initial: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class TimelineStep:
    """One doStep: its tick, the time it starts and ends [ns], and what it reads before."""

    tick: int
    component: str
    start: Time
    end: Time
    continuous: bool
    reads: tuple[Read, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Route:
    """The ports of one component that another reads through connections of one delay.

    Attributes
    ----------
    producer, consumer : components
    delay : latency contract [ticks]
    ports : in the order of the file, arrays folded: `wheel.torque[6]`, or `speed[6] -> omega[6]` where names differ
    """

    producer: str
    consumer: str
    delay: int
    ports: tuple[str, ...]

    def __str__(self) -> str:
        contract = "same tick" if self.delay == 0 else f"delay {self.delay} tick{'s' * (self.delay > 1)}"
        return f"{self.producer} -> {self.consumer} ({contract}): {', '.join(self.ports)}"


def routes(system: System) -> list[Route]:
    """Return the routes between the components of a system."""
    found: dict[tuple[str, str, int], dict[tuple[str, str], tuple[set[str], set[str]]]] = {}
    for c in system.connections:
        arrays = array_of(c.output), array_of(c.input)
        ports = found.setdefault((c.from_component, c.to_component, c.delay), {})
        outputs, inputs = ports.setdefault(arrays, (set(), set()))
        outputs.add(c.output)
        inputs.add(c.input)
    return [
        Route(
            producer=producer,
            consumer=consumer,
            delay=delay,
            ports=tuple(_port(arrays, *map(len, ends)) for arrays, ends in ports.items()),
        )
        for (producer, consumer, delay), ports in found.items()
    ]


def _port(arrays: tuple[str, str], outputs: int, inputs: int) -> str:
    output, entry = (
        f"{name}[{count}]" if count > 1 else name for name, count in zip(arrays, (outputs, inputs), strict=True)
    )
    return output if output == entry else f"{output} -> {entry}"


def timeline(system: System, ticks: int) -> list[TimelineStep]:
    """Return every step of the first `ticks` ticks in the order of the master.

    Raises
    ------
    InputError
        If the system cannot be scheduled.
    """
    schedule = build_schedule(system)
    counts = Counter((c.from_component, c.to_component, c.delay) for c in system.connections)
    steps = []
    for tick in range(ticks):
        for task in schedule.tasks:
            if tick >= task.offset and task.steps_at(tick):
                reads = tuple(
                    _read(schedule.task(producer), tick, delay, count, schedule.tick)
                    for (producer, consumer, delay), count in counts.items()
                    if consumer == task.name
                )
                start = tick * schedule.tick
                steps.append(
                    TimelineStep(
                        tick=tick,
                        component=task.name,
                        start=start,
                        end=start + task.period * schedule.tick,
                        continuous=task.continuous,
                        reads=reads,
                    )
                )
    return steps


def _read(producer: Task, tick: int, delay: int, count: int, length: Time) -> Read:
    version = producer.seen(tick, delay)
    begun = producer.offset + (version - 1) * producer.period  # the tick at which that version's step began
    since = begun + producer.period if producer.continuous else begun
    return Read(producer=producer.name, count=count, delay=delay, since=max(0, since) * length, initial=version < 1)


def timeline_lines(system: System, ticks: int) -> list[str]:
    """Return the timeline as text: a line for each step with the values that it reads; then the routes."""
    lines = [f"{system.name}: the first {ticks} ticks of {seconds_text(system.tick)} s, in the order of the master"]
    width = max(len(component.name) for component in system.components)
    steps = timeline(system, ticks)
    for number, step in enumerate(steps):
        first = number == 0 or steps[number - 1].tick != step.tick
        time = f"t = {seconds_text(step.start)} s" if first else ""
        kind = "true at" if step.continuous else "hold from"
        when = step.end if step.continuous else step.start
        reads = "; ".join(_read_text(read) for read in step.reads) or "nothing"
        lines.append(
            f"  {time:14}{step.component:{width}}  reads {reads}; outputs {kind} {seconds_text(when)} s".rstrip()
        )
    between = routes(system)
    return [*lines, "connections:" * bool(between), *(f"  {route}" for route in between)]


def _read_text(read: Read) -> str:
    contract = "same tick" if read.delay == 0 else f"delay {read.delay}"
    age = "initial" if read.initial else f"of {seconds_text(read.since)} s"
    return f"{read.count} from {read.producer} {age} ({contract})"
