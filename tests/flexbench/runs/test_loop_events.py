"""Events of a loop have the right times: closed forms of torque, wheel speed and attitude; blocks do not matter."""

import numpy as np
import pytest

from flexbench.runs.loop_events import FASTEST, GROWN, GROWTH, LARGEST, LOST, SLICE, LoopEvents, Rows
from flexbench.runs.loop_monitor import KINDS
from flexsat.parameters import RPM

PERIOD = 0.005  # s
LIMIT, BAND, INERTIA = 4.4, 25.0 * RPM, 4.62  # N.m, rad/s, kg.m2
WHEELS = 3


def found(duration, blocks=1, guidance=None, seed=0, **signals):
    """Return the events of rows of a duration, given in so many blocks of random lengths, as (time, event, details)."""
    time = PERIOD * np.arange(round(duration / PERIOD) + 1)
    monitor = LoopEvents(torque_limit=LIMIT, speed_band=BAND, details={"component": "plant"})
    made = {name: signal(time) for name, signal in signals.items()}
    if guidance is not None:
        made["guidance"] = guidance(time)
    cuts = np.sort(np.random.default_rng(seed).integers(0, len(time), blocks - 1))
    events = []
    for part in np.split(np.arange(len(time)), cuts):
        rows = Rows(time=time[part], **{name: values[part] for name, values in made.items()})
        events += list(monitor.rows(rows))
    events += list(monitor.end())
    return [(one.time, one.event, dict(one.details)) for one in events], monitor.summary()


def on_wheel(number, values):
    """Return a history of all wheels that is zero but for one wheel's."""
    return np.stack([values if k == number else np.zeros_like(values) for k in range(WHEELS)], axis=1)


def test_a_torque_at_its_limit_is_one_episode_from_its_first_sample_to_the_first_below():
    def torque(time):
        return on_wheel(1, np.where((time >= 2.0) & (time < 3.5), -LIMIT, 0.5 * LIMIT))

    events, summary = found(10.0, torque=torque)

    assert [(t, name, d["state"]) for t, name, d in events] == [
        (2.0, "torque-saturation", "begin"),
        (3.5, "torque-saturation", "end"),
    ]
    assert events[0][2] == {"state": "begin", "component": "plant", "limit": LIMIT, "wheels": [2]}
    assert events[1][2]["since"] == 2.0
    assert summary == [{"event": "torque-saturation", "count": 1, "first": 2.0, "seconds": 1.5}]


def test_what_stops_for_less_than_a_second_is_one_episode_and_what_does_not_end_has_no_end():
    def torque(time):
        first = on_wheel(0, np.where((time >= 1.0) & (time < 2.0), LIMIT, 0.0))
        second = on_wheel(2, np.where((time >= 2.9) & (time < 3.0), LIMIT, 0.0))
        return first + second + on_wheel(1, np.where(time >= 6.0, 2.0 * LIMIT, 0.0))  # a vendor's command, not limited

    events, (summary,) = found(8.0, torque=torque)

    assert [(t, d["state"]) for t, _, d in events] == [(1.0, "begin"), (3.0, "end"), (6.0, "begin")]
    assert events[1][2]["wheels"] == [1, 3]
    assert summary == {"event": "torque-saturation", "count": 2, "first": 1.0, "seconds": 4.0, "until_the_end": True}


def test_each_wheel_has_its_own_limits():
    """The first wheel is not used, the second weak, the third strong and held to a narrow band."""
    limits, bands = np.array([0.0, 0.5 * LIMIT, LIMIT]), np.array([BAND, BAND, 0.1 * BAND])
    monitor = LoopEvents(torque_limit=limits, speed_band=bands, details={})
    time = PERIOD * np.arange(1001)
    torque = np.tile([0.0, -0.5 * LIMIT, 0.5 * LIMIT], (len(time), 1)) * (time > 2.0)[:, np.newaxis]
    speed = np.tile([0.5 * BAND, 0.5 * BAND, 0.2 * BAND], (len(time), 1)) * (time > 3.0)[:, np.newaxis]
    begun = [
        (one.time, one.event, dict(one.details)) for one in monitor.rows(Rows(time=time, torque=torque, speed=speed))
    ]
    assert [(name, details["wheels"]) for _, name, details in begun] == [
        ("torque-saturation", [2]),
        ("speed-band-left", [3]),
    ]
    assert begun[0][2]["limit"] == limits.tolist()
    assert begun[1][2]["band"] == bands.tolist()


def test_a_wheel_under_constant_torque_leaves_its_band_at_the_computed_time():
    """Speed grows by torque/inertia: it crosses the edge between two rows, and comes back as it went."""
    torque = 1.234
    leaves = BAND * INERTIA / torque

    def speed(time):
        turned = torque / INERTIA * np.where(time < 15.0, time, 30.0 - time)
        return on_wheel(2, -turned)

    events, summary = found(30.0, speed=speed)

    assert [name for _, name, _ in events] == ["speed-band-left"] * 2
    assert [t for t, _, _ in events] == pytest.approx([leaves, 30.0 - leaves], abs=1e-9)
    assert events[0][2] == {"state": "begin", "component": "plant", "band": BAND, "wheels": [3]}
    assert summary[0]["seconds"] == pytest.approx(30.0 - 2.0 * leaves, abs=1e-6)


def growing(rate, start, hertz):
    """Return a torque that oscillates with an amplitude that grows by `rate` [1/s] up to the limit."""
    return lambda time: on_wheel(
        1, np.clip(start * LIMIT * np.exp(rate * time) * np.sin(2.0 * np.pi * hertz * time), -LIMIT, LIMIT)
    )


def test_a_growing_oscillation_is_a_limit_cycle_from_the_second_in_which_it_is_large_enough():
    rate, start, hertz = 0.7, 1e-3, 8.0  # two whole periods in a slice
    events, (_, summary) = found(12.0, torque=growing(rate, start, hertz))
    cycle = [(t, d) for t, name, d in events if name == "limit-cycle"]
    ends = SLICE * np.arange(4, 48)  # of seconds
    # RMS in the last slice of each second, from the integral of the envelope squared
    power = (np.exp(2 * rate * ends) - np.exp(2 * rate * (ends - SLICE))) / (2 * rate * SLICE)
    level = start * np.sqrt(0.5 * power)
    expected = float(ends[np.argmax(level >= GROWN)]) - 1.0

    assert np.exp(0.75 * rate) > GROWTH
    assert cycle[0][0] == pytest.approx(expected, abs=1e-9)
    assert cycle[0][1]["wheels"] == [2]
    assert cycle[0][1]["frequency"] == pytest.approx(hertz, abs=0.5)
    assert len(cycle) == 1  # until the end
    assert summary["until_the_end"] is True
    assert LIMIT * 2.0 / np.pi < summary["torque"] < LIMIT  # more than a sine at the limit: its peaks are cut off


def test_an_oscillation_that_does_not_grow_is_one_from_its_first_second_if_it_is_large():
    def torque(time, amplitude):
        return on_wheel(0, np.where((time >= 3.0) & (time < 6.0), amplitude * np.sin(2.0 * np.pi * 7.0 * time), 0.0))

    large, summary = found(10.0, torque=lambda time: torque(time, 0.4 * LIMIT))
    small, _ = found(10.0, torque=lambda time: torque(time, 0.06 * LIMIT))

    assert [(t, name, d["state"]) for t, name, d in large] == [
        (3.0, "limit-cycle", "begin"),
        (6.0, "limit-cycle", "end"),
    ]
    assert summary[0]["torque"] == pytest.approx(0.4 * LIMIT * 2.0 / np.pi, rel=0.02)  # mean of |sine|
    assert small == []


def test_pulses_of_a_slew_and_noise_are_no_limit_cycle():
    rng = np.random.default_rng(5)

    def pulses(time):  # 0.8 of the limit for 1 s each, up, down, up: three slews of 0.01 deg in a row
        return 0.8 * LIMIT * sum(np.where((time >= a) & (time < a + 1.0), s, 0.0) for a, s in ((2, 1), (3, -1), (4, 1)))

    def torque(time):
        return on_wheel(0, pulses(time)) + 0.03 * LIMIT * rng.standard_normal((len(time), WHEELS))

    assert found(30.0, torque=torque) == ([], [])


def test_an_oscillation_is_one_whatever_the_guidance_commands():
    def pulse(time):
        return on_wheel(0, np.where((time >= 2.0) & (time < 5.0), 0.8 * LIMIT, 0.0))

    events, _ = found(8.0, torque=lambda t: pulse(t) + on_wheel(0, 0.3 * LIMIT * np.sin(40.0 * t)), guidance=pulse)

    assert (events[-1][1], events[-1][2]["state"]) != ("limit-cycle", "end")
    assert min(t for t, name, _ in events if name == "limit-cycle") == 0.0


def test_motion_beyond_what_the_plant_models_is_divergence_at_once():
    def rate(time):
        return np.stack([0.0 * time, -0.05 * time, 0.0 * time], axis=1)

    events, summary = found(6.0, rate=rate, deformation=lambda time: 0.01 * time)

    assert [(t, name, d["quantity"]) for t, name, d in events] == [
        (pytest.approx(FASTEST / 0.05 + PERIOD), "divergence", "rate"),
        (pytest.approx(LARGEST / 0.01 + PERIOD), "divergence", "deformation"),
    ]
    assert [one["quantity"] for one in summary] == ["rate", "deformation"]


def test_a_pointing_error_that_grows_for_five_seconds_is_divergence_until_it_has_halved():
    """Error 1e-5 t^3 rad up to 10 s, then falling: the RMS of a second exceeds 0.1 deg in the sixth, for example."""

    def error(time):
        return np.where(time < 10.0, 1e-5 * time**3, 1e-2 * np.exp(-(time - 10.0) / 2.0))

    events, _ = found(20.0, error=error)
    seconds = np.arange(5, 12)
    rms = 1e-5 * np.sqrt(((seconds + 1.0) ** 7 - seconds**7.0) / 7.0)  # of t^3 over each second
    lost = int(seconds[np.argmax(rms > LOST)])

    peak = rms[seconds == 9][0]  # then it falls by exp(-1/2) a second
    falling = 1e-2 * np.sqrt(1.0 - np.exp(-1.0)) * np.exp(-0.5 * np.arange(9))
    halved = 10 + int(np.argmax(falling < 0.5 * peak))

    assert [(t, d["state"]) for t, _, d in events] == [(lost + 1.0 - 5.0, "begin"), (halved, "end")]
    assert events[0][2]["value"] == pytest.approx(rms[seconds == lost][0], rel=1e-2)


def test_an_error_that_settles_is_no_divergence():
    assert found(60.0, error=lambda t: 0.02 * np.exp(-t / 10.0) * np.abs(np.cos(0.5 * t))) == ([], [])


@pytest.mark.parametrize("blocks", [2, 7, 60])
def test_events_do_not_depend_on_how_rows_are_divided(blocks):
    rng = np.random.default_rng(11)

    def torque(time):
        own = np.random.default_rng(3).standard_normal((len(time), WHEELS))
        bursts = LIMIT * own * (np.sin(0.4 * time) > 0.9)[:, np.newaxis]
        return np.clip(growing(0.7, 1e-3, 8.0)(time) + bursts, -LIMIT, LIMIT)

    def speed(time):
        return 1.2 * BAND * np.sin(np.outer(time, [0.3, 1.1, 2.0]))

    def error(time):
        return np.where(time < 10.0, 1e-5 * time**3, 1e-2 * np.exp(-(time - 10.0) / 2.0))

    signals = {"torque": torque, "speed": speed, "error": error}
    whole, summary = found(20.0, **signals)
    parts, same = found(20.0, blocks=blocks, seed=int(rng.integers(99)), **signals)

    assert {name for _, name, _ in whole} == set(KINDS)
    for kind in {name for _, name, _ in whole}:
        assert [one for one in parts if one[1] == kind] == [one for one in whole if one[1] == kind]
    assert same == summary
