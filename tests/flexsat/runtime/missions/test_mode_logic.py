"""The state machine of modes, and the timeline."""

from typing import Any

import pytest

from flexsat.ports import mission as interface
from flexsat.runtime.missions import mode_logic
from flexsat.runtime.missions.mode_logic import ACQUISITION, FINE, MODES, OFF_LOAD, SAFE, SETTLE, SLEW, Seen
from fmus.mission_numbers import MISSION_DATA, values_of

STEP = 0.1  # s


def seen(**changes: Any) -> Seen:
    given = {"star_tracker_valid": True, "error": 1e-7, "moving": False, "speed_share": 0.0, "off_loaded": False,
             "lost_axis": False}  # fmt: skip
    return Seen(**(given | changes))


class Machine:
    """A state machine, and the modes that it has been in with their first times."""

    def __init__(self, commands: list[tuple[float, int]] = (), **given: Any) -> None:
        rest = 48 - len(commands)
        values = {
            "timeline__time": (*(time for time, _ in commands), *[0.0] * rest),
            "timeline__action": (*(action for _, action in commands), *[0] * rest),
            "timeline__rotation": (0.1, 0.0, 0.0) * 48,
            "settle__dwell": 1.0,
        }
        ports = interface.ports(MISSION_DATA)
        self.prepared = interface.parameters(values_of(ports, values | given), STEP).modes
        self.state = mode_logic.init(self.prepared)
        self.count, self.history, self.began = 0, [(0.0, self.state.mode)], []

    def run(self, until: float, **changes: Any) -> list[tuple[float, int]]:
        while self.count * STEP < until - 1e-9:
            time = self.count * STEP
            if mode_logic.step(self.prepared, self.state, time, seen(**changes)):
                self.began.append(round(time, 6))
            if self.state.mode != self.history[-1][1]:
                self.history.append((round(time, 6), self.state.mode))
            self.count += 1
        return self.history


def test_from_the_first_sample_to_fine():
    machine = Machine()
    machine.run(2.0, star_tracker_valid=False)
    history = machine.run(5.0)

    assert history == [(0.0, ACQUISITION), (2.0, SETTLE), (3.0, FINE)]
    assert len(MODES) == 6


def test_a_slew_lasts_while_the_reference_moves_and_the_next_command_waits():
    machine = Machine([(5.0, 1), (6.0, 2)])
    machine.run(10.0)
    assert machine.state.start == pytest.approx(10.0)  # 5 s after the command
    assert machine.state.rotation.tolist() == [0.1, 0.0, 0.0]
    machine.run(20.0, moving=True)
    history = machine.run(24.0)

    # the off-loading of 6 s begins when the slew has settled: the dwell in that mode, and a step
    assert history[3:] == [(5.0, SLEW), (20.0, SETTLE), (21.0, FINE), (22.1, OFF_LOAD)]
    assert machine.began == [22.1]
    assert machine.run(26.0, off_loaded=True)[-2:] == [(24.0, SETTLE), (25.0, FINE)]


def test_a_slew_that_does_not_begin_is_given_up():
    machine = Machine([(5.0, 1)])

    assert machine.run(40.0)[3:] == [(5.0, SLEW), (30.1, SETTLE), (31.1, FINE)]


def test_safe_waits_for_nothing_and_skips_commands_until_it_is_resumed():
    machine = Machine([(5.0, 1), (7.0, 3), (8.0, 2), (12.0, 4)])
    machine.run(6.0)
    machine.run(7.5, moving=True)
    assert machine.state.mode == SAFE
    assert machine.state.rotation.tolist() == [0.0, 0.0, 0.0]
    history = machine.run(15.0)

    assert history[4:] == [(7.0, SAFE), (12.0, ACQUISITION), (12.1, SETTLE), (13.1, FINE)]
    assert machine.began == []
    assert machine.state.next == 4


def test_a_long_outage_and_a_lost_axis_end_in_safe():
    machine = Machine(star_tracker__outage_time=1.0, safe__outage_time=5.0)
    machine.run(4.0)
    assert machine.run(20.0, star_tracker_valid=False)[3:] == [(5.0, ACQUISITION), (10.1, SAFE)]

    machine = Machine()
    machine.run(4.0)
    assert machine.run(5.0, lost_axis=True)[-1] == (4.0, SAFE)


def test_a_pointing_error_beyond_three_bands_ends_fine():
    machine = Machine(settle__band=1e-5)
    machine.run(4.0)
    machine.run(5.0, error=2.9e-5)
    assert machine.state.mode == FINE
    assert machine.run(6.0, error=3.1e-5)[-1] == (5.0, SETTLE)


def test_wheels_beyond_their_share_are_off_loaded_without_a_command():
    machine = Machine(off_loading__automatic=0.5)
    machine.run(4.0, speed_share=0.49)
    assert machine.run(5.0, speed_share=0.51)[-1] == (4.0, OFF_LOAD)
    assert machine.began == [4.0]
