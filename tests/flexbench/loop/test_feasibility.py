"""What a command needs is known before a run, in closed form, and one that cannot be carried out is refused."""

import numpy as np
import pytest

from flexbench.cli.parser import main
from flexbench.loop.feasibility import Needs, needs_of
from flexsat.parameters import DEGREE, RPM
from lockstep import InputError, load_system
from lockstep.plan.plan import Plan

TORQUE, INERTIA, BAND = 4.4, 4.62, 25.0 * RPM  # of a wheel: N.m, kg.m2, rad/s (PHYSICS section 3)
BODY = 2.177e5  # kg.m2 about x; two wheels turn it
AUTHORITY, START = 0.8, 5.0
MOMENTUM = INERTIA * BAND
HEAD = "time,controller.command.rotation[1] [deg],controller.command.start_time\n"  # of a table of commands


@pytest.fixture(scope="module")
def needs(delivered):
    """Return a function that gives what the centralised slew needs, with other parameters."""

    def of(stop_time=None, scenario="slew", **overrides):
        system = load_system(delivered / "centralised" / f"{scenario}.ssd")
        named = {name.replace("__", "."): value for name, value in overrides.items()}
        return needs_of(Plan(system, stop_time, named, None, None))

    return of


def test_needs_of_the_paper_s_slew_are_those_of_a_trapezium(needs):
    found = needs()
    rate = AUTHORITY * 2.0 * MOMENTUM / BODY
    ramp = AUTHORITY * MOMENTUM / (AUTHORITY * TORQUE)
    end = START + 0.5 * DEGREE / rate + ramp

    assert (found.start, found.stop) == (START, 300.0)
    assert found.angles == pytest.approx((0.5 * DEGREE,), rel=1e-12)
    assert found.end == pytest.approx(end + 0.15, abs=0.06)  # three digits of the inertia; the shaper's spacing
    assert (found.torque_limit, found.momentum_limit) == pytest.approx((TORQUE, MOMENTUM), rel=1e-9)
    assert found.torque == pytest.approx(AUTHORITY * TORQUE, rel=1e-4)
    assert found.momentum == pytest.approx(AUTHORITY * MOMENTUM, rel=1e-4)
    assert found.objection() is None
    assert found.text().startswith("slew of 0.5 deg from 5 s: ends at 106")


def test_wheels_carry_the_momentum_of_rates_offsets_and_external_torques_too(needs):
    """Signed: a body that turns as the slew will leaves less to do for it."""
    share = MOMENTUM * AUTHORITY
    with_it, against = (needs(**{"plant__initial.rate[1]": rate}).momentum for rate in (1e-5, -1e-5))
    assert with_it == pytest.approx(share - 0.5 * BODY * 1e-5, rel=1e-3)
    assert against == pytest.approx(share + 0.5 * BODY * 1e-5, rel=1e-3)
    held = needs(scenario="fine_pointing", **{"plant__external.torque[2]": 0.01})
    assert held.momentum == pytest.approx(0.5 * 0.01 * 300.0, rel=1e-3)
    assert needs(
        scenario="fine_pointing", **{"plant__initial.wheel.speed_offset[3]": "2 rpm"}
    ).momentum == pytest.approx(INERTIA * 2.0 * RPM)
    assert needs(scenario="fine_pointing") is None  # nothing is asked of the wheels
    assert needs(controller__open_loop=True) is None


def test_the_slews_of_a_table_follow_each_other(delivered, tmp_path):
    """Two slews of 0.01 deg, the second there and back; then the wheels stand as before."""
    table = tmp_path / "commands.csv"
    table.write_text(HEAD + "0,0.01,5\n20,-0.01,30\n25,-0.01,30\n")
    system = load_system(delivered / "centralised" / "slew.ssd")
    found = needs_of(Plan(system, 50.0, {}, None, None, inputs=[table]))
    ramp = np.sqrt(0.01 * DEGREE * BODY / (AUTHORITY * 2.0 * TORQUE))  # never at the largest rate

    assert found.angles == pytest.approx((0.01 * DEGREE, 0.01 * DEGREE), rel=1e-9)
    assert (found.start, found.end) == pytest.approx((5.0, 30.0 + 2.0 * ramp + 0.15), abs=0.06)
    assert found.text().startswith("slews of 0.01, 0.01 deg from 5 s: the last ends at 3")
    assert found.objection() is None
    table.write_text(HEAD + "0,0.01,5\n7,-0.01,7\n")
    with pytest.raises(
        InputError, match=r"command\.rotation changed at 7\.000 s, after the slew of 5\.000 s had begun"
    ):
        needs_of(Plan(system, 50.0, {}, None, None, inputs=[table]))


def numbers(**changed):
    """Return needs that are met, but for what is changed."""
    met = {"angles": (0.1,), "start": 5.0, "end": 50.0, "stop": 50.0, "torque": 4.0, "torque_limit": 4.0,
           "momentum": 2.0, "momentum_limit": 2.0}  # fmt: skip
    return Needs(**(met | changed))


def test_what_is_just_met_is_accepted_and_what_is_not_names_the_remedy():
    assert numbers().objection() is None
    assert "ends at 50.25 s; give --stop-time 51 or more" in numbers(end=50.25).objection()
    assert "set controller.slew.authority lower, or the wheel.torque_limit" in numbers(torque=4.1).objection()
    assert "a wheel would have to take 2.1 N.m.s" in numbers(momentum=2.1).objection()
    assert numbers(angles=(), end=60.0).objection() is None


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        (("--stop-time", "20"), "stop time 20 s: the slew of 0.5 deg from 5 s ends at 106"),
        (("--set", "controller.command.rotation[1]=20deg"), "stop time 300 s: the slew of 20 deg from 5 s ends at 39"),
        (("--set", "plant.wheel.torque_limit=0.5"), "torque: the slew needs 3.52 N.m of a wheel that gives 0.5 N.m"),
        (
            ("--set", "plant.initial.rate[1]=-0.01deg/s"),
            "momentum: a wheel would have to take 28.67 N.m.s",
        ),
    ],
)
def test_a_command_that_cannot_be_carried_out_is_refused_in_one_line(delivered, tmp_path, capsys, settings, message):
    system = str(delivered / "centralised" / "slew.ssd")
    assert main(["run", system, *settings, "--out", str(tmp_path / "run")]) == 2
    printed = capsys.readouterr()

    (line,) = [line for line in printed.err.splitlines() if line.startswith("flexsat: ")]
    assert message in line
    assert line.endswith("; --accept-infeasible runs it as it is")
    assert printed.out.startswith("slew of ")
    assert not (tmp_path / "run").exists()


def test_it_runs_if_that_is_accepted(delivered, tmp_path, capsys):
    system = str(delivered / "centralised" / "slew.ssd")
    words = ["--accept-infeasible", "--stop-time", "0.05", "--out", str(tmp_path / "run")]
    assert main(["run", system, *words]) == 0
    printed = capsys.readouterr().out
    assert "runs nevertheless: stop time 0.05 s: the slew of 0.5 deg from 5 s ends at 106" in printed
    assert "no torque saturation, no wheel speed outside its band, no limit cycle, no divergence" in printed


def test_percentages_of_nothing_are_none():
    assert "momentum 0 of 0 N.m.s (none)" in numbers(momentum=0.0, momentum_limit=0.0).text()
