"""What a spacecraft's file says is built, in any unit; a wrong one is refused by line, key, value and remedy."""

import math
import re

import numpy as np
import pytest

from flexsat.controller_weights import Weights
from flexsat.description.built_in import CONFIGURATIONS, built_in, configuration
from flexsat.description.placement import Bus, Device, Site
from flexsat.description.spacecraft_file import parse_spacecraft, read_spacecraft
from flexsat.errors import SpacecraftFileError
from flexsat.parameters import (
    ARCSECOND,
    DEGREE,
    RPM,
    Aperture,
    Harmonic,
    Modes,
    Plate,
    Rates,
    SensorNoise,
    Slew,
    SpeedSelection,
    Wheel,
)

TEXT = """\
name = "pyramid"
wheels = [
  { at = "bus", axes = ["+x", "-y", [1, 1, 1]] },
  { at = "top", axes = ["+z"] },
]
gyros = [{ at = "tip", axes = ["+x", "+y"] }]
accelerometers = [{ at = "bus", axes = ["+z"] }]
[sites]
tip = { radius = "14176 mm", angle = "60 deg" }
top = { on_bus = [0.0, 0.0, "500 mm"] }
[bus]
mass = "800 kg"
inertia = [500, 500.0, "600 kg.m2"]
[wheel]
factor = 2.0
inertia = 0.5
speed_band = "30 rpm"
imbalance_force = "1e-7 N/rpm2"
[noise]
gyro = "1e-4 deg/s/rtHz"
star_tracker_fine = "0.2 arcsec"
[modes]
plant = 40
design = 7
[controller]
mrp = 2e6
[controller.published]
mrp = 5e6
rate = 0.0
"""


def test_units_and_defaults_of_a_file():
    spacecraft = parse_spacecraft(TEXT.replace('[500, 500.0, "600 kg.m2"]', "[500, 500.0, 600]"), "my.toml")

    robust, published = (spacecraft.configurations[design] for design in ("robust", "published"))
    third = 1.0 / math.sqrt(3.0)
    assert spacecraft.name == robust.name == "pyramid"
    assert robust.layout == "4 wheels"
    assert robust.sites == (
        Site(name="tip", radius=14.176, angle=60.0),
        Site(name="top", on_bus=(0.0, 0.0, 0.5)),
    )
    assert robust.wheels == (
        Device(site="bus", axis=(1.0, 0.0, 0.0)),
        Device(site="bus", axis=(0.0, -1.0, 0.0)),
        Device(site="bus", axis=(1.0 / math.hypot(1, 1, 1),) * 3),
        Device(site="top", axis=(0.0, 0.0, 1.0)),
    )
    assert robust.wheels[2].axis == pytest.approx((third,) * 3, rel=1e-15)
    assert robust.bus == Bus(mass=800.0, inertia=(500.0, 500.0, 600.0, 0.0, 0.0, 0.0))
    assert robust.wheel == Wheel(inertia=0.5, speed_band=30.0 * RPM, imbalance_force=1e-7 / RPM**2).scaled(2.0)
    # a density of white noise, over the root of the period: 200 Hz
    assert robust.noise.gyro == pytest.approx(1e-4 * DEGREE * math.sqrt(200.0), rel=1e-15)
    assert robust.noise.star_tracker_fine == pytest.approx(0.2 * ARCSECOND, rel=1e-15)
    assert robust.modes == Modes(plant=40, design=7)
    assert (robust.weights, published.weights) == (Weights(mrp=2e6), Weights(mrp=5e6, rate=0.0))
    assert robust.release is None


KINDS = """\
[wheel_kinds.small]
inertia = 0.25
torque_limit = "200 mN.m"
speed_limit = 300
full_torque_speed = 200.0
friction_torque = 1e-3
harmonics = [
  { order = 2, force = "1e-8 N/rpm2", phase = "90 deg" },
  { order = 3.4, torque = 1e-7 },
]
[wheel_kinds.large]
factor = 2
harmonics = [{ order = 5, force = 1e-7 }]
"""


def test_errors_of_sensors_have_units_and_go_to_the_sensors_and_weights_to_the_filter():
    errors = """[sensor_errors]
gyro_bias = "3 deg/h"
gyro_bias_walk = "0.6 deg/h/rth"
gyro_misalignment = "20 arcsec"
star_tracker_misalignment = ["10 arcsec", "0 arcsec", "-5 arcsec"]
boresight = [0, 0.6, 0.8]
roll_factor = 6
[modes]"""
    plain = TEXT.replace('[500, 500.0, "600 kg.m2"]', "[500, 500.0, 600]")
    text = plain.replace("[modes]", errors).replace("mrp = 2e6", "mrp = 2e6\ntorque_walk = 3e-7")
    given = parse_spacecraft(text, "my.toml").configurations["robust"]
    found = given.sensor_errors
    assert found.gyro_bias == pytest.approx(3.0 * DEGREE / 3600.0, rel=1e-14)
    # a walk by 0.6 deg/h in an hour: 0.01 deg/h in a second
    assert found.gyro_bias_walk == pytest.approx(0.01 * DEGREE / 3600.0, rel=1e-14)
    assert found.gyro_misalignment == pytest.approx(20.0 * ARCSECOND, rel=1e-14)
    assert found.star_tracker_misalignment == pytest.approx((10.0 * ARCSECOND, 0.0, -5.0 * ARCSECOND), rel=1e-14)
    assert (found.boresight, found.roll_factor, found.gyro_scale_error) == ((0.0, 0.6, 0.8), 6.0, 0.0)
    assert given.weights.torque_walk == 3e-7


def test_wheels_of_several_kinds():
    text = TEXT.replace('[500, 500.0, "600 kg.m2"]', "[500, 500.0, 600]")
    for entry, kind in (('at = "top", axes', "small"), ('at = "bus", axes = ["+x", "-y"', "large")):
        text = text.replace(entry, entry.replace('", axes', f'", kind = "{kind}", axes'))
    with pytest.raises(SpacecraftFileError, match=r"my\.toml:14: wheel: is that of wheels without kind"):
        parse_spacecraft(text + KINDS, "my.toml")
    text = re.sub(r"\[wheel\]\n[^\[]*", "", text)
    found = parse_spacecraft(text + KINDS, "my.toml")
    config = found.configurations["robust"]
    small = Wheel(
        inertia=0.25, torque_limit=0.2, speed_limit=300.0, full_torque_speed=200.0, friction_torque=1e-3,
        harmonics=(Harmonic(order=2.0, force=1e-8 / RPM**2, phase=math.pi / 2.0), Harmonic(order=3.4, torque=1e-7)),
    )  # fmt: skip
    large = Wheel(harmonics=(Harmonic(order=5.0, force=1e-7),)).scaled(2.0)
    assert [device.wheel for device in config.wheels] == [large, large, large, small]
    assert large.harmonics == (Harmonic(order=5.0, force=2e-7),)
    wheels = config.wheel_set
    assert wheels.inertia.tolist() == [1.68, 1.68, 1.68, 0.25]
    assert wheels.harmonic_order.tolist() == [[5.0, 1.0]] * 3 + [[2.0, 3.4]]
    assert wheels.harmonic_force.tolist() == [[2e-7, 0.0]] * 3 + [[1e-8 / RPM**2, 0.0]]
    assert wheels.kinds == "3 of 1.68 kg.m2 and 1.6 N.m, 1 of 0.25 kg.m2 and 0.2 N.m"
    # full to 200 rad/s, a quarter at 275, none at 300; the others have no limit
    speeds = np.array([1e3, -1e3, 0.0, -275.0])
    assert wheels.torque_at(speeds) == pytest.approx([1.6, 1.6, 1.6, 0.05], rel=1e-12)


def test_the_files_of_the_paper_say_what_the_classes_have_from_paper_and_release():
    assert CONFIGURATIONS == ("centralised", "distributed")
    small = Wheel()
    for name in CONFIGURATIONS:
        found = configuration(name, "published")
        large = name == "centralised"
        given = (found.aperture, found.plate, found.noise, found.rates, found.slew, found.speeds)
        assert given == (Aperture(), Plate(), SensorNoise(), Rates(), Slew(), SpeedSelection())
        assert found.wheel == (small.scaled(5.5) if large else small)
        assert found.weights == Weights(scale=5.5 if large else 1.0)
        assert found.bus == Bus()
        assert (len(found.wheels), len(found.gyros), len(found.accelerometers)) == (6 if large else 33, 23, 13)
        assert built_in(name).name == name


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("factor = 2.0", "factr = 2.0", "my.toml:15: wheel.factr: no such key of wheel; there are inertia"),
        ("inertia = 0.5", 'inertia = "4 kg"', 'my.toml:16: wheel.inertia = "4 kg": has the unit kg; it is measured in'),
        ("inertia = 0.5", "inertia = -1.0", "my.toml:16: wheel.inertia = -1.0: must be > 0 kg.m2"),
        (
            'at = "top"',
            'at = "top", kind = "big"',
            'my.toml:4: wheels[2].kind = "big": no such kind of wheel; there are',
        ),
        (
            "inertia = 0.5",
            "full_torque_speed = 3.0",
            "my.toml:16: wheel.full_torque_speed: must be at most speed_limit (0",
        ),
        ("inertia = 0.5", "harmonics = [{ force = 1e-7 }]", "my.toml:16: wheel.harmonics[1]: order is missing"),
        (
            "inertia = 0.5",
            "harmonics = [{ order = 0 }]",
            "my.toml:16: wheel.harmonics[1].order = 0: must be > 0 and <=",
        ),
        (
            "[modes]",
            "[wheel_kinds.big]\nfactor = 2\n[modes]",
            'my.toml:22: wheel_kinds.big: has no wheel; write kind = "big" in an entry of wheels',
        ),
        ("factor = 2.0", "factor = 0", "my.toml:15: wheel.factor = 0: must be a number > 0"),
        (
            'at = "top"',
            'at = "tops"',
            'my.toml:4: wheels[2].at = "tops": no such site; there are bus, tip, top; did you',
        ),
        ('"-y"', '"y"', 'my.toml:3: wheels[1].axes[2] = "y": must be +x, +y, +z, -x, -y, -z, or a direction such as'),
        ("[1, 1, 1]", "[0, 0, 0]", "my.toml:3: wheels[1].axes[3] = [0, 0, 0]: an axis has a direction"),
        ('"-y", [1, 1, 1]', '"-x"', "my.toml:2: wheels: 3 wheels give no torque about some axis"),
        (
            "angle =",
            "angel =",
            "my.toml:9: sites.tip.angel: no such key of sites.tip; there are radius, angle, node, on_bus; did",
        ),
        ('"60 deg"', '"63 deg"', "my.toml:9: sites.tip: 14.176 m at 63 deg: no mesh node; nearest is 0.742 m off"),
        ('[500, 500.0, "600 kg.m2"]', "[1, 1, 3]", "my.toml:13: bus.inertia: is that of no rigid body: its principal"),
        (
            '[500, 500.0, "600 kg.m2"]',
            '[1, 1, "1 kg.m2"]',
            "my.toml:13: bus.inertia = [1, 1, '1 kg.m2']: 1 has no unit",
        ),
        ('mass = "800 kg"', "mass = 0", "my.toml:12: bus.mass: must be > 0 for a bus with inertia"),
        ("1e-4 deg/s/rtHz", "1 deg/s/rtHz", 'my.toml:20: noise.gyro = "1 deg/s/rtHz": is a deviation of 0.247 of'),
        ("design = 7", "design = 70", "my.toml:24: modes.design: must be at most plant (40)"),
        ("plant = 40", "plant = 400", "my.toml:23: modes.plant = 400: must be at most 396"),
        ("plant = 40", "plant = 40.5", "my.toml:23: modes.plant = 40.5: must be a whole number"),
        (
            "[modes]",
            '[sensor_errors]\ngyro_bias = "3 deg/m"\n[modes]',
            'my.toml:23: sensor_errors.gyro_bias = "3 deg/m": has the unit deg/m; it is measured in rad/s or deg/s or',
        ),
        (
            "[modes]",
            "[sensor_errors]\nboresight = [0, 0, 0]\n[modes]",
            "my.toml:23: sensor_errors.boresight: must have a direction",
        ),
        ("mrp = 2e6", "mrp = nan", "my.toml:26: controller.mrp = nan: must be finite, a number"),
        ("mrp = 5e6", "mrp = -5e6", "my.toml:28: controller.published.mrp: must be >= 0, got -5000000.0"),
        (
            "[controller.published]",
            "[controller.publishd]",
            "my.toml:27: controller.publishd: no such key of controller",
        ),
        ('name = "pyramid"', 'name = "my craft"', 'my.toml:1: name = "my craft": must be small letters, digits and _'),
        ('name = "pyramid"', "", 'my.toml: name: is missing; write for example name = "pyramid"'),
        ("[wheel]", "[wheel", "my.toml: not TOML: "),
        (
            'at = "bus", axes = ["+z"]',
            'at = "tip", axes = ["+x"]',
            "my.toml:7: accelerometers: the one at tip senses along",
        ),
        (
            "[modes]",
            "[aperture]\nrings = 3\n[modes]",
            'my.toml:22: aperture.mesh: "record" is made for tiles of 2.0 m in 4',
        ),
        ("[modes]", "[as_published]\nmodes = 5\n[modes]", "my.toml:22: as_published.mode_rows: must have each site"),
    ],
)
def test_a_wrong_file_is_refused_in_one_line(old, new, message):
    text = TEXT.replace('[500, 500.0, "600 kg.m2"]', "[500, 500.0, 600]") if not old.startswith("[500") else TEXT
    assert old in text

    with pytest.raises(SpacecraftFileError) as refusal:
        parse_spacecraft(text.replace(old, new, 1), "my.toml")

    assert str(refusal.value).startswith(message)
    assert "\n" not in str(refusal.value)


def test_a_file_that_cannot_be_read_is_refused(tmp_path):
    binary = tmp_path / "binary.toml"
    binary.write_bytes(b"name = '\xff'")
    for path, message in (
        (tmp_path / "no.toml", r"no\.toml: cannot be read \(No such file"),
        (binary, "not UTF-8 at byte 8"),
    ):
        with pytest.raises(SpacecraftFileError, match=message):
            read_spacecraft(path)
