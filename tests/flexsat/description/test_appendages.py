"""Appendages of a spacecraft's file: modal files at interfaces and angles, nodes as sites; wrong ones are refused."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from flexsat.description.spacecraft_file import parse_spacecraft, read_spacecraft
from flexsat.errors import SpacecraftFileError
from flexsat.spacecraft.assembly import build_spacecraft
from flexsat.structure.modal_data import ModalData
from flexsat.structure.modal_file import write_modal

TEXT = """\
name = "arrays"
wheels = [{ at = "bus", axes = ["+x", "+y", "+z"] }]
gyros = [{ at = "bus", axes = ["+x", "+y"] }, { at = "tip", axes = ["+z"] }]
accelerometers = [{ at = "tip", axes = ["+x"] }]
[sites]
tip = { node = "north.tip" }
[bus]
mass = 500
inertia = [100, 100, 100]
[modes]
plant = 3
[[appendages]]
name = "north"
file = "array.npz"
at = [0, "1 m", 0]
orientation = [0, 0, "90 deg"]
angle = "30 deg"
axis = "+x"
[[appendages]]
name = "south"
file = "array.npz"
at = [0, "-1 m", 0]
orientation = [0, 0, "-90 deg"]
damping_ratio = 0.01
modes = 1
"""
FREQUENCY = np.array([0.5, 2.0])  # Hz


def array():
    """Return a mass of 8 kg at 4 m along x that moves across: two modes, along z and y."""
    place, mass = np.array([[4.0, 0.0, 0.0]]), 8.0
    shape = np.zeros((1, 3, 2))
    shape[0, 2, 0] = shape[0, 1, 1] = 1.0 / np.sqrt(mass)
    return ModalData(
        kind="clamped",
        frequency=FREQUENCY,
        damping_ratio=np.array([0.002, 0.002]),
        node_name=("tip",),
        node_position=place,
        node_translation=shape,
        node_mass=np.array([mass]),
    )


@pytest.fixture
def folder(tmp_path):
    write_modal(tmp_path / "array.npz", array())
    (tmp_path / "arrays.toml").write_text(TEXT, encoding="utf-8")
    return tmp_path


def test_appendages_are_where_and_as_the_file_says(folder):
    read = read_spacecraft(folder / "arrays.toml")
    config = read.configurations["robust"]
    craft = build_spacecraft(config)

    assert config.aperture is None
    assert read.files == {"array.npz": (folder / "array.npz").read_bytes()}
    assert_allclose(craft.frequency, 2.0 * np.pi * np.array([0.5, 0.5, 2.0]), rtol=1e-14)
    assert_allclose(craft.damping / craft.frequency / 2.0, [0.002, 0.01, 0.002], rtol=1e-14)
    assert_allclose(craft.mass, 516.0)
    assert_allclose(craft.centre, 0.0, atol=1e-15)
    assert_allclose(craft.accelerometers.position, [[0.0, 5.0, 0.0]], atol=1e-14)
    # two masses 5 m to both sides along y: xx and zz
    assert_allclose(np.diag(craft.inertia), [100.0 + 400.0, 100.0, 100.0 + 400.0], rtol=1e-13)
    # the north's motion is turned by 30 deg about its axis, +y of the body: z to z cos 30, and x sin 30
    root, cosine, sine = np.sqrt(8.0), np.cos(np.pi / 6.0), 0.5
    assert_allclose(craft.translation[:, 0], [root * sine, 0.0, root * cosine], atol=1e-13)
    assert_allclose(craft.rotation[:, 0], np.cross([0.0, 5.0, 0.0], craft.translation[:, 0]), atol=1e-13)
    assert_allclose(craft.accelerometers.deflection[0, :, 0], [sine / root, 0.0, cosine / root], atol=1e-13)
    assert_allclose(craft.translation[:, 1], [0.0, 0.0, root], atol=1e-13)
    assert not craft.gyros.slope[:2].any()  # the bus is rigid


def test_what_is_left_out_is_all_there_is(folder):
    text = TEXT.replace("plant = 3\n", "")
    config = parse_spacecraft(text, "my.toml", folder).configurations["robust"]
    assert (config.modes.plant, config.modes.design) == (3, 3)
    with_aperture = parse_spacecraft(text.replace("[modes]", "[plate]\n[modes]"), "my.toml", folder)
    assert with_aperture.configurations["robust"].aperture is not None
    craft = build_spacecraft(with_aperture.configurations["robust"])
    assert craft.mode_count == 198
    assert_allclose(craft.mass, 4200.0 + 516.0, rtol=1e-12)


def test_a_copy_beside_the_file_is_found(folder):
    text = TEXT.replace('"array.npz"', '"/nowhere/data/array.npz"')
    assert parse_spacecraft(text, "my.toml", folder).name == "arrays"


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (
            'node = "north.tip"',
            'node = "north.tap"',
            'my.toml:6: sites.tip.node = "north.tap": no such node; there are',
        ),
        ('node = "north.tip"', "radius = 2", "my.toml:6: sites.tip: radius and angle are of a node of the aperture"),
        ('file = "array.npz"', 'file = "arrays.npz"', 'my.toml:14: appendages[1].file = "arrays.npz": cannot be read'),
        (
            'file = "array.npz"',
            'file = "arrays.toml"',
            'my.toml:14: appendages[1].file = "arrays.toml": not a modal file',
        ),
        ("plant = 3", "plant = 4", "my.toml:11: modes.plant = 4: must be at most 3, the modes of the structure"),
        ("damping_ratio = 0.01", "damping_ratio = 2", "my.toml:24: appendages[2].damping_ratio = 2: must be a number"),
        ('angle = "30 deg"\n', "", 'my.toml:17: appendages[1].axis = "+x": is that of a drive; give its angle, or tu'),
        ('axis = "+x"', 'axis = "x"', 'my.toml:18: appendages[1].axis = "x": must be +x, +y'),
        ('name = "south"', 'name = "north"', "my.toml:12: appendages: two are called 'north'"),
        ('name = "south"\n', "", "my.toml:19: appendages[2]: name is missing"),
        (
            '"30 deg"',
            '"800 deg"',
            'my.toml:17: appendages[1].angle = "800 deg": must be >= -6.28319 and <= 6.28319 rad',
        ),
    ],
)
def test_a_wrong_appendage_is_refused_in_one_line(folder, old, new, message):
    assert old in TEXT
    with pytest.raises(SpacecraftFileError) as caught:
        parse_spacecraft(TEXT.replace(old, new, 1), "my.toml", folder)
    assert "\n" not in str(caught.value)
    assert str(caught.value).startswith(message), caught.value
