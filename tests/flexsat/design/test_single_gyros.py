"""Noise and mounting error of single gyros: from the file to the sensors' parameters and the filter's gain."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from flexsat.description.built_in import configuration
from flexsat.description.file_text import file_of
from flexsat.description.spacecraft_file import parse_spacecraft
from flexsat.design.chain import build_design
from flexsat.errors import SpacecraftFileError
from flexsat.parameters import ARCSECOND, DEGREE
from fmus.turning_array import TEXT, write_files

BUS = 'gyros = [{{ at = "bus", axes = ["+x", "+y"] }}, {{ at = "tip", axes = ["+z", [1, 1, 0]] }}]'
OWN = (
    'gyros = [{{ at = "bus", axes = ["+x"], noise = "1e-4 deg/s", mounting_error = [0, "20 arcsec", 0] }},'
    ' {{ at = "bus", axes = ["+y"] }}, {{ at = "tip", axes = ["+z", [1, 1, 0]] }}]'
)
ALL = (
    BUS.replace("]) }}", "]")
    .replace('"] }}', '"], noise = "3e-5 deg/s" }}')
    .replace("0]] }}", '0]], noise = "3e-5 deg/s" }}')
)


@pytest.fixture(scope="module")
def read(tmp_path_factory):
    """Return a reader of the file with other gyros and more behind its end, as a configuration."""
    folder = tmp_path_factory.mktemp("gyros")
    write_files(folder)

    def configuration(gyros, more=""):
        text = TEXT.replace(BUS, gyros).format(north=0.0, south=0.0, modes=4) + more
        return parse_spacecraft(text, "my.toml", folder).configurations["robust"]

    return configuration


def test_sensors_and_filter_have_what_the_file_says(read):
    plain, own = build_design(read(BUS)), build_design(read(OWN))
    assert_array_equal(plain.sensors.gyro_noise_factor, 1.0)
    assert not plain.sensors.gyro_mounting_error.any()
    assert own.sensors.gyro_noise == 1e-4 * DEGREE
    assert_allclose(own.sensors.gyro_noise_factor, [1.0, 0.1, 0.1, 0.1], rtol=1e-15)
    assert_allclose(own.sensors.gyro_mounting_error[:, 0], [0.0, 20.0 * ARCSECOND, 0.0], rtol=1e-15)
    assert not own.sensors.gyro_mounting_error[:, 1:].any()
    # the filter trusts a gyro of ten times the noise less
    weight = [np.abs(design.controller.gain_fine[0, :, 0]).max() for design in (plain, own)]
    assert weight[1] < 0.3 * weight[0]


def test_one_noise_of_all_gyros_is_that_of_each(read):
    each, common = build_design(read(ALL)), build_design(read(BUS, '[noise]\ngyro = "3e-5 deg/s"\n'))
    assert each.sensors.gyro_noise == common.sensors.gyro_noise
    assert_array_equal(each.controller.gain_fine, common.controller.gain_fine)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (
            'noise = "1e-4 deg/s"',
            'noise = "2 deg/s"',
            'my.toml:3: gyros[1].noise = "2 deg/s": must be >= 0 and <= 0.01',
        ),
        ('"20 arcsec"', '"2 deg"', "my.toml:3: gyros[1].mounting_error[2]"),
        ('noise = "1e-4 deg/s"', 'noises = "1e-4 deg/s"', "my.toml:3: gyros[1].noises: no such key of gyros[1]"),
    ],
)
def test_wrong_values_are_refused_at_their_line(read, old, new, message):
    with pytest.raises(SpacecraftFileError) as caught:
        read(OWN.replace(old, new))
    assert str(caught.value).startswith(message), caught.value


def test_wheels_have_none():
    text = 'name = "a"\nwheels = [{ at = "bus", axes = ["+x"], noise = 1 }]\ngyros = [{ at = "bus", axes = ["+x"] }]\n'
    with pytest.raises(SpacecraftFileError, match=r"my\.toml:2: wheels\[1\]\.noise: no such key"):
        parse_spacecraft(text, "my.toml")


def test_a_spacecraft_in_python_writes_them(read):
    gyros = tuple(replace(device, noise=1e-7, mounting_error=(1e-5, 0.0, 0.0)) for device in read(BUS).gyros[:2])
    craft = replace(configuration("centralised"), name="mine", release=None, gyros=gyros)
    assert file_of(craft).configurations["robust"].gyros == gyros
