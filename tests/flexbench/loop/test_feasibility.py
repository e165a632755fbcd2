"""What a command needs is known before a run, in closed form, and one that cannot be carried out is refused."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from flexbench.cli.parser import main
from flexbench.loop.feasibility import Needs, needs_of
from flexsat.parameters import ARCSECOND, DEGREE, RPM
from lockstep import InputError, load_system, read_signals
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


def test_unequal_wheels_need_what_their_own_limits_allow(needs):
    """Wheel 4, beside wheel 1 about x, has half of the torque and of the band; then wheel 1 alone."""
    half = needs(**{f"controller__wheel.{name}_factor[4]": 0.5 for name in ("torque_limit", "speed_band")})
    assert half.torque / half.torque_limit == pytest.approx(AUTHORITY, rel=1e-4)
    assert half.momentum / half.momentum_limit == pytest.approx(AUTHORITY, rel=1e-4)
    rate, ramp = AUTHORITY * 1.5 * MOMENTUM / BODY, MOMENTUM / TORQUE
    assert half.end == pytest.approx(START + 0.5 * DEGREE / rate + ramp + 0.15, abs=0.06)
    alone = needs(**{"controller__wheel.torque_limit_factor[4]": 0.0})
    assert alone.end == pytest.approx(START + 0.5 * DEGREE * BODY / (AUTHORITY * MOMENTUM) + ramp + 0.15, abs=0.06)
    assert (alone.torque_limit, alone.momentum_limit) == pytest.approx((TORQUE, MOMENTUM), rel=1e-9)


def test_wheels_off_their_nominal_speeds_are_planned_with_what_they_have_left(needs):
    """Both wheels about x at 10 of their 25 rpm, in the sense of the slew: refused unless the controller knows it."""
    offset = {"initial.wheel.speed_offset[1]": "-10 rpm", "initial.wheel.speed_offset[4]": "10 rpm"}
    unknown = needs(**{f"plant__{name}": value for name, value in offset.items()})
    assert unknown.momentum == pytest.approx((AUTHORITY + 0.4) * MOMENTUM, rel=1e-4)
    assert "a slew is planned for wheels at controller.wheel.speed_offset" in unknown.objection()
    known = needs(
        **{f"plant__{name}": value for name, value in offset.items()},
        **{f"controller__{name.removeprefix('initial.')}": value for name, value in offset.items()},
    )
    assert known.momentum == pytest.approx(AUTHORITY * MOMENTUM, rel=1e-4)
    assert known.objection() is None
    assert known.end > unknown.end + 50.0


def numbers(**changed):
    """Return needs that are met, but for what is changed."""
    met = {"angles": (0.1,), "start": 5.0, "end": 50.0, "stop": 50.0, "torque": 4.0, "torque_limit": 4.0,
           "momentum": 2.0, "momentum_limit": 2.0}  # fmt: skip
    return Needs(**(met | changed))


def test_what_is_just_met_is_accepted_and_what_is_not_names_the_remedy():
    assert numbers().objection() is None
    assert "ends at 50.25 s; give --stop-time 51 or more" in numbers(end=50.25).objection()
    assert "set controller.slew.authority lower, or the same wheel.torque_limit" in numbers(torque=4.1).objection()
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


def cone(half_angle, degrees=0.25):
    """Return the options that set a cone about where the boresight, +z, points half way through 0.5 deg about x."""
    direction = {2: -np.sin(degrees * DEGREE), 3: np.cos(degrees * DEGREE)}
    settings = [f"controller.keep_out.first.direction[{axis}]={float(value)!r}" for axis, value in direction.items()]
    return [
        word for one in [*settings, f"controller.keep_out.first.half_angle={half_angle}deg"] for word in ("--set", one)
    ]


@pytest.mark.parametrize("guidance", ["bang-coast-bang", "smoothed", "qp"])
def test_a_slew_that_ends_within_a_cone_is_refused_in_one_line(delivered, tmp_path, capsys, guidance):
    system = str(delivered / "centralised" / "slew.ssd")
    words = [*cone(0.1, 0.55), "--set", f"controller.slew.guidance={guidance}", "--out", str(tmp_path / "run")]
    assert main(["run", system, *words]) == 2
    (line,) = [line for line in capsys.readouterr().err.splitlines() if line.startswith("flexsat: ")]
    assert "the slew ends with keep_out.axis at 0.05 deg from keep_out.first.direction, within" in line
    assert line.endswith("keep_out.first.half_angle = 0.1 deg; command another attitude, or set that angle lower")
    assert not (tmp_path / "run").exists()


def test_where_a_run_begins_counts(needs):
    """From 60 deg about y the same slew stays far from the cone that it would end in from zero."""
    ends_inside = {"controller__keep_out.first.direction[3]": 1.0, "controller__keep_out.first.half_angle": 0.002}
    with pytest.raises(InputError, match=r"the slew begins with keep_out\.axis at 0 deg from keep_out\.first"):
        needs(**ends_inside)
    assert len(needs(**ends_inside, **{"plant__initial.mrp[2]": np.tan(0.25 * 60.0 * DEGREE)}).angles) == 1


def test_a_slew_is_flown_round_a_cone(delivered, tmp_path, capsys):
    """Through the FMUs, on raised limits: the reference never enters the cone, the body stays outside, and arrives."""
    half, middle = 0.02, 0.1
    settings = {"controller.wheel.torque_limit": 176.0, "plant.wheel.torque_limit": 176.0, "plant.modes": 25,
                "controller.wheel.speed_band": "1000rpm", "controller.command.start_time": 0.5,
                "controller.command.rotation[1]": "0.2deg"}  # fmt: skip
    words = [word for name, value in settings.items() for word in ("--set", f"{name}={value}")]
    folder = tmp_path / "run"
    system = str(delivered / "centralised" / "slew.ssd")
    assert main(["run", system, *cone(half, middle), *words, "--stop-time", "6.5", "--out", str(folder)]) == 0
    assert "slews of 0." in capsys.readouterr().out
    signals = read_signals(folder)
    centre = [0.0, -np.sin(middle * DEGREE), np.cos(middle * DEGREE)]
    outside = {}
    for name in ("controller.reference.mrp", "plant.attitude.mrp"):
        pointing = Rotation.from_mrp(signals[name]).apply([0.0, 0.0, 1.0])
        outside[name] = np.arcsin(np.linalg.norm(np.cross(pointing, centre), axis=1)).min() - half * DEGREE
    assert outside["controller.reference.mrp"] > -1e-9
    assert outside["plant.attitude.mrp"] > -20.0 * ARCSECOND  # twice the noise of the star tracker
    end = Rotation.from_mrp(signals["plant.attitude.mrp"][-1])
    assert (end.inv() * Rotation.from_rotvec([2.0 * middle * DEGREE, 0.0, 0.0])).magnitude() < 20.0 * ARCSECOND
