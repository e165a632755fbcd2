"""A mission file: what it sets, and one line for what is wrong with it."""

import math
from dataclasses import replace
from pathlib import Path

import pytest

from flexbench.loop.mission_file import mission_values
from lockstep import Component, System
from lockstep.errors import InputError

EXAMPLES = Path(__file__).parents[3] / "examples" / "missions"
SLEW = '[[command]]\nat = 1.0\ndo = "slew"\nrotation = [1.0, 0.0, 0.0]\n'


@pytest.fixture
def system(tmp_path: Path) -> System:
    """Return a system with a component of the manager's name."""
    return System(
        name="with-a-manager",
        tick=1_000_000,
        components=(Component(name="mission", source=tmp_path / "mission.fmu", period=1_000_000),),
        connections=(),
        stop_time=1_000_000,
        record=(),
        record_period=1_000_000,
    )


def test_commands_and_parameters_become_values(system: System, tmp_path: Path):
    path = tmp_path / "mission.toml"
    path.write_text(
        SLEW + 'unit = "deg"\n[[command]]\nat = 5\ndo = "off-load"\n[set]\n"a.b" = [1.0, true]\n"c.d" = 3\n'
    )

    assert mission_values(system, path) == {
        "mission.timeline.time[1]": 1.0,
        "mission.timeline.action[1]": 1,
        "mission.timeline.rotation[1]": math.radians(1.0),
        "mission.timeline.rotation[2]": 0.0,
        "mission.timeline.rotation[3]": 0.0,
        "mission.timeline.time[2]": 5.0,
        "mission.timeline.action[2]": 2,
        "a.b[1]": 1.0,
        "a.b[2]": True,
        "c.d": 3,
    }


WRONG = {
    '[[comand]]\nat = 1\n': "mission.toml:1: comand: no such table; a mission has [[command]] and [set]",
    'command = 3\n': "mission.toml:1: command: write [[command]] before each",
    SLEW + '[[command]]\nat = 2.0\ndo = "offload"\n':
        "mission.toml:7: do = 'offload' must be one of slew, off-load, safe, resume",
    SLEW + '[[command]]\nat = 0.5\ndo = "safe"\n':
        "mission.toml:6: at = 0.5 s must not be before the command above, at 1.0 s",
    '[[command]]\nat = "1 s"\ndo = "safe"\n': "mission.toml:2: at = '1 s' must be a time in s, from 0 on",
    '[[command]]\ndo = "safe"\n': "mission.toml:1: at = None must be a time in s, from 0 on",
    '[[command]]\nat = 1.0\ndo = "safe"\nangle = 2\n':
        "mission.toml:4: angle: no such key of safe; there are at, do",
    SLEW + 'unit = "degrees"\n': "mission.toml:5: unit = 'degrees' must be one of rad, deg, arcsec",
    SLEW.replace("1.0, 0.0", "0.0, 0.0"):
        "mission.toml:4: rotation = [0.0, 0.0, 0.0] rad must turn somewhere, by at most a turn about each axis",
    SLEW.replace(", 0.0]", "]"):
        "mission.toml:4: rotation = [1.0, 0.0] must be three numbers: the rotation vector of the slew",
    '[set]\n"torque" = 1.0\n':
        "mission.toml:2: torque = 1.0 must be a parameter and its value, or a list of one for each element, such as"
        ' "environment.constant.torque" = [0.01, 0.0, 0.0]',
    SLEW + '[set]\n"mission.timeline.time" = [3.0]\n':
        "mission.toml:5: mission.timeline.time[1] is of the commands above too; give commands by [[command]] alone",
    SLEW * 49: "mission.toml:193: 49 commands; a timeline holds 48",
}  # fmt: skip


@pytest.mark.parametrize("text", WRONG)
def test_a_wrong_file_is_refused_in_one_line_with_its_line(system: System, tmp_path: Path, text: str):
    path = tmp_path / "mission.toml"
    path.write_text(text)
    with pytest.raises(InputError) as refused:
        mission_values(system, path)

    assert str(refused.value) == WRONG[text]


def test_a_system_without_a_manager_is_refused(system: System, tmp_path: Path):
    other = replace(system, name="bare", components=(replace(system.components[0], name="plant"),))

    with pytest.raises(InputError, match=r"--mission: bare has no component mission; `flexsat build --missions`"):
        mission_values(other, tmp_path / "none.toml")


@pytest.mark.parametrize("path", sorted(EXAMPLES.glob("*.toml")), ids=lambda path: path.stem)
def test_the_examples_are_read(system: System, path: Path):
    values = mission_values(system, path)

    assert values["mission.timeline.action[1]"] in (1, 2)
    assert "mission.off_loading.duration" in values
