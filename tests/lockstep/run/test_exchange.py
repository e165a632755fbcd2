"""Inputs of every slave and values of every row, against a simulator written from the definitions.

The reference keeps the whole history of every component, and looks up each value by the rule of
`lockstep.plan.schedule`: the newest step produced by the end of tick k - n. It has no plan, no rings and no cycle.
"""

import random
from pathlib import Path

import numpy as np
import pytest

from lockstep import Component, Connection, RunError, System
from lockstep.fmi.slave import returned
from lockstep.plan.bus_layout import Layout
from lockstep.plan.schedule import build_schedule
from lockstep.plan.wiring import Link
from lockstep.run.exchange import Exchange
from lockstep.run.final_row import record_stop
from lockstep.tick.bound_operations import actions

MS = 1_000_000
WIDTH = 3  # outputs of a toy


class Toy:
    """Output numbers that identify component, output and step; keep the inputs received."""

    def __init__(self, number, inputs):
        self.number, self.steps = number, 0
        self.inputs = dict.fromkeys(range(inputs), np.nan)
        self.received, self.sets, self.gets, self.status = [], 0, 0, 0
        self.poison = None

    def output(self, reference, step):
        return 1e6 * self.number + 1e3 * reference + step

    def do_step(self, time, _step, _no_set_state):
        self.received.append((round(time * 1e3), dict(self.inputs)))
        self.steps += 1
        return self.status

    def getter(self, _scalar, references, buffer):
        assert list(references) == sorted(references)

        def get():
            self.gets += len(references)
            buffer[:] = [self.output(reference, self.steps) for reference in references]
            if self.poison == self.steps:
                buffer[-1] = np.inf
            return 0

        return get

    def setter(self, _scalar, references, buffer):
        assert list(references) == sorted(references)

        def put():
            self.sets += len(references)
            self.inputs.update(zip(references.tolist(), buffer.tolist(), strict=True))
            return 0

        return put

    def failed(self, status):
        self.noted = status

    def outcome(self, call, status):
        return returned("fmi2", call, status)

    def last_messages(self):
        return "the last message of the toy"


def simulate_toys(periods, offsets, continuous, wires, record_ticks, ticks, poison=None, stops=False):
    """Run toys through Layout and Exchange. `wires` are (producer, output, consumer, input, delay).

    With `stops` the row at the stop time is recorded too.
    """
    names = [f"c{number}" for number in range(len(periods))]
    system = System(
        name="toys",
        tick=MS,
        components=tuple(
            Component(
                name=name,
                source=Path("none.fmu"),
                period=periods[i] * MS,
                offset=offsets[i] * MS,
                kind="continuous" if continuous[i] else "sampled",
            )
            for i, name in enumerate(names)
        ),
        connections=tuple(
            Connection(from_component=names[p], output=str(o), to_component=names[c], input=str(i), delay=d)
            for p, o, c, i, d in wires
        ),
    )
    links = tuple(
        Link(
            producer=names[p],
            consumer=names[c],
            delay=d,
            scalar="Real",
            sources=(o,),
            targets=(i,),
            gains=(1.0,),
            biases=(0.0,),
        )
        for p, o, c, i, d in wires
    )
    recorded = {name: tuple(("Real", reference) for reference in range(WIDTH)) for name in names}
    layout = Layout(schedule=build_schedule(system), links=links, recorded=recorded, record_ticks=record_ticks)
    toys = {name: Toy(i, sum(wire[2] == i for wire in wires)) for i, name in enumerate(names)}
    if poison:
        toys[names[poison[0]]].poison = poison[1]
    labels = {(name, "Real", reference): f"y[{reference}]" for name in names for reference in range(WIDTH)}
    exchange = Exchange(layout, toys, labels)
    for name in names:
        exchange.fetch_initial(name)
    for name in names:
        exchange.set_initial(name)
    rows = []

    def row(time):
        buffer = np.full(WIDTH * len(names), np.nan)
        rows.append((round(time * 1e3), buffer))
        return buffer, np.zeros(0), np.zeros(0)

    for toy in toys.values():
        toy.gets = toy.sets = 0
    phases = actions(exchange.program(row))
    for tick in range(ticks):
        for step in phases[tick % len(phases)]:
            step(tick * MS / 1e9)
    if stops:
        record_stop(exchange, ticks, ticks * MS / 1e9, row)
    return toys, rows, layout


def steps_produced(period, offset, continuous, by_tick):
    """Count the steps whose outputs exist at the end of a tick, one by one."""
    begins = range(offset, max(by_tick, 0) + 1, period)
    return sum(begin + (period - 1 if continuous else 0) <= by_tick for begin in begins)


def random_case(seed):
    rng = random.Random(seed)
    count = rng.randint(1, 4)
    periods = [rng.choice([1, 1, 2, 3, 5]) for _ in range(count)]
    offsets = [rng.randrange(period) for period in periods]
    continuous = [rng.random() < 0.4 for _ in range(count)]
    wires, inputs = [], [0] * count
    for _ in range(rng.randint(0, 8)):
        producer, consumer = rng.randrange(count), rng.randrange(count)
        # same-tick wires lead to a later component of the file only, so that there is no cycle
        lowest = 0 if producer < consumer and not continuous[producer] else 1
        wires.append((producer, rng.randrange(WIDTH), consumer, inputs[consumer], rng.randint(lowest, 7)))
        inputs[consumer] += 1
    return periods, offsets, continuous, wires, rng.choice([1, 2, 5])


@pytest.mark.parametrize("seed", range(150))
def test_every_input_and_every_row_follow_the_definition(seed):
    periods, offsets, continuous, wires, record_ticks = random_case(seed)
    ticks = 130  # more than two of most cycles
    toys, rows, _ = simulate_toys(periods, offsets, continuous, wires, record_ticks, ticks, stops=True)
    for number, toy in enumerate(toys.values()):
        last = ticks if continuous[number] else ticks + 1  # a sample at the stop time takes no time
        assert [tick for tick, _ in toy.received] == list(range(offsets[number], last, periods[number]))
        for tick, inputs in toy.received:
            for producer, output, consumer, target, delay in wires:
                if consumer == number:
                    step = steps_produced(periods[producer], offsets[producer], continuous[producer], tick - delay)
                    assert inputs[target] == toys[f"c{producer}"].output(output, step), (seed, tick)
    assert [tick for tick, _ in rows] == list(range(0, ticks + 1, record_ticks))
    for tick, values in rows:
        for number, toy in enumerate(toys.values()):
            true_at = tick - 1 if continuous[number] else tick
            step = steps_produced(periods[number], offsets[number], continuous[number], true_at)
            expected = [toy.output(reference, step) for reference in range(WIDTH)]
            assert values[number * WIDTH : (number + 1) * WIDTH].tolist() == expected, (seed, tick)


def test_only_outputs_that_are_read_are_fetched_and_only_new_values_are_set():
    # a 1-tick producer with one output for a 1-tick reader and two for a 5-tick reader, recorded every 5 ticks
    wires = [(0, 0, 1, 0, 0), (0, 1, 2, 0, 0), (0, 2, 2, 1, 0), (2, 0, 1, 1, 0)]
    toys, _, layout = simulate_toys([1, 1, 5], [0, 0, 0], [False] * 3, wires, 5, 100)
    assert layout.cycle == 5
    assert toys["c0"].gets == 20 * (3 + 4 * 1)  # everything each fifth tick, one output at the others
    assert toys["c2"].gets == 20 * 3
    assert toys["c1"].gets == 20 * 3  # for the record only
    assert toys["c2"].sets == 20 * 2
    assert toys["c1"].sets == 100 + 20  # the slow producer's value is set when it is new


def test_a_value_that_is_not_finite_is_refused_with_name_and_time():
    with pytest.raises(RunError, match=r"^c0\.y\[2\]: is inf at 0\.003 s"):
        simulate_toys([1, 1], [0, 0], [False, False], [(0, 2, 1, 0, 0)], 1, 10, poison=(0, 4))


def test_a_continuous_value_is_reported_at_the_time_at_which_it_would_be_true():
    with pytest.raises(RunError, match=r"^c0\.y\[2\]: is inf at 0\.004 s"):
        simulate_toys([1, 1], [0, 0], [True, False], [(0, 2, 1, 0, 1)], 1, 10, poison=(0, 4))


@pytest.mark.parametrize(("gain", "message"), [
    (1e303, r"^c1\.u: is inf at 0\.179 s after the conversion of its connection; every exchanged value must be"),
    (1e306, r"^c1\.u: is inf at 0 s after the conversion of its connection"),
])  # fmt: skip
def test_a_value_that_overflows_in_its_conversion_is_refused_with_the_input_and_the_time(gain, message):
    """The toy c0 counts in thousands: 179,000 times 1e303 is a double, and 180,000 times it is not."""
    producer, consumer = Toy(0, 0), Toy(1, 1)
    producer.output = lambda _reference, step: 1e3 * (step + (gain == 1e306))
    names = ["c0", "c1"]
    components = tuple(Component(name=name, source=Path("none.fmu"), period=MS, kind="sampled") for name in names)
    link = Link(producer="c0", consumer="c1", delay=0, scalar="Real", sources=(0,), targets=(0,), gains=(gain,),
                biases=(0.0,))  # fmt: skip
    wire = Connection(from_component="c0", output="y", to_component="c1", input="u")
    system = System(name="toys", tick=MS, components=components, connections=(wire,))
    layout = Layout(schedule=build_schedule(system), links=(link,), recorded={}, record_ticks=1)
    labels = {("c0", "Real", 0): "y", ("c1", "Real", 0): "u"}
    exchange = Exchange(layout, dict(zip(names, (producer, consumer), strict=True)), labels)

    def run():
        exchange.fetch_initial("c0")
        exchange.set_initial("c1")
        phases = actions(exchange.program(lambda _: ()))
        for tick in range(1000):
            for step in phases[tick % len(phases)]:
                step(tick / 1e3)

    with pytest.raises(RunError, match=message), np.errstate(over="ignore"):
        run()
    assert np.isfinite([value for _, inputs in consumer.received for value in inputs.values()]).all()


def test_a_failed_call_is_reported_with_the_log_of_the_slave():
    toys, _, layout = simulate_toys([1], [0], [False], [], 1, 2)
    toy = toys["c0"]
    with pytest.raises(RunError, match=r"c0: fmi2DoStep returned fmi2Error at 0\.25 s: the last message of the toy"):
        Exchange(layout, toys, {}).check("c0", "DoStep", 0.25, 3)
    assert toy.noted == 3
    Exchange(layout, toys, {}).check("c0", "DoStep", 0.25, 1)  # a warning goes on
